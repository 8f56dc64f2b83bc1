"""Shapes in 3D as meshes of triangles with normals and tones."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from physcore._core import convex_hull, norms
from physcore.checks import FloatArray, IntArray
from physcore.film.shapes.box import corners
from physcore.film.shapes.creases import around, corner_normals, face_normals, units
from physcore.film.shapes.parts import parts_of
from physcore.scene.polytopes import Hull, MeshShape
from physcore.scene.solids import Ball, Capsule, Cuboid, Shape

SAGITTA = 0.25
"""Largest deviation of the outline of a ball from a circle [pixels]."""
FINEST = 12
"""Largest number of segments of a quarter of that circle."""
PIECE = 18.0
"""Longest side of a triangle [pixels]. Each triangle is sorted by its own depth."""
MOST_PIECES = 24
"""Largest number of pieces along a capsule."""
MOST_HALVINGS = 12
"""Largest number of halvings of a triangle."""
MANY = 2000.0
"""Number of squares as long as the longest side of a triangle that cover a surface, at most."""
BEVEL = 0.12
"""Width of the rounded edge of a polytope, relative to the inner radius of its smallest face."""
WIDEST = 2.4
"""Largest width of a rounded edge [pixels]."""
THINNEST = 0.6
"""Width below which edges are not rounded [pixels]."""
EDGE = 1.08
"""Tone of the rounded edges of a polytope."""
BAND = (0.66, 0.84)
"""Ends of the band along the longest side of a polytope, as fractions of its length."""
TONES = (1.0, 0.72)
"""Tones of the parts of a mark, relative to the color of the body."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed mesh about the center of mass, as separate corners of triangles, counterclockwise from outside."""

    points: FloatArray
    """Points [m], shape (P, 3)."""
    normals: FloatArray
    """Unit normals at the points, shape (P, 3)."""
    tones: FloatArray
    """Tones of the points, relative to the color of the body, shape (P,)."""
    triangles: IntArray
    """Corners of the triangles, shape (T, 3)."""

    def placed(self, rotation: FloatArray, origin: FloatArray) -> Mesh:
        """The mesh turned, then moved."""
        return Mesh(self.points @ rotation.T + origin, self.normals @ rotation.T, self.tones, self.triangles)


def joined(meshes: list[Mesh]) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes)])[:-1]
    return Mesh(
        np.concatenate([mesh.points for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.tones for mesh in meshes]),
        np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, starts.tolist(), strict=True)]),
    )


def mesh_of(shape: Shape, scale: float, marks: bool) -> Mesh:
    """The mesh of a shape at a scale [pixels/m]."""
    tones = TONES if marks else (1.0, 1.0)
    return joined(
        [
            MESHES[type(part.shape)](part.shape, scale, tones).placed(part.rotation, part.origin)
            for part in parts_of(shape, 3)
        ]
    )


def core_of(shape: Shape) -> Iterator[tuple[FloatArray, float]]:
    """Points (K, 3) and a radius for each part of a shape: the part is the hull of balls of this radius [m] there."""
    for part in parts_of(shape, 3):
        points, radius = CORES[type(part.shape)](part.shape)
        yield part.placed(points), radius


def reach_of(cores: Iterable[tuple[FloatArray, float]]) -> float:
    """The largest distance of a point of a shape from its center of mass [m]."""
    return max(float(np.sqrt((points**2).sum(axis=1)).max()) + radius for points, radius in cores)


