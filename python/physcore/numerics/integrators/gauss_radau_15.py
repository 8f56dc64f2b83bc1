"""Gauss–Radau collocation of order 15."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import number
from physcore.numerics.integrators.base import Integrator


@dataclass(frozen=True)
class GaussRadau15(Integrator):
    """Gauss–Radau collocation, order 15, with its own choice of steps (IAS15).

        stars = pc.Particles([[0, 0], [1, 0]], velocities=[[0, -0.5], [0, 0.5]])
        pc.simulate(pc.Scene(stars, pc.Gravitation(1.0)), 100.0, integrator=pc.GaussRadau15())

    The acceleration over a step is a polynomial of degree 7. It interpolates the values at the start of the step and at
    the seven nodes of the Gauss–Radau quadrature. Positions and velocities at the nodes depend on the polynomial, which
    is therefore found by iteration. Earlier steps predict it, so that two or three iterations of seven force
    evaluations suffice.

    With dt="auto" the step follows the motion: dt ← dt (tolerance/error)^(1/7). The error is the largest last
    coefficient |b₆| over the largest acceleration of all bodies. At the default tolerance the error of a step is below
    rounding. Positions and velocities are sums with compensation, so that only rounding errors remain. The energy error
    grows like the square root of the number of steps. Smooth motion is thus as accurate as double precision allows,
    including orbits, close encounters and forces that depend on velocity. Steps end exactly at each frame and at the
    end of a run. A number as dt is a fixed step; AdaptiveStep() follows the limit of stability.

    The method supports only bodies, in double precision, without boundaries and fluids. It has no advantage for forces
    with kinks, such as SoftSpheres. It is not symplectic. With a fixed step the iterations converge to rounding for ω
    dt < 2.6 without damping, and for λ dt < 0.22 for pure decay.

    Args:
        tolerance: largest |b₆| over |a|, above 0; for dt="auto". The error is far smaller: at 1e-9 it is about 1e-19 of
            the energy of an orbit per step. For more than 1e5 orbits use 1e-11, with twice as many steps. A tolerance
            below the rounding error of b₆ is raised to it: 1.3e-12, and more if bodies meet far from the origin.

    Source: H. Rein, D. S. Spiegel, Mon. Not. R. Astron. Soc. 446, 1424 (2015).

    Raises:
        SceneError: `tolerance` is out of range.
    """

    order: ClassVar[int] = 15
    symplectic: ClassVar[bool] = False
    self_adaptive: ClassVar[bool] = True

    tolerance: float = 1e-9

    def __post_init__(self) -> None:
        object.__setattr__(self, "tolerance", number(self.tolerance, "GaussRadau15.tolerance", above=0.0))
