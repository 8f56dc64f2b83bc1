"""Shapes in 2D as polygons: the triangles of their faces, their rims and their marks."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from physcore.checks import BoolArray, FloatArray, IntArray
from physcore.film.shapes.parts import parts_of
from physcore.scene.outlines import area, cross
from physcore.scene.polytopes import Polygon
from physcore.scene.solids import Capsule, Disc, Rectangle, Shape

SAGITTA = 0.12
"""Largest deviation of an arc from a circle [pixels]."""
FINEST = 24
"""Largest number of segments of a quarter of a circle."""
OUTSIDE = 1e-9
"""Distance of points just outside of a side, relative to the size of a part."""
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
"""Corners of a square, counterclockwise."""


@dataclass(frozen=True, eq=False)
class Core:
    """All points within a radius of a convex polygon, which has one vertex for a disc and two for a capsule."""

    vertices: FloatArray
    """Vertices in counterclockwise order [m], shape (K, 2)."""
    radius: float

    def polygon(self, quarter: int) -> FloatArray:
        """The outline (K, 2), counterclockwise, with so many segments for each quarter of a circle."""
        if self.radius == 0.0:
            return self.vertices
        count = len(self.vertices)
        if count == 1:
            turns = np.arange(4 * quarter) * (0.5 * np.pi / quarter)
            return self.vertices + self.radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        sides = _sides(self.vertices)
        headings = np.arctan2(sides[:, 1], sides[:, 0]) - 0.5 * np.pi
        arcs = []
        for vertex, before, after in zip(self.vertices, np.roll(headings, 1), headings, strict=True):
            turn = (after - before) % (2.0 * np.pi)
            steps = before + np.linspace(0.0, turn, 1 + max(1, math.ceil(quarter * turn / (0.5 * np.pi) - 1e-9)))
            arcs.append(vertex + self.radius * np.stack([np.cos(steps), np.sin(steps)], axis=1))
        return np.concatenate(arcs)


CORES: dict[type[Shape], Callable[[Any], list[Core]]] = {
    Disc: lambda disc: [Core(np.zeros((1, 2)), disc.radius)],
    Rectangle: lambda box: [Core(0.5 * np.array([box.width, box.height]) * SQUARE, 0.0)],
    Capsule: lambda capsule: [Core(0.5 * capsule.length * np.array([[-1.0, 0.0], [1.0, 0.0]]), capsule.radius)],
    Polygon: lambda polygon: [Core(part, 0.0) for part in convex_parts(counterclockwise(polygon.vertices))],
}
"""Convex cores of each class of shapes in 2D, in its own coordinates."""


@dataclass(frozen=True, eq=False)
class Face:
    """Drawing of a shape at some scale, about its center of mass."""

    points: FloatArray
    """Points of triangles and rims [m], shape (P, 2)."""
    triangles: IntArray
    """Corners of the triangles that fill the shape, shape (T, 3)."""
    painted: IntArray
    """Corners of the triangles of the mark, shape (M, 3)."""
    rim: IntArray
    """Ends of the segments of the outline, shape (S, 2)."""


def cores_of(shape: Shape) -> list[Core]:
    """The convex cores of a shape, about its center of mass."""
    cores = []
    for part in parts_of(shape, 2):
        cores += [Core(part.placed(core.vertices), core.radius) for core in CORES[type(part.shape)](part.shape)]
    return cores


def reach_of(cores: Sequence[Core]) -> float:
    """The largest distance of a point of a shape from its center of mass [m]."""
    return max(float(np.sqrt((core.vertices**2).sum(axis=1)).max()) + core.radius for core in cores)


def segments_of(radius: float, scale: float) -> int:
    """The number of segments of a quarter of a circle with a radius [m], at a scale [pixels/m].

    The sagitta of one of q segments of a quarter circle is r (1 − cos(π/4q)) ≈ π² r / 32 q².
    """
    return min(max(math.ceil(math.pi * math.sqrt(radius * scale / (32.0 * SAGITTA))), 2), FINEST)


def face_of(cores: Sequence[Core], scale: float) -> Face:
    """The face of a shape at a scale [pixels/m]."""
    polygons = [core.polygon(segments_of(core.radius, scale)) for core in cores]
    points, triangles, painted, rims, count = [], [], [], [], 0
    heading = _heading(cores)
    for polygon in polygons:
        points.append(polygon)
        triangles.append(count + _fan(len(polygon)))
        count += len(polygon)
        for half in _marked(polygon, heading, len(cores) == 1 and len(cores[0].vertices) == 1):
            points.append(half)
            painted.append(count + _fan(len(half)))
            count += len(half)
    for index, polygon in enumerate(polygons):
        others = polygons[:index] + polygons[index + 1 :]
        ends = np.stack([polygon, np.roll(polygon, -1, axis=0)], axis=1)
        left = outer_parts(ends, others) if others else ends
        points.append(left.reshape(-1, 2))
        rims.append(count + np.arange(2 * len(left)).reshape(-1, 2))
        count += 2 * len(left)
    none = np.empty((0, 3), dtype=np.int64)
    return Face(
        np.concatenate(points), np.concatenate(triangles), np.concatenate([none, *painted]), np.concatenate(rims)
    )


def outer_parts(segments: FloatArray, polygons: Sequence[FloatArray]) -> FloatArray:
    """The parts of sides (S, 2, 2) of a counterclockwise polygon that bound its union with other convex polygons.

    A point of a side bounds the union if the points just outside of it are in no other polygon.
    """
    for polygon in polygons:
        start, way = segments[:, 0], segments[:, 1] - segments[:, 0]
        shifted = start + OUTSIDE * float(np.ptp(polygon, axis=0).max()) * _outward(way)
        normals = _outward(_sides(polygon))
        heights, rates = shifted @ normals.T - (polygon * normals).sum(axis=1), way @ normals.T
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = -heights / rates
        never = (rates == 0.0) & (heights > 0.0)
        first = np.where(rates < 0.0, crossing, np.where(never, np.inf, 0.0)).max(axis=1).clip(0.0, 1.0)
        last = np.where(rates > 0.0, crossing, np.where(never, -np.inf, 1.0)).min(axis=1).clip(0.0, 1.0)
        first = np.where(first >= last, 1.0, first)
        last = np.where(first >= last, 1.0, last)
        before = np.stack([start, start + first[:, np.newaxis] * way], axis=1)[first > OUTSIDE]
        after = np.stack([start + last[:, np.newaxis] * way, segments[:, 1]], axis=1)[last < 1.0 - OUTSIDE]
        segments = np.concatenate([before, after])
    return segments


def _outward(ways: FloatArray) -> FloatArray:
    """Unit normals (S, 2) to the right of directions (S, 2)."""
    normals = np.stack([ways[:, 1], -ways[:, 0]], axis=1)
    result: FloatArray = normals / np.maximum(np.hypot(*normals.T), 1e-300)[:, np.newaxis]
    return result


def clipped(polygon: FloatArray, normal: FloatArray) -> FloatArray:
    """The part (K, 2) of a convex polygon on the side of a line through the origin to which `normal` points."""
    heights = polygon @ normal
    result = []
    for index, (point, height) in enumerate(zip(polygon, heights, strict=True)):
        if height >= 0.0:
            result.append(point)
        after = (index + 1) % len(polygon)
        if (height >= 0.0) != (heights[after] >= 0.0):
            share = height / (height - heights[after])
            result.append(point + share * (polygon[after] - point))
    return np.array(result).reshape(-1, 2)


def counterclockwise(points: FloatArray) -> FloatArray:
    """The vertices of a polygon (K, 2) in counterclockwise order."""
    return points if area(points) > 0.0 else points[::-1]


def convex_parts(polygon: FloatArray) -> list[FloatArray]:
    """A simple polygon (K, 2), counterclockwise, as convex parts: itself, or triangles cut off at its ears."""
    left, parts = polygon, list[FloatArray]()
    while True:
        before, after = left - np.roll(left, 1, axis=0), np.roll(left, -1, axis=0) - left
        turns = cross(before, after)
        if len(left) == 3 or (turns >= 0.0).all():
            return [*parts, left]
        ears = (k for k in np.flatnonzero(turns > 0.0).tolist() if _is_ear(left, k))
        ear = next(ears, int(np.argmax(turns)))  # by rounding there may be none
        parts.append(left[[ear - 1, ear, (ear + 1) % len(left)]])
        left = np.delete(left, ear, axis=0)


def _is_ear(polygon: FloatArray, corner: int) -> bool:
    """Whether no other corner of a polygon is in the triangle of a corner and its neighbors."""
    triangle = polygon[[corner - 1, corner, (corner + 1) % len(polygon)]]
    heights = [(polygon - start) @ normal for start, normal in zip(triangle, -_outward(_sides(triangle)), strict=True)]
    others: BoolArray = ~(polygon[:, np.newaxis] == triangle).all(axis=2).any(axis=1)
    return not (np.min(heights, axis=0) >= 0.0)[others].any()


def _sides(polygon: FloatArray) -> FloatArray:
    """The vectors from each corner of a polygon to the next one (K, 2)."""
    return np.roll(polygon, -1, axis=0) - polygon


def _heading(cores: Sequence[Core]) -> FloatArray:
    """The direction of the line between the two tones: toward a corner, along a capsule."""
    first = cores[0].vertices[-1]
    size = math.hypot(*first.tolist())
    return np.array([1.0, 0.0]) if size == 0.0 else first / size


def _marked(polygon: FloatArray, heading: FloatArray, quartered: bool) -> list[FloatArray]:
    """The polygons of a mark within a convex polygon: half of it, or two opposite quarters."""
    normal = np.array([-heading[1], heading[0]])
    half = clipped(polygon, normal)
    if not quartered:
        return [half] if len(half) > 2 else []
    quarters = [clipped(half, heading), clipped(clipped(polygon, -normal), -heading)]
    return [quarter for quarter in quarters if len(quarter) > 2]


def _fan(count: int) -> IntArray:
    """The triangles (count − 2, 3) of a convex polygon."""
    index = np.arange(1, count - 1)
    return np.stack([np.zeros_like(index), index, index + 1], axis=1)
