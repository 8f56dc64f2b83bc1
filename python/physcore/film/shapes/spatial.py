"""Shapes in 3D as meshes of triangles with normals and tones."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from physcore._core import convex_hull
from physcore.checks import FloatArray, IntArray
from physcore.film.looks.base import corners
from physcore.film.shapes.creases import around, corner_normals, face_normals
from physcore.film.shapes.parts import parts_of
from physcore.scene.polytopes import Hull, MeshShape
from physcore.scene.solids import Ball, Capsule, Cuboid, Shape

SAGITTA = 0.25
"""Largest deviation of the outline of a ball from a circle [pixels]."""
FINEST = 12
"""Largest number of segments of a quarter of that circle."""
PIECE = 14.0
"""Longest side of a triangle [pixels]. Each triangle is sorted by its own depth."""
MOST_PIECES = 24
"""Largest number of pieces along a side of a triangle."""
BEVEL = 0.09
"""Width of the rounded edge of a polytope, relative to the inner radius of its smallest face."""
WIDEST = 4.0
"""Largest width of a rounded edge [pixels]."""
EDGE = 1.08
"""Tone of the rounded edges of a polytope."""
TONES = (1.0, 0.78)
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
    """The convex hull of points (K, 3) with rounded edges. Opposite faces of different axes differ in tone."""
    facets = [points[facet] for facet in convex_hull(points)]
    normals = np.array([_normal(facet) for facet in facets])
    inner = min(_inradius(facet) for facet in facets)
    bevel = min(BEVEL * inner, WIDEST / scale)
    meshes = []
    for facet, normal in zip(facets, normals, strict=True):
        share = max(0.0, 1.0 - bevel / max(_inradius(facet), bevel))
        middle = facet.mean(axis=0)
        panel = middle + share * (facet - middle)
        tone = tones[0] + (tones[1] - tones[0]) * _tone(normal)
        fan = np.array([[panel[0], panel[k], panel[k + 1]] for k in range(1, len(panel) - 1)])
        meshes.append(_flat(fan, np.broadcast_to(normal, fan.shape), tone, scale))
        sides = [_across(facets, normals, facet, normal, k) for k in range(len(facet))]
        strip, tilt = [], []
        for k, other in enumerate(sides):
            after = (k + 1) % len(facet)
            edge = normal + other
            edge = edge / np.linalg.norm(edge)
            strip += [[facet[k], facet[after], panel[after]], [facet[k], panel[after], panel[k]]]
            tilt += [[edge, edge, normal], [edge, normal, normal]]
        meshes.append(_flat(np.array(strip), np.array(tilt), EDGE, scale))
    return joined(meshes)


def closed_mesh(points: FloatArray, faces: IntArray, scale: float) -> Mesh:
    """A given mesh, smooth but for its sharp edges."""
    normals = corner_normals(faces, face_normals(points, faces), len(points), around(points, faces))
    return _flat(points[faces], normals.reshape(-1, 3, 3), 1.0, scale)


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


def _flat(triangles: FloatArray, normals: FloatArray, tone: float, scale: float) -> Mesh:
    """Triangles (T, 3, 3) in pieces, with normals at their corners (T, 3, 3)."""
    points, tilts = [], []
    for corner, normal in zip(triangles, normals, strict=True):
        longest = math.sqrt(float(((np.roll(corner, -1, axis=0) - corner) ** 2).sum(axis=1).max()))
        weights = _pieces(min(max(1, math.ceil(longest * scale / PIECE)), MOST_PIECES))
        points.append((weights @ corner).reshape(-1, 3))
        tilts.append((weights @ normal).reshape(-1, 3))
    every, tilted = np.concatenate(points), np.concatenate(tilts)
    tilted = tilted / np.sqrt((tilted**2).sum(axis=1))[:, np.newaxis]
    return Mesh(every, tilted, np.full(len(every), tone), np.arange(len(every)).reshape(-1, 3))


def _pieces(parts: int) -> FloatArray:
    """Weights of the corners of a triangle at those of its pieces (T, 3, 3), with so many parts along each side."""
    steps = np.array([(i, j) for i in range(parts) for j in range(parts - i)], dtype=float)
    upward = steps[:, np.newaxis] + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    inner = steps[steps.sum(axis=1) < parts - 1]
    downward = inner[:, np.newaxis] + np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    places = np.concatenate([upward, downward]) / parts
    return np.concatenate([1.0 - places.sum(axis=2, keepdims=True), places], axis=2)


def _normal(facet: FloatArray) -> FloatArray:
    """The unit normal of a polygon (K, 3), by Newell's sum."""
    normal = np.cross(facet, np.roll(facet, -1, axis=0)).sum(axis=0)
    result: FloatArray = normal / np.linalg.norm(normal)
    return result


def _inradius(facet: FloatArray) -> float:
    """The least distance of the sides of a convex polygon (K, 3) from the mean of its corners."""
    middle, ways = facet.mean(axis=0), np.roll(facet, -1, axis=0) - facet
    ways = ways / np.sqrt((ways**2).sum(axis=1))[:, np.newaxis]
    offsets = middle - facet
    return float(np.linalg.norm(np.cross(offsets, ways), axis=1).min())


def _tone(normal: FloatArray) -> float:
    """The share of the darker tone of a face: 0 along x, 1/2 along y, 1 along z."""
    return float(normal[1] ** 2 * 0.5 + normal[2] ** 2)


def _across(
    facets: list[FloatArray], normals: FloatArray, facet: FloatArray, normal: FloatArray, side: int
) -> FloatArray:
    """The normal of the facet on the other side of an edge."""
    one, other = facet[side], facet[(side + 1) % len(facet)]
    for candidate, across in zip(facets, normals, strict=True):
        if candidate is not facet and (candidate == one).all(axis=1).any() and (candidate == other).all(axis=1).any():
            return across
    return normal
