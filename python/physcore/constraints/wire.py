"""Wires: curves on which particles slide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from physcore._core import spline_points
from physcore.arithmetic import lengths
from physcore.checks import LONGEST, FloatArray, array, count, flag, frozen, number, require
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.by_value import ByValue
from physcore.scene.fields import Element
from physcore.scene.items import Constraint
from physcore.scene.targets import On

NEAREST = 1e-9
"""Least distance of neighboring points, relative to the length of the wire."""


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Wire(ByValue, Constraint):
    """Wire: a smooth curve on which particles slide as beads.

        turns = np.linspace(0.0, 2.0 * np.pi, 101)
        cycloid = np.column_stack([turns - np.sin(turns), np.cos(turns) - 1.0])
        beads = pc.Particles(cycloid[[10, 20, 40]], mass=0.1)
        wire = pc.Wire(cycloid, on=beads)
        recording = pc.simulate(pc.Scene(beads, wire, pc.Gravity((0.0, -9.81))), 2.0)
        recording[wire].force  # (F, n, D), on each bead [N]

    The curve is the cubic spline through the points, over the lengths of the sides of their polygon. An open curve has
    one cubic over its first two intervals and one over its last two (not-a-knot). The wire is fixed in space and pulls
    its beads across its direction, so that its force does no work without friction. The method is RATTLE for one
    constraint per particle: symplectic, reversible and of order 2 under VelocityVerlet. With friction it is of order 1.
    The energy that friction removes is listed as dissipated by "contacts".

    Beads are moved onto the curve at the start, and velocities across it are removed; the plan tells how much energy
    these had. A bead that reaches an end of an open wire stops the simulation. Nothing else may hold a bead: no rod, no
    strain limit, no boundary, no SelfContact and no second wire. Springs and all other forces act on it.

    Wires need VelocityVerlet, RATTLE, BackwardEuler, BDF2, XPBD or ProjectiveDynamics, and no Periodic domain. BDF2
    takes steps of backward Euler in scenes with wires. RATTLE(order=4) takes no friction, and is of order 4 only for
    steps that are short against the distance of the points: third derivatives of the curve jump there.

    Args:
        points: points of the curve [m], shape (K, D): at least two, or three for a closed wire. Neighbors differ.
        on: the bodies whose particles are beads, their names, or selections (body, indices); None: all bodies.
        closed: whether the curve returns from the last point to the first.
        friction: Coulomb's coefficient, at least zero.

    Raises:
        SceneError: a value is out of range. The simulation raises it if a particle is beside the wire by more than
            1e-4 of its length, is fixed, or is held by something else too.

    Source: H. C. Andersen, J. Comput. Phys. 52, 24 (1983); C. de Boor, "A Practical Guide to Splines", 1978.
    """

    selects: ClassVar[bool] = True
    spares_fluids: ClassVar[bool] = True
    spares_rigid_bodies: ClassVar[bool] = True
    element: ClassVar[Element | None] = "beads"

    points: FloatArray
    closed: bool
    friction: float

    def __init__(self, points: ArrayLike, *, on: On = None, closed: bool = False, friction: float = 0.0) -> None:
        values, whole = array(points, "Wire.points"), flag(closed, "Wire.closed")
        least = 3 if whole else 2
        if values.ndim != 2 or values.shape[1] not in (2, 3) or len(values) < least:
            raise SceneError(
                f"Wire.points: must have the shape (K, 2) or (K, 3) with at least {least} points, got {values.shape}"
            )
        require(np.abs(values) <= LONGEST, values, "Wire.points", f"at most {LONGEST:g} m in size")
        following = np.roll(values, -1, axis=0) if whole else values[1:]
        sides = lengths(following - values[: len(following)])
        near = sides <= NEAREST * sides.sum()
        if near.any():
            first = int(np.argmax(near))
            again = "; a closed wire returns to its first point by itself" if whole and first == len(values) - 1 else ""
            raise SceneError(f"Wire.points[{first}]: must differ from the next point by rounding at least{again}")
        self._set(points=frozen(values), closed=whole, friction=number(friction, "Wire.friction", least=0.0), on=on)
        self.__post_init__()

    @property
    def is_smooth(self) -> bool:
        """Whether the motion under the constraint is smooth, and costs little to resolve: without friction."""
        return self.friction == 0.0

    def curve(self, parts: int = 12) -> FloatArray:
        """Points of the curve [m], shape (S, D): `parts` in each interval between the given points, and the last one.

        x, y = pc.Wire([[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]).curve().T
        """
        points = np.zeros((len(self.points), 3))
        points[:, : self.points.shape[1]] = self.points
        return spline_points(points, self.closed, count(parts, "parts", least=1))[:, : self.points.shape[1]]

    def mismatch(self, dimension: int) -> tuple[str, int] | None:
        """The name and dimension of the points, if they do not have `dimension` components; otherwise None."""
        return None if self.points.shape[1] == dimension else ("points", self.points.shape[1])

    def check(self, bodies: Sequence[Body], path: str) -> None:
        """Raise if one of the bodies is a fluid, whose particles are no beads.

        Raises:
            SceneError: one of the bodies is a fluid.
        """
        fluid = next((body for body in bodies if body.is_fluid), None)
        if fluid is not None:
            raise SceneError(f"{path}.on: must be Particles or SpringNetworks, got {fluid!r}")
