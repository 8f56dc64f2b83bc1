"""Explicit Euler method, for teaching."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class ExplicitEuler(Integrator):
    """Explicit Euler, order 1, one force evaluation: for teaching, not for practical use.

        ball = pc.Particles([[0.0, 1.0]], velocities=[[1.0, 2.0]])
        recording = pc.simulate(pc.Scene(ball, pc.Gravity()), duration=1.0, integrator=pc.ExplicitEuler(), dt=1e-3)

        x ← x + v dt,   v ← v + a(x, v) dt   (both from the old state)

    The energy of every undamped oscillation grows at any time step, so that orbits spiral out. The limit of stability
    is zero without damping, and ω dt ≤ 2ξ at a damping ratio ξ up to 1. Use SemiImplicitEuler or VelocityVerlet, which
    have the same cost.

    Source: L. Euler, "Institutionum calculi integralis", 1768; E. Hairer, C. Lubich, G. Wanner, "Geometric Numerical
    Integration", 2nd ed. 2006, § I.1.
    """

    order: ClassVar[int] = 1
    symplectic: ClassVar[bool] = False
