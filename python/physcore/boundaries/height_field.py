"""Height field: ground whose height is given at the nodes of a grid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from physcore import memory
from physcore.boundaries.ground import ground_mesh, ground_polygon
from physcore.checks import LONGEST, FloatArray, array, called, frozen, items, number, require, shown, span
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.items import Boundary
from physcore.scene.rigid import RigidBody
from physcore.scene.targets import On

COPIES = 12
"""Peak memory in arrays of the size of the heights: coordinates, the results of the function, and checks."""


@dataclass(frozen=True, eq=False, init=False, repr=False)
class HeightField(Boundary):
    """Height field: ground whose height is given at the nodes of a uniform grid. Particles stay above it.

        x = 0.1 * np.arange(31)
        hills = pc.HeightField(0.2 * np.cos(4.0 * x), spacing=0.1, friction=0.2)
        scene = pc.Scene(pc.Particles([[0.5, 1.0]], radius=0.05), pc.Gravity((0.0, -9.81)), hills)

    Up is the last axis, as for Floor. The ground is linear between the nodes. In 2D it is a polyline; in 3D each cell
    has two triangles, which meet along its higher diagonal. The ground ends at the border of the grid, in vertical
    sides of infinite depth. A particle of radius r meets an edge as a cylinder and a peak as a sphere, both of radius
    r. The edges between coplanar cells have no effect. A height field cannot bound fluids; its `solid` can.

    Args:
        heights: heights of the nodes [m]: shape (nx,) in 2D, indexed [i]; shape (nx, ny) in 3D, indexed [i, j] along
            x and y as fields on a Grid. At least two nodes along each axis. `HeightField.over` takes a function.
        spacing: the distance between neighboring nodes [m].
        origin: the lower corner of the grid, node [0] or [0, 0] [m]: x in 2D, x and y in 3D. A single number is used
            for both.
        restitution, friction, no_slip, on: as in Boundary.

    Raises:
        SceneError: there are fewer than two nodes along an axis, or a value is out of range or not finite. Scene
            raises it if the height field acts on a fluid.
    """

    heights: FloatArray
    spacing: float
    origin: tuple[float, ...]

    def __init__(
        self,
        heights: ArrayLike,
        spacing: float,
        origin: float | tuple[float, ...] = 0.0,
        *,
        restitution: float = 1.0,
        friction: float = 0.0,
        no_slip: bool = False,
        on: On = None,
    ) -> None:
        values = array(heights, "HeightField.heights")
        if values.ndim not in (1, 2) or min(values.shape) < 2:
            raise SceneError(
                "HeightField.heights: must have the shape (nx,) in 2D or (nx, ny) in 3D with at least two nodes along "
                f"each axis, got {values.shape}"
            )
        require(np.abs(values) <= LONGEST, values, "HeightField.heights", f"at most {LONGEST:g} m in size")
        step = span(spacing, "HeightField.spacing")
        corner = _place(origin, values.ndim, "HeightField.origin")
        self._set(heights=frozen(values), spacing=step, origin=corner)
        self._set(restitution=restitution, friction=friction, no_slip=no_slip, on=on)
        self.__post_init__()

    @classmethod
    def over(
        cls,
        function: Callable[..., ArrayLike],
        lower: float | tuple[float, ...],
        upper: float | tuple[float, ...],
        spacing: float,
        *,
        restitution: float = 1.0,
        friction: float = 0.0,
        no_slip: bool = False,
        on: On = None,
    ) -> Self:
        """Sample the height of the ground from a function over an interval (2D) or a rectangle (3D).

            bowl = pc.HeightField.over(lambda x, y: 0.5 * (x * x + y * y), (-1.0, -1.0), (1.0, 1.0), spacing=0.05)

        Args:
            function: the height [m] at coordinates [m], f(x) in 2D or f(x, y) in 3D. The coordinates are arrays of
                equal
                shape.
            lower, upper: corners [m]: x in 2D, (x, y) in 3D.
            spacing: the distance between nodes [m]. If an extent is not a multiple of the spacing, the last node
                differs
                from `upper` by at most half a spacing.
            restitution, friction, no_slip, on: as in Boundary.

        Raises:
            SceneError: an extent is less than one cell, the nodes take more memory than is free, the function fails, or
                a value is out of range or not finite.
        """
        step = span(spacing, "HeightField.spacing")
        low, high = (
            np.atleast_1d(array(value, f"HeightField.{name}"))
            for name, value in {"lower": lower, "upper": upper}.items()
        )
        if low.shape != high.shape or low.shape not in [(1,), (2,)]:
            raise SceneError(
                f"HeightField.upper: must be x in 2D, (x, y) in 3D, as the lower corner {shown(lower)}, "
                f"got {shown(upper)}"
            )
        cells = np.rint((high - low) / step)
        if not ((cells >= 1.0) & (cells < 2.0**31)).all():
            raise SceneError(
                f"HeightField.upper: must be 1 to {2**31} spacings of {step:g} m above the lower corner along each "
                f"axis, got {shown(upper)}"
            )
        count = float(np.prod(cells + 1.0))
        memory.require(COPIES * 8.0 * count, f"{count:.4g} nodes", "HeightField.spacing", "make it larger")
        axes = [
            start + step * np.arange(n + 1) for start, n in zip(low.tolist(), cells.astype(int).tolist(), strict=True)
        ]
        nodes = np.meshgrid(*axes, indexing="ij")
        given = array(called(function, "HeightField.function", *nodes), "HeightField.function")
        try:
            heights = np.broadcast_to(given, nodes[0].shape)
        except ValueError:
            raise SceneError(
                f"HeightField.function: must give an array of the shape {nodes[0].shape}, got the shape {given.shape}"
            ) from None
        shared = {"restitution": restitution, "friction": friction, "no_slip": no_slip, "on": on}
        return cls(heights, step, tuple(low.tolist()), **shared)  # type: ignore[arg-type]

    def __repr__(self) -> str:
        return f"HeightField({' x '.join(map(str, self.heights.shape))} nodes, {self.spacing:g} m apart)"

    @property
    def dimension(self) -> int:
        """The dimension of space, 2 or 3."""
        return self.heights.ndim + 1

    @property
    def nodes(self) -> FloatArray:
        """The nodes [m], shape (nx, 2) in 2D or (nx, ny, 3) in 3D."""
        counts = self.heights.shape
        axes = [start + self.spacing * np.arange(n) for start, n in zip(self.origin, counts, strict=True)]
        return np.stack([*np.meshgrid(*axes, indexing="ij"), self.heights], axis=-1)

    def solid(
        self, depth: float, *, friction: float = 0.0, restitution: float = 1.0, name: str | None = None
    ) -> RigidBody:
        """The ground as a fixed rigid body, on which fluids rest too.

            x = 0.1 * np.arange(11)
            bed = pc.HeightField(0.3 * (x - 0.5) ** 2, spacing=0.1).solid(depth=0.2)
            water = pc.Fluid(pc.block((0.3, 0.1), (0.7, 0.3), 0.04), 0.04)
            scene = pc.Scene(water, bed, pc.Gravity((0.0, -9.81)))

        It has the surface of the height field, and ends at upright sides and at a level base.

        Args:
            depth: distance of the base below the lowest node [m], above zero.
            friction, restitution, name: as in RigidBody.

        Raises:
            SceneError: a value is out of range.
        """
        base = float(self.heights.min()) - span(depth, "solid.depth")
        shape = ground_polygon(self.nodes, base) if self.heights.ndim == 1 else ground_mesh(self.nodes, base)
        center = shape.properties(self.dimension).center
        return RigidBody(shape, center, fixed=True, friction=friction, restitution=restitution, name=name)

    def check(self, bodies: Sequence[Body], path: str) -> None:
        """Raise if one of the bodies is a fluid. Fluids need mirror images at walls, which a curved surface does not
        have.

        Raises:
            SceneError: one of the bodies is a fluid.
        """
        fluid = next((body for body in bodies if body.is_fluid), None)
        if fluid is not None:
            raise SceneError(
                f"{path}.on: a height field is no wall of fluids, got {fluid!r}; let the fluid rest on "
                "ground.solid(depth), planes, boxes or convex hulls, and name other bodies here (on=…)"
            )

    def mismatch(self, dimension: int) -> tuple[str, int] | None:
        """The name and dimension of the heights, if the ground does not have `dimension` dimensions; otherwise None."""
        return None if self.dimension == dimension else ("heights", self.dimension)


def _place(value: object, axes: int, path: str) -> tuple[float, ...]:
    """The coordinates of a corner along the horizontal axes, from one number for all axes or one for each."""
    if not isinstance(value, (tuple, list, np.ndarray)):
        return (number(value, path, least=-LONGEST, most=LONGEST),) * axes
    each = items(value, path, "numbers, one for each horizontal axis")
    if len(each) != axes:
        raise SceneError(f"{path}: must be one number, or {axes}, one for each horizontal axis, got {shown(value)}")
    return tuple(number(entry, f"{path}[{axis}]", least=-LONGEST, most=LONGEST) for axis, entry in enumerate(each))
