"""Backward Euler method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.numerics.integrators.implicit import Implicit


@dataclass(frozen=True)
class BackwardEuler(Implicit):
    """Backward Euler, order 1, implicit: for stiff systems that come to rest.

        pc.simulate(pc.Scene(cloth, pc.Gravity()), 5.0, integrator=pc.BackwardEuler(), dt=1 / 60)

        v ← v + dt F(x + dt v, v)/m at the end of the step,  x ← x + dt v

    The amplitude of an oscillation of frequency ω shrinks by the factor 1/√(1 + ω² dt²) in each step. Unresolved
    oscillations vanish at once, and slow motion is damped too. This numerical damping is an error of the method, not
    dissipation. It appears as a drift of the energy balance, which is always negative.

    Each step is solved by Newton's method with line search and conjugate gradients. A step without a solution raises
    SimulationDiverged, or is divided with on_divergence="substep". An unbalanced step is never accepted. The method is
    stable at any step and any stiffness. It supports springs with damping, Gravity, Drag, CentralForce, LennardJones,
    SoftSpheres, Dihedral, Wind, exact sums of Gravitation and Coulomb, and boundaries. Other forces, whose derivatives
    are unknown, are refused by name. A discontinuous force, as at the contact of damped spheres, may have no solution
    at long steps.

    Args:
        tolerance: largest residual force relative to the largest force in the step, above 0.

    Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd ed., 1993, section
    II.7; D. Baraff, A. Witkin, SIGGRAPH 1998, 43.

    Raises:
        SceneError: `tolerance` is not above 0.
    """

    order: ClassVar[int] = 1