def ball(radius: float, length: float, scale: float, tones: tuple[float, float]) -> Mesh:
    """A ball, or a capsule along z with so long a cylinder, painted in alternating octants.

    The sagitta of one of q segments of a quarter circle is r (1 − cos(π/4q)) ≈ π² r / 32 q².
    """
    quarter = math.ceil(math.pi * math.sqrt(radius * scale / (32.0 * SAGITTA)))
    quarter = min(max(quarter, 2), FINEST)
    pieces = min(max(1, math.ceil(0.5 * length * scale / PIECE)), MOST_PIECES) if length > 0.0 else 0
    level = np.linspace(0.0, 0.5 * np.pi, quarter + 1)
    heights = np.concatenate([np.zeros(pieces), level])  # from the middle upward
    feet = np.concatenate([np.linspace(0.0, 0.5 * length, pieces + 1)[:-1], np.full(quarter + 1, 0.5 * length)])
    turn = np.linspace(0.0, 0.5 * np.pi, quarter + 1)
    meshes = []
    for octant in range(8):
        below, sector = octant % 2, octant // 2
        turns = turn + 0.5 * np.pi * sector
        ring = np.stack([np.cos(turns), np.sin(turns)], axis=1)
        normals = np.concatenate(
            [
                np.cos(heights)[:, np.newaxis, np.newaxis] * ring,
                np.broadcast_to(np.sin(heights)[:, np.newaxis, np.newaxis], (len(heights), len(turn), 1)),
            ],
            axis=2,
        )
        points = radius * normals
        points[..., 2] += feet[:, np.newaxis]
        index = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
        a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
        triangles = np.concatenate(
            [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1)[:-1].reshape(-1, 3)]
        )
        flip = np.array([1.0, 1.0, -1.0]) if below else np.ones(3)
        tone = np.full(index.size, tones[(below + sector) % 2])
        meshes.append(
            Mesh(
                (points * flip).reshape(-1, 3),
                (normals * flip).reshape(-1, 3),
                tone,
                triangles[:, ::-1] if below else triangles,
            )
        )
    return joined(meshes)


def polytope(points: FloatArray, scale: float, tones: tuple[float, float]) -> Mesh:
    """The convex hull of points (K, 3) with rounded edges, and with a painted band nearer to one end."""
    facets = [points[facet] for facet in convex_hull(points)]
    normals = [_normal(facet) for facet in facets]
    piece = max(PIECE / scale, math.sqrt(sum(float(np.linalg.norm(_area(facet))) for facet in facets) / MANY))
    bevel = min(BEVEL * min(_inradius(facet) for facet in facets), WIDEST / scale)
    sharp = bevel * scale < THINNEST
    axis = np.eye(3)[int(np.argmax(np.ptp(points, axis=0)))]
    low, high = float((points @ axis).min()), float((points @ axis).max())
    planes = [low + share * (high - low) for share in (0.0, *BAND, 1.0)]
    meshes = []
    for facet, normal in zip(facets, normals, strict=True):
        panel, level = facet if sharp else _inset(facet, normal, bevel), np.tile(normal, (len(facet), 1))
        pieces = [(panel, level, 1.0)]
        for k in range(0 if sharp else len(facet)):
            after = (k + 1) % len(facet)
            edge = normal + _across(facets, normals, facet, k)
            edge = edge / np.linalg.norm(edge)
            strip = np.array([facet[k], facet[after], panel[after], panel[k]])
            pieces.append((strip, np.array([edge, edge, normal, normal]), EDGE))
        for corner, tilt, tone in pieces:
            for index in range(3):
                part = sliced(np.hstack([corner, tilt]), axis, planes[index], planes[index + 1])
                if len(part) > 2:
                    fan = np.array([[part[0], part[k], part[k + 1]] for k in range(1, len(part) - 1)])
                    meshes.append(_flat(fan[..., :3], fan[..., 3:], tone * tones[index % 2], piece))
    return joined(meshes)


def sliced(polygon: FloatArray, axis: FloatArray, low: float, high: float) -> FloatArray:
    """The part of a convex polygon between two planes across an axis; corners (K, 3 + M) with values to interpolate."""
    for sign, bound in ((1.0, low), (-1.0, -high)):
        heights = sign * (polygon[:, :3] @ axis) - bound
        corner = []
        for k, height in enumerate(heights.tolist()):
            after = (k + 1) % len(polygon)
            if height >= 0.0:
                corner.append(polygon[k])
            if (height > 0.0 > heights[after]) or (height < 0.0 < heights[after]):
                corner.append(polygon[k] + height / (height - heights[after]) * (polygon[after] - polygon[k]))
        if len(corner) < 3:
            return polygon[:0]
        polygon = np.array(corner)
    return polygon


def closed_mesh(points: FloatArray, faces: IntArray, scale: float) -> Mesh:
    """A given mesh, smooth but for its sharp edges."""
    normals = corner_normals(faces, face_normals(points, faces), len(points), around(points, faces))
    piece = max(PIECE / scale, math.sqrt(0.5 * float(norms(face_normals(points, faces)).sum()) / MANY))
    return _flat(points[faces], normals.reshape(-1, 3, 3), 1.0, piece)


