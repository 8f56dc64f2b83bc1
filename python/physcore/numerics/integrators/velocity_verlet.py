"""Velocity Verlet method, the default."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


# Damping evaluated at the velocity of the step's end would not limit the step: ω dt < 2 at every ξ. Its errors are as
# large: in two periods at ω dt = 0.1, 1.7e-3 instead of 2.1e-3 at ξ = 0.1, and 1.9e-3 instead of 2.1e-3 at ξ = 1
# (benches/damping.py). But damped springs would then require the solution of a system of equations in each step.
@dataclass(frozen=True)
class VelocityVerlet(Integrator):
    """Velocity Verlet, order 2, one force evaluation: the default.

        recording = pc.simulate(scene, duration=0.5, integrator=pc.VelocityVerlet())

        x ← x + v dt + a dt²/2,   v ← v + (a + a_new) dt/2

    The method is symplectic and reversible: its energy error is bounded. Stable for ω dt < 2 without damping. A force
    that depends on velocity is evaluated at the predicted velocity v + a dt, which preserves order 2. Damping limits
    the step: at a damping ratio ξ to ω dt ≤ 2(√(4ξ² + 1) − 2ξ). This is 0.83 at ξ = 1/2 and 0.47 at ξ = 1, and tends to
    γ dt ≤ 1 for pure decay at the rate γ. If damping limits the step, SemiImplicitEuler allows steps about twice as
    long.

    Source: W. C. Swope, H. C. Andersen, P. H. Berens, K. R. Wilson, J. Chem. Phys. 76, 637 (1982).
    """

    order: ClassVar[int] = 2
    symplectic: ClassVar[bool] = True
    resolving: ClassVar[float] = 0.022
