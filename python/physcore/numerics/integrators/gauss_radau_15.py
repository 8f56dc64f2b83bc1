"""Gauss–Radau collocation of order 15."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import number
from physcore.numerics.integrators.base import Integrator
from physcore.scene.items import Equation


@dataclass(frozen=True)
class GaussRadau15(Integrator):
    """Gauss–Radau collocation, order 15, with steps of its own choice: IAS15.

        stars = pc.Particles([[0, 0], [1, 0]], velocities=[[0, -0.5], [0, 0.5]])
        pc.simulate(pc.Scene(stars, pc.Gravitation(1.0)), 100.0, integrator=pc.GaussRadau15())

    The acceleration over a step is a polynomial of degree 7 through its values at the step's start and at the seven
    nodes of the Gauss–Radau quadrature; positions and velocities there follow from it, so that it is found by
    iteration. The steps before predict it: two or three iterations of seven force evaluations are enough.

    With dt="auto" the step follows the motion: dt ← dt (tolerance/error)^(1/7), where the error is the largest last
    coefficient |b₆| over the largest acceleration of all bodies. At the default tolerance the error of a step is below
    rounding, and positions and velocities are summed with their low-order parts: what is left grows from rounding
    alone, the energy error like the square root of the number of steps. So orbits, close encounters and any other
    smooth motion, also with forces that depend on velocity, are as accurate as double precision allows. Steps end
    exactly at each frame and at the end of a run. A number as dt is a fixed step, AdaptiveStep() follows the limit.

    For bodies alone, in double precision. Not for boundaries and fluids, and no gain where forces have kinks, as those
    of SoftSpheres. Not symplectic. With a fixed step the iterations converge to rounding for ω dt < 2.6 without damping
    and for λ dt < 0.22 on pure decay.

    Args:
        tolerance: the largest |b₆| over |a|, above 0; for dt="auto". The error is far smaller: at 1e-9 some 1e-19 of
            the energy of an orbit in a step. Take 1e-11, at twice the steps, for more than 1e5 orbits. One below the
            rounding of b₆, 1.3e-12 and more where bodies meet far from the origin, is raised to that.

    Source: H. Rein, D. S. Spiegel, Mon. Not. R. Astron. Soc. 446, 1424 (2015).

    Raises:
        SceneError: `tolerance` is out of range.
    """

    order: ClassVar[int] = 15
    symplectic: ClassVar[bool] = False
    solves: ClassVar[tuple[Equation, ...]] = ("bodies",)
    self_adaptive: ClassVar[bool] = True

    tolerance: float = 1e-9

    def __post_init__(self) -> None:
        object.__setattr__(self, "tolerance", number(self.tolerance, "GaussRadau15.tolerance", above=0.0))
