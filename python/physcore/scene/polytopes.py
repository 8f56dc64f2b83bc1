"""Shapes of rigid bodies with corners: polygons, convex hulls, closed meshes; and compounds of shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from physcore._core import convex_hull
from physcore.arithmetic import dots, lengths
from physcore.checks import DIMENSIONS, LONGEST, FloatArray, IntArray, array, broadcast, items, regular, require, shown
from physcore.errors import SceneError
from physcore.scene.outlines import cross, crossing
from physcore.scene.rotations import unit_quaternions
from physcore.scene.solids import Ball, Capsule, Cuboid, Disc, PlanarShape, Rectangle, Shape, SpatialShape

FLAT = 1e-12
"""Least area of a polygon and least volume of a mesh, relative to their extent, and least sine of the angle between
sides that turn back.
"""

Placed: TypeAlias = tuple[Shape, ArrayLike] | tuple[Shape, ArrayLike, ArrayLike]
"""A shape, its position [m], and its angle [rad] or its orientation."""


@dataclass(frozen=True, eq=False, repr=False)
class Polygon(PlanarShape):
    """Polygon, the shape of a rigid body in 2D.

        wedge = pc.Polygon([(0.0, 0.0), (0.3, 0.0), (0.0, 0.1)])
        body = pc.RigidBody(wedge, (0.0, 1.0))
        wedge.center  # (0.1, 0.0333): the point of the polygon that is at the position of the body

    The vertices may have any origin. The position of a body is that of its center of mass.

    Args:
        vertices: vertices [m] in their order along the boundary, in either direction, shape (K, 2). The polygon need
            not be convex; it has no holes.

    Raises:
        SceneError: there are fewer than three vertices, the polygon crosses or touches itself or has no area, or a
            value is not finite.

    Source:
        Contacts of a polygon that is not convex are those of its convex parts: S. Hertel, K. Mehlhorn, "Fast
        triangulation of simple polygons", 1983.
    """

    vertices: FloatArray

    def __post_init__(self) -> None:
        points = _points(self.vertices, "Polygon.vertices", 2, 3)
        _check_polygon(points, "Polygon.vertices")
        self._set(vertices=points)


@dataclass(frozen=True, eq=False, repr=False)
class Hull(SpatialShape):
    """Convex hull of points, the shape of a rigid body in 3D.

        corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
        tetrahedron = pc.RigidBody(pc.Hull(0.1 * np.array(corners)), (0.0, 0.0, 1.0))

    The points may have any origin. The position of a body is that of its center of mass.

    Args:
        points: points [m], shape (K, 3). Points inside the hull have no effect.

    Raises:
        SceneError: the points span no volume, or a value is not finite.
    """

    points: FloatArray

    def __post_init__(self) -> None:
        points = _points(self.points, "Hull.points", 3, 4)
        if not convex_hull(points):
            raise SceneError("Hull.points: must span a volume, got points that are flat")
        self._set(points=points)


@dataclass(frozen=True, eq=False, repr=False)
class MeshShape(SpatialShape):
    """Solid within a closed mesh of triangles, the shape of a rigid body in 3D.

        corners = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]])
        solid = pc.MeshShape(corners, faces=[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
        solid.volume  # 1.67e-4 m³

    The vertices may have any origin. The position of a body is that of its center of mass.

    Args:
        vertices: vertices [m], shape (K, 3).
        faces: indices of the three corners of each triangle, shape (T, 3), in one direction as seen from outside.

    Raises:
        SceneError: the mesh is not closed, faces have different directions, it encloses no volume, an index is out of
            range, or a value is not finite.
    """

    is_part: ClassVar[bool] = False

    vertices: FloatArray
    faces: IntArray

    def __post_init__(self) -> None:
        points = _points(self.vertices, "MeshShape.vertices", 3, 4)
        faces = _faces(self.faces, len(points), "MeshShape.faces")
        _check_closed(faces, "MeshShape.faces")
        corners = points[faces] - points[0]
        parts = dots(corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
        if abs(parts.sum()) <= FLAT * np.abs(parts).sum():
            raise SceneError("MeshShape.vertices: must enclose a volume, got a mesh that is flat")
        self._set(vertices=points, faces=faces if parts.sum() > 0.0 else np.ascontiguousarray(faces[:, ::-1]))


@dataclass(frozen=True, eq=False, repr=False)
class Compound(Shape):
    """Several shapes as one rigid body.

        hammer = pc.Compound([(pc.Rectangle(0.04, 0.3), (0.0, 0.0)), (pc.Rectangle(0.12, 0.05), (0.0, 0.15), 0.1)])
        body = pc.RigidBody(hammer, (0.0, 1.0))
        hammer.center  # in the coordinates of the parts

    The position of a body is that of its center of mass. Where parts overlap, their masses add.

    Args:
        shapes: the parts: (shape, position) or (shape, position, angle) in 2D, (shape, position, orientation) in 3D.
            Or shapes alone, with the further arguments. A position [m] is that of the origin of the part's coordinates,
            an angle is in radians, an orientation is a quaternion (w, x, y, z).
        positions: positions of the parts [m], shape (P, D).
        angles: angles of the parts in 2D [rad], broadcast to (P,); None: 0.
        orientations: orientations of the parts in 3D, broadcast to (P, 4); None: those of the compound.

    Raises:
        SceneError: there is no part, a part is a Compound or a MeshShape, its dimension is another one, or a value is
            not finite.
    """

    is_part: ClassVar[bool] = False

    shapes: tuple[Shape, ...]
    positions: FloatArray
    angles: FloatArray | None
    orientations: FloatArray | None

    def __init__(
        self,
        shapes: Sequence[Placed] | Sequence[Shape],
        positions: ArrayLike | None = None,
        angles: ArrayLike | None = None,
        orientations: ArrayLike | None = None,
    ) -> None:
        given = items(shapes, "Compound.shapes", "(shape, position, angle)")
        if positions is None:
            if angles is not None or orientations is not None:
                raise SceneError("Compound.positions: must be given with angles or orientations")
            given, positions, turns = _taken_apart(given)
            planar = np.shape(positions)[-1] == 2
            angles, orientations = (turns, None) if planar else (None, turns)
        points = array(positions, "Compound.positions")
        if points.ndim != 2 or points.shape[1] not in DIMENSIONS or len(points) != len(given) or not given:
            raise SceneError(
                f"Compound.positions: must have the shape ({len(given)}, 2) or ({len(given)}, 3), one for each of at "
                f"least one part, got {points.shape}"
            )
        self._set(positions=points, shapes=tuple(given))
        for place, shape in enumerate(given):
            _check_part(shape, self.dimensions[0], f"Compound.shapes[{place}]")
        self._set_turns(angles, orientations)

    @property
    def dimensions(self) -> tuple[int, ...]:
        """The dimension of the positions."""
        return (int(self.positions.shape[1]),)

    def _set_turns(self, angles: ArrayLike | None, orientations: ArrayLike | None) -> None:
        """Check and set the angles or the orientations of the parts."""
        number, planar = len(self.shapes), self.dimensions == (2,)
        if (orientations if planar else angles) is not None:
            wrong, right = ("orientations", "angles [rad]") if planar else ("angles", "orientations (w, x, y, z)")
            raise SceneError(f"Compound.{wrong}: must be None in {self.dimensions[0]}D, which has {right}")
        turns = [0.0 if angles is None else angles, (1.0, 0.0, 0.0, 0.0) if orientations is None else orientations]
        self._set(
            angles=broadcast(turns[0], (number,), "Compound.angles") if planar else None,
            orientations=None if planar else unit_quaternions(turns[1], number, "Compound.orientations"),
        )


# To add a shape: a class, a line here, and its counterpart in Rust.
SHAPES: tuple[type[Shape], ...] = (Disc, Rectangle, Polygon, Capsule, Ball, Cuboid, Hull, MeshShape, Compound)
"""All shapes of rigid bodies. Those registered here can be saved and are tested."""


def _taken_apart(parts: list[Any]) -> tuple[list[Any], list[Any], list[Any] | None]:
    """The shapes, the positions and the angles or orientations of the parts of a compound; None if no part has any."""
    for place, part in enumerate(parts):
        if not isinstance(part, (tuple, list)) or len(part) not in (2, 3):
            raise SceneError(
                f"Compound.shapes[{place}]: must be (shape, position) or (shape, position, angle), got {shown(part)}"
            )
    places = [array(part[1], f"Compound.shapes[{place}][1]") for place, part in enumerate(parts)]
    for place, at in enumerate(places):
        if at.shape not in ((2,), (3,)) or at.shape != places[0].shape:
            raise SceneError(
                f"Compound.shapes[{place}][1]: must be a position in 2D or 3D, as of all parts, got {shown(at)}"
            )
    turns: list[Any] | None = None
    if any(len(part) == 3 for part in parts):
        none = 0.0 if places[0].shape == (2,) else (1.0, 0.0, 0.0, 0.0)
        turns = [part[2] if len(part) == 3 else none for part in parts]
        for place, turn in enumerate(turns):
            if np.shape(array(turn, f"Compound.shapes[{place}][2]")) != np.shape(none):
                kind = "an angle [rad]" if none == 0.0 else "an orientation (w, x, y, z)"
                raise SceneError(f"Compound.shapes[{place}][2]: must be {kind}, got {shown(turn)}")
    return [part[0] for part in parts], [at.tolist() for at in places], turns


def _check_part(shape: object, dimension: int, path: str) -> None:
    """Check that a shape can be a part of a compound in so many dimensions."""
    if not isinstance(shape, Shape):
        raise SceneError(f"{path}: must be a shape, such as Disc or Ball, got {shown(shape)}")
    if not shape.is_part:
        raise SceneError(f"{path}: must be a convex shape, got {shown(shape)}; give its parts instead")
    if dimension not in shape.dimensions:
        raise SceneError(f"{path}: must be a shape in {dimension}D like the positions, got {shown(shape)}")


def _points(value: ArrayLike, path: str, dimension: int, least: int) -> FloatArray:
    """Validated points (K, dimension), at least so many."""
    points = array(value, path)
    if points.ndim != 2 or points.shape[1] != dimension or len(points) < least:
        raise SceneError(
            f"{path}: must have the shape (K, {dimension}) with at least {least} points, got {points.shape}"
        )
    require(np.abs(points) <= LONGEST, points, path, f"at most {LONGEST:g} m in size")
    return points


def _check_polygon(points: FloatArray, path: str) -> None:
    """Check that a polygon has an area and does not cross itself."""
    sides = np.roll(points, -1, axis=0) - points
    before = np.roll(sides, 1, axis=0)
    again = lengths(sides) == 0.0
    if again.any():
        raise SceneError(
            f"{path}[{int(np.argmax(again))}]: must differ from the next vertex; the last one joins the first"
        )
    parts, box = cross(points - points[0], sides), np.ptp(points, axis=0)
    if np.abs(parts).max() <= FLAT * dots(box, box):
        raise SceneError(f"{path}: must have an area, got vertices on a line")
    turns, least = cross(before, sides), FLAT * lengths(sides) * lengths(before)
    forward = np.sign(sides[sides[:, 0] != 0.0, 0])
    bends = parts.sum() == 0.0 or (np.sign(parts.sum()) * turns <= -least).any()
    if not bends and np.count_nonzero(forward != np.roll(forward, 1)) == 2:
        return  # convex
    back = (np.abs(turns) <= least) & (dots(before, sides) < 0.0)
    if back.any():
        raise SceneError(f"{path}[{int(np.argmax(back))}]: must not be the end of a spike, where a side turns back")
    met = crossing(points)
    if met is not None:
        ends = [f"{side} (from vertex {side} to {(side + 1) % len(points)})" for side in met]
        raise SceneError(f"{path}: must not cross itself, but the edges {ends[0]} and {ends[1]} meet")


def _faces(value: ArrayLike, number: int, path: str) -> IntArray:
    """Validated indices of the corners of triangles (T, 3)."""
    given = regular(value, path)
    if given.dtype.kind not in "iu" or given.ndim != 2 or given.shape[1] != 3 or len(given) < 4:
        raise SceneError(
            f"{path}: must be integers of shape (T, 3), at least 4, got {given.dtype} of shape {given.shape}"
        )
    outside = (given < 0) | (given >= number)
    if outside.any():
        row, column = np.argwhere(outside)[0]
        raise SceneError(f"{path}[{row}, {column}]: index {given[row, column]} is outside of the {number} vertices")
    faces = np.array(given, dtype=np.int64, order="C")
    twice = (np.diff(np.sort(faces, axis=1), axis=1) == 0).any(axis=1)
    if twice.any():
        raise SceneError(f"{path}[{int(np.argmax(twice))}]: must have three different corners")
    return faces


def _check_closed(faces: IntArray, path: str) -> None:
    """Check that each edge belongs to two triangles, which pass it in opposite directions."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    directed, counts = np.unique(edges, axis=0, return_counts=True)
    if (counts > 1).any():
        start, end = directed[np.argmax(counts > 1)]
        raise SceneError(
            f"{path}: must have one direction as seen from outside, but two pass the edge from vertex {start} to {end}"
        )
    both, counts = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    if (counts != 2).any():
        start, end = both[np.argmax(counts != 2)]
        raise SceneError(
            f"{path}: must be a closed surface, but one face alone has the edge of the vertices {start} and {end}"
        )
