"""Semi-implicit (symplectic) Euler method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class SemiImplicitEuler(Integrator):
    """Semi-implicit (symplectic) Euler, order 1, one force evaluation.

        recording = pc.simulate(scene, duration=0.5, integrator=pc.SemiImplicitEuler())

        v ← v + a(x, v) dt,   x ← x + v dt   (with the new velocity)

    The method is symplectic: its energy error is bounded. Stable for ω dt < 2 without damping, and for ω dt ≤ 2(√(ξ² +
    1) − ξ) at the damping ratio ξ. For pure decay at the rate γ the limit is γ dt ≤ 2.

    Source: E. Hairer, C. Lubich, G. Wanner, "Geometric Numerical Integration", 2nd ed. 2006, § I.1.2.
    """

    order: ClassVar[int] = 1
    symplectic: ClassVar[bool] = True
