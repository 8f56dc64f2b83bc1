"""The pair of Bogacki and Shampine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator
from physcore.scene.items import Equation


@dataclass(frozen=True)
class BogackiShampine3(Integrator):
    """Bogacki–Shampine 3(2), order 3, three force evaluations, with an estimate of the error of each step.

        recording = pc.simulate(scene, 0.5, integrator=pc.BogackiShampine3(), dt=pc.AdaptiveStep(tolerance=1e-4))

        k₂ = f(y + k₁ dt/2),  k₃ = f(y + 3 k₂ dt/4),  y ← y + (2 k₁ + 3 k₂ + 4 k₃) dt/9,  k₄ = f(y),   y = (x, v)
        error = (−5 k₁ + 6 k₂ + 8 k₃ − 9 k₄) dt/72

    k₄ is the k₁ of the next step. For motion that friction or drag brings to rest: with AdaptiveStep(tolerance=…) the
    time step follows the error. For errors below a hundredth DormandPrince5 takes fewer evaluations. It keeps order 3
    with forces that depend on velocity. Not symplectic: it loses energy slowly and for ever. Stable for ω dt < √3
    without damping, and for λ dt < 2.512 on pure decay.

    Source: P. Bogacki, L. F. Shampine, Appl. Math. Lett. 2, 321 (1989).
    """

    order: ClassVar[int] = 3
    symplectic: ClassVar[bool] = False
    embedded: ClassVar[bool] = True
    solves: ClassVar[tuple[Equation, ...]] = ("bodies", "second order", "first order")
