"""The implicit midpoint rule."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import number
from physcore.numerics.integrators.base import Integrator
from physcore.scene.items import Equation


@dataclass(frozen=True)
class ImplicitMidpoint(Integrator):
    """The implicit midpoint rule, order 2, symplectic: for stiff motion that goes on.

        pc.simulate(pc.Scene(cloth, pc.Gravity()), 5.0, integrator=pc.ImplicitMidpoint(), dt=2e-3)

        x' − x = dt (v + v')/2,  v' − v = dt F((x + x')/2, (v + v')/2)/m

    It damps nothing: oscillations that steps do not resolve go on with a wrong period, and turn by half a period in a
    step as ω dt grows. Reversible; momentum and angular momentum are kept.

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

    order: ClassVar[int] = 2
    symplectic: ClassVar[bool] = True
    stiff: ClassVar[bool] = True
    solves: ClassVar[tuple[Equation, ...]] = ("bodies",)

    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        object.__setattr__(self, "tolerance", number(self.tolerance, "ImplicitMidpoint.tolerance", above=0.0))
