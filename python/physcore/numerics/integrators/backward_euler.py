"""Backward Euler."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import number
from physcore.numerics.integrators.base import Integrator
from physcore.scene.items import Equation


@dataclass(frozen=True)
class BackwardEuler(Integrator):
    """Backward Euler, order 1, implicit: for what is stiff and comes to rest.

        pc.simulate(pc.Scene(cloth, pc.Gravity()), 5.0, integrator=pc.BackwardEuler(), dt=1 / 60)

        v ← v + dt F(x + dt v, v)/m at the end of the step,  x ← x + dt v

    An oscillation of frequency ω shrinks by 1/√(1 + ω² dt²) in each step: what steps do not resolve is gone at once,
    and slow motion is damped too. That damping is an error of the method, no dissipation, and shows as drift of the
    energy balance, always downwards.

    Newton's method with line search, its linear equations by conjugate gradients. A step whose equation is not solved
    raises SimulationDiverged, or is taken in parts with on_divergence="substep"; none is accepted that is not balanced.
    Stable with any step, for springs of any stiffness with damping, Gravity, Drag, CentralForce, LennardJones,
    SoftSpheres, Dihedral, Wind, exact sums of Gravitation and Coulomb, and boundaries; forces without known derivatives
    are refused by their names. A force that jumps, as where damped spheres touch, may have no solution at long steps.

    Args:
        tolerance: the largest unbalanced force over the largest force in the step, above 0.

    Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd ed., 1993, section
    II.7; D. Baraff, A. Witkin, SIGGRAPH 1998, 43.

    Raises:
        SceneError: `tolerance` is not above 0.
    """

    order: ClassVar[int] = 1
    symplectic: ClassVar[bool] = False
    stiff: ClassVar[bool] = True
    solves: ClassVar[tuple[Equation, ...]] = ("bodies",)

    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        object.__setattr__(self, "tolerance", number(self.tolerance, "BackwardEuler.tolerance", above=0.0))
