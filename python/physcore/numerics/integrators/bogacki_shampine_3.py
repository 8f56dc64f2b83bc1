"""Bogacki–Shampine pair."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class BogackiShampine3(Integrator):
    """Bogacki–Shampine 3(2), order 3, three force evaluations, with an error estimate of each step.

        recording = pc.simulate(scene, 0.5, integrator=pc.BogackiShampine3(), dt=pc.AdaptiveStep(tolerance=1e-4))

        k₂ = f(y + k₁ dt/2),  k₃ = f(y + 3 k₂ dt/4),  y ← y + (2 k₁ + 3 k₂ + 4 k₃) dt/9,  k₄ = f(y),   y = (x, v)
        error = (−5 k₁ + 6 k₂ + 8 k₃ − 9 k₄) dt/72

    k₄ is the k₁ of the next step. The method suits motion that friction or drag brings to rest. With
    AdaptiveStep(tolerance=…) the time step follows the error estimate. For errors below a hundredth, DormandPrince5
    needs fewer evaluations. The order remains 3 with forces that depend on velocity. The method is not symplectic: it
    loses energy slowly and without limit. Stable for ω dt < √3 without damping, and for λ dt < 2.512 for pure decay.

    Source: P. Bogacki, L. F. Shampine, Appl. Math. Lett. 2, 321 (1989).
    """

    order: ClassVar[int] = 3
    symplectic: ClassVar[bool] = False
    resolving: ClassVar[float] = 0.07
    embedded: ClassVar[bool] = True
