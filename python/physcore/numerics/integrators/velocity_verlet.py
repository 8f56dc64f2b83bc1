"""Velocity Verlet, the default."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class VelocityVerlet(Integrator):
    """Velocity Verlet, order 2, one force evaluation: the default.

        recording = pc.simulate(scene, duration=0.5, integrator=pc.VelocityVerlet())

        x ← x + v dt + a dt²/2,   v ← v + (a + a_new) dt/2

    Symplectic and reversible: its energy error stays bounded. Stable for ω dt < 2 without damping. A force that depends
    on velocity is evaluated at the predicted velocity v + a dt, which keeps order 2, but damping limits the step: at a
    damping ratio ξ to ω dt ≤ 2(√(4ξ² + 1) − 2ξ), which is 0.83 at ξ = 1/2 and 0.47 at ξ = 1, and tends to γ dt ≤ 1 for
    pure decay at the rate γ. Where damping limits the step, SemiImplicitEuler bears about twice as much.

    Taken at the velocity of the step's end, damping would not limit the step: ω dt < 2 at every ξ, with errors as large
    (in two periods at ω dt = 0.1: 1.7e-3 for 2.1e-3 at ξ = 0.1, 1.9e-3 for 2.1e-3 at ξ = 1; benches/damping.py). But
    damped springs then ask for the solution of a system of equations in each step.

    Source: W. C. Swope, H. C. Andersen, P. H. Berens, K. R. Wilson, J. Chem. Phys. 76, 637 (1982).
    """

    order: ClassVar[int] = 2
    symplectic: ClassVar[bool] = True
