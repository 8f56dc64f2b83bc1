"""The backward differentiation formula of order 2."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import number
from physcore.numerics.integrators.base import Integrator
from physcore.scene.items import Equation


@dataclass(frozen=True)
class BDF2(Integrator):
    """The backward differentiation formula of order 2, implicit: for what is stiff, damped less than by BackwardEuler.

        pc.simulate(pc.Scene(cloth, pc.Gravity()), 5.0, integrator=pc.BDF2(), dt=1 / 60)

        3x'/2 − 2x + x₋/2 = dt v',  3v'/2 − 2v + v₋/2 = dt F(x', v')/m

    From the last two states; the first step, and one after another step size or a contact, is backward Euler's.
    Oscillations that steps do not resolve are gone at once, slow ones lose little. That damping is an error of the
    method, no dissipation, and shows as drift of the energy balance.

    Newton's method with line search, its linear equations by conjugate gradients. A step whose equation is not solved
    raises SimulationDiverged, or is taken in parts with on_divergence="substep"; none is accepted that is not balanced.
    Stable with any step, for springs of any stiffness with damping, Gravity, Drag, CentralForce, LennardJones,
    SoftSpheres, Dihedral, Wind, exact sums of Gravitation and Coulomb, and boundaries; forces without known derivatives
    are refused by their names. A force that jumps, as where damped spheres touch, may have no solution at long steps.

    Args:
        tolerance: the largest unbalanced force over the largest force in the step, above 0.

    Source: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd ed., 1993, section
    III.1; D. Baraff, A. Witkin, SIGGRAPH 1998, 43.

    Raises:
        SceneError: `tolerance` is not above 0.
    """

    order: ClassVar[int] = 2
    symplectic: ClassVar[bool] = False
    stiff: ClassVar[bool] = True
    solves: ClassVar[tuple[Equation, ...]] = ("bodies",)

    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        object.__setattr__(self, "tolerance", number(self.tolerance, "BDF2.tolerance", above=0.0))
