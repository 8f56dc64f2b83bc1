"""Surfaces of liquids in 3D as closed meshes of triangles."""

from __future__ import annotations

import numpy as np

from physcore import memory
from physcore.checks import FloatArray, IntArray

REACH = 2.0
"""Reach R of the weight of a particle, in spacings."""
LEVEL = 0.246
"""Distance from the weighted mean of the particles at which the surface is, over R.

At the surface of a half-space, the mean depth under the weight (1 − r²/R²)³ is ½ R ∫x³(1−x²)³dx / ∫x²(1−x²)³dx.
"""
CELLS = 1.6
"""Number of cells of the grid along a spacing."""
CHUNK = 2000
"""Number of particles that are added at a time."""
EDGES = ((0, 1), (2, 3), (4, 5), (6, 7), (0, 2), (1, 3), (4, 6), (5, 7), (0, 4), (1, 5), (2, 6), (3, 7))
"""Edges of a cell, whose corner 4i + 2j + k has the offsets i, j and k."""
CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


def surface_of(points: FloatArray, spacing: float) -> tuple[FloatArray, IntArray]:
    """The surface of a liquid: points (V, 3) [m] and triangles (T, 3), counterclockwise from outside.

    It is where the distance from the weighted mean of the particles around is constant.

    Args:
        points: particles (N, 3) [m].
        spacing: their spacing [m].

    Raises:
        MemoryExceeded: particles are so far apart that the grid around them does not fit into memory.

    Source: Y. Zhu, R. Bridson, "Animating sand as a fluid", ACM Trans. Graphics 24 (3), 965 (2005).
    """
    known = points[np.isfinite(points).all(axis=1)]
    if len(known) == 0:
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
    step, reach = spacing / CELLS, REACH * spacing
    first = np.floor((known.min(axis=0) - reach) / step).astype(np.int64) - 1
    shape = np.ceil((known.max(axis=0) + reach) / step).astype(np.int64) + 2 - first
    memory.require(64.0 * float(np.prod(shape.astype(float))), "the surface of a liquid", "path", "export fewer frames")
    values = _distances(known / step - first, shape, reach / step)
    places, faces = _net(values - LEVEL * reach / step)
    return (places + first) * step, faces


def _distances(places: FloatArray, shape: IntArray, reach: float) -> FloatArray:
    """Distances of the nodes of a grid from the weighted mean of the particles around. All lengths are in cells."""
    count, around = int(np.prod(shape)), np.arange(-int(reach), int(reach) + 2)
    offsets = np.stack(np.meshgrid(around, around, around, indexing="ij"), axis=-1).reshape(-1, 3)
    beyond = np.maximum(np.maximum(-offsets, offsets - 1), 0)  # of a particle anywhere in its cell
    offsets = offsets[(beyond * beyond).sum(axis=1) < reach * reach]
    strides = np.array([shape[1] * shape[2], shape[2], 1])
    sums = np.zeros((4, count))
    for start in range(0, len(places), CHUNK):
        some = places[start : start + CHUNK, np.newaxis]
        nodes = np.floor(some).astype(np.int64) + offsets
        away = some - nodes
        inside = 1.0 - (away * away).sum(axis=2) / (reach * reach)
        weights = np.maximum(inside, 0.0)
        weights *= weights * weights
        index = (nodes * strides).sum(axis=2)
        near = weights > 0.0
        index, weights, away = index[near], weights[near], away[near]
        sums[0] += np.bincount(index, weights, count)
        for axis in range(3):
            sums[1 + axis] += np.bincount(index, weights * away[:, axis], count)
    means = sums[1:] / np.where(sums[0] > 0.0, sums[0], 1.0)
    distances: FloatArray = np.where(sums[0] > 0.0, np.sqrt((means * means).sum(axis=0)), reach)
    return distances.reshape(shape)


def _net(values: FloatArray) -> tuple[FloatArray, IntArray]:
    """The surface on which values at the nodes of a grid are zero, and negative inside, in cells: points and triangles.

    Each cell that it crosses has one point, the mean of the crossings of its edges; each edge that it crosses has two
    triangles.

    Source: S. F. F. Gibson, "Constrained elastic surface nets", MICCAI 1998.
    """
    inside = values < 0.0
    cells = np.array(values.shape) - 1
    corners = [tuple(slice(low, low + size) for low, size in zip(corner, cells, strict=True)) for corner in CORNERS]
    total = sum(inside[corner].astype(np.int8) for corner in corners)
    where = np.argwhere((total > 0) & (total < 8))
    numbers = np.full(tuple(cells), -1, dtype=np.int64)
    numbers[tuple(where.T)] = np.arange(len(where))
    around = values[tuple((where[:, np.newaxis] + CORNERS).transpose(2, 0, 1))]
    places, crossings = np.zeros((len(where), 3)), np.zeros(len(where))
    for one, other in EDGES:
        low, high = around[:, one], around[:, other]
        crossed = (low < 0.0) != (high < 0.0)
        share = np.where(crossed, low / np.where(crossed, low - high, 1.0), 0.0)
        ends = CORNERS[one] + share[:, np.newaxis] * (CORNERS[other] - CORNERS[one])
        places += np.where(crossed[:, np.newaxis], ends, 0.0)
        crossings += crossed
    faces = [_across(inside, numbers, axis) for axis in range(3)]
    return where + places / np.maximum(crossings, 1.0)[:, np.newaxis], np.concatenate(faces)


def _across(inside: np.ndarray, numbers: IntArray, axis: int) -> IntArray:
    """The triangles (T, 3) of the edges of a grid along an axis, between the points of the four cells around each."""
    along = np.moveaxis(inside, axis, 0)
    edges = np.argwhere(np.moveaxis(along[:-1] != along[1:], 0, axis))
    second, third = np.eye(3, dtype=np.int64)[[(axis + 1) % 3, (axis + 2) % 3]]
    square = np.stack([numbers[tuple((edges - back).T)] for back in (second + third, third, 0 * third, second)], axis=1)
    outward = inside[tuple(edges.T)]
    square = np.where(outward[:, np.newaxis], square, square[:, ::-1])
    return np.concatenate([square[:, [0, 1, 2]], square[:, [0, 2, 3]]])