MESHES: dict[type[Shape], Callable[[Any, float, tuple[float, float]], Mesh]] = {
    Ball: lambda shape, scale, tones: ball(shape.radius, 0.0, scale, tones),
    Capsule: lambda shape, scale, tones: ball(shape.radius, shape.length, scale, tones),
    Cuboid: lambda shape, scale, tones: polytope(_cuboid(shape), scale, tones),
    Hull: lambda shape, scale, tones: polytope(shape.points, scale, tones),
    MeshShape: lambda shape, scale, tones: closed_mesh(shape.vertices, shape.faces, scale),
}
"""Mesh of each class of shapes in 3D, in its own coordinates."""
CORES: dict[type[Shape], Callable[[Any], tuple[FloatArray, float]]] = {
    Ball: lambda shape: (np.zeros((1, 3)), shape.radius),
    Capsule: lambda shape: (0.5 * shape.length * np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]), shape.radius),
    Cuboid: lambda shape: (_cuboid(shape), 0.0),
    Hull: lambda shape: (shape.points, 0.0),
    MeshShape: lambda shape: (shape.vertices, 0.0),
}
"""Points and radius of each class of shapes in 3D, in its own coordinates."""


def _cuboid(shape: Cuboid) -> FloatArray:
    """The corners of a cuboid (8, 3)."""
    half = 0.5 * np.array([shape.a, shape.b, shape.c])
    return corners(-half, half)


def _flat(triangles: FloatArray, normals: FloatArray, tone: float, longest: float) -> Mesh:
    """Triangles (T, 3, 3) in pieces with sides up to a length [m], with normals at their corners (T, 3, 3)."""
    pieces = _halved(np.concatenate([triangles, normals], axis=2), longest).reshape(-1, 6)
    tilted = units(pieces[:, 3:])
    return Mesh(pieces[:, :3], tilted, np.full(len(pieces), tone), np.arange(len(pieces)).reshape(-1, 3))


def _halved(triangles: FloatArray, longest: float) -> FloatArray:
    """Triangles (T, 3, 3 + M) halved along their longest sides until none is longer, at most MOST_HALVINGS times."""
    for _ in range(MOST_HALVINGS):
        sides = np.roll(triangles, -1, axis=1) - triangles
        squares = (sides[..., :3] ** 2).sum(axis=2)
        long = squares.max(axis=1) > longest**2
        if not long.any():
            break
        whole, first = triangles[long], squares[long].argmax(axis=1)
        rows = np.arange(len(whole))
        one, other, apex = (whole[rows, (first + step) % 3] for step in range(3))
        middle = 0.5 * (one + other)
        halves = [np.stack([one, middle, apex], axis=1), np.stack([middle, other, apex], axis=1)]
        triangles = np.concatenate([triangles[~long], *halves])
    return triangles


def _normal(facet: FloatArray) -> FloatArray:
    """The unit normal of a polygon (K, 3), by Newell's sum."""
    area = _area(facet)
    result: FloatArray = area / np.linalg.norm(area)
    return result


def _area(facet: FloatArray) -> FloatArray:
    """The vector area of a polygon (K, 3)."""
    area: FloatArray = 0.5 * np.cross(facet, np.roll(facet, -1, axis=0)).sum(axis=0)
    return area


def _inset(facet: FloatArray, normal: FloatArray, width: float) -> FloatArray:
    """The corners of a convex polygon (K, 3) whose sides are moved inward by a width [m]."""
    ways = np.roll(facet, -1, axis=0) - facet
    inward = np.cross(normal, ways / np.sqrt((ways**2).sum(axis=1))[:, np.newaxis])
    before = np.roll(inward, 1, axis=0)
    result: FloatArray = facet + width * (before + inward) / (1.0 + (before * inward).sum(axis=1))[:, np.newaxis]
    return result


def _inradius(facet: FloatArray) -> float:
    """The least distance of the sides of a convex polygon (K, 3) from the mean of its corners."""
    middle, ways = facet.mean(axis=0), np.roll(facet, -1, axis=0) - facet
    ways = ways / np.sqrt((ways**2).sum(axis=1))[:, np.newaxis]
    offsets = middle - facet
    return float(np.linalg.norm(np.cross(offsets, ways), axis=1).min())


def _across(facets: list[FloatArray], normals: list[FloatArray], facet: FloatArray, side: int) -> FloatArray:
    """The normal of the facet on the other side of an edge."""
    one, other = facet[side], facet[(side + 1) % len(facet)]
    for candidate, across in zip(facets, normals, strict=True):
        if candidate is not facet and (candidate == one).all(axis=1).any() and (candidate == other).all(axis=1).any():
            return across
    raise AssertionError("hulls are closed")
