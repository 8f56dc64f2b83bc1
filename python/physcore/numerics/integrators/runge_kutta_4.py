"""Classical Runge–Kutta method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class RungeKutta4(Integrator):
    """Classical Runge–Kutta method, order 4, four force evaluations.

        recording = pc.simulate(scene, duration=0.5, integrator=pc.RungeKutta4())

        k₁ = f(y),  k₂ = f(y + k₁ dt/2),  k₃ = f(y + k₂ dt/2),  k₄ = f(y + k₃ dt)
        y ← y + (k₁ + 2 k₂ + 2 k₃ + k₄) dt/6,   y = (x, v)

    The method is not symplectic: it loses energy slowly and without limit. In conservative scenes PEFRL is better at
    equal cost. The order remains 4 with forces that depend on velocity. Stable for ω dt < 2√2 without damping, and for
    λ dt < 2.785 for pure decay.

    Source: W. Kutta, Z. Math. Phys. 46, 435 (1901); E. Hairer, S. Nørsett, G. Wanner, "Solving Ordinary Differential
    Equations I", § II.1.
    """

    order: ClassVar[int] = 4
    symplectic: ClassVar[bool] = False
    resolving: ClassVar[float] = 0.11
