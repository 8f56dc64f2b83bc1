"""Edges through triangles, decided in exact arithmetic."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import physcore as pc


def mesh(*networks: pc.SpringNetwork) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The edges (E, 2) and the triangles (T, 3) of bodies, one after the other; springs where there are none."""
    starts = np.cumsum([0, *(len(network) for network in networks[:-1])]).tolist()
    faces = np.vstack([network.faces + start for network, start in zip(networks, starts, strict=True)])
    free = [network.pairs + start for network, start in zip(networks, starts, strict=True) if not len(network.faces)]
    sides = np.vstack([faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), *free])
    return np.unique(np.sort(sides, axis=1), axis=0), faces


def crossings(points: NDArray[np.float64], edges: NDArray[np.int64], faces: NDArray[np.int64]) -> int:
    """How many edges are strictly through triangles with which they share no vertex.

    Floats decide where the volumes are above their rounding, whole numbers elsewhere.
    """
    line, face = points[edges], points[faces]
    near = (line.min(axis=1)[:, None] <= face.max(axis=1)) & (face.min(axis=1) <= line.max(axis=1)[:, None])
    apart = ~(edges[:, None, :, None] == faces[None, :, None, :]).any(axis=(2, 3))
    e, f = np.nonzero(near.all(axis=2) & apart)
    corners = points[np.hstack([edges[e], faces[f]])]
    rounding = 1e-14 * np.ptp(corners, axis=1).max(axis=1) ** 3
    ends, turns = np.split(_volumes(corners.transpose(1, 2, 0)), [2])
    on_one_side = (ends > rounding).all(axis=0) | (ends < -rounding).all(axis=0)
    is_past = (turns > rounding).any(axis=0) & (turns < -rounding).any(axis=0)
    return sum(_pierces(corner) for corner in corners[~(on_one_side | is_past)])


def _pierces(corners: NDArray[np.float64]) -> bool:
    """Whether an edge passes through a triangle, decided in whole numbers."""
    ratios = [x.as_integer_ratio() for x in corners.ravel().tolist()]
    unit = max(divisor for _, divisor in ratios)  # Divisors of floats are powers of two.
    whole = np.array([number * (unit // divisor) for number, divisor in ratios], dtype=object)
    first, second, *turns = _volumes(whole.reshape(corners.shape))
    return bool((first > 0) != (second > 0) and (min(turns) > 0 or max(turns) < 0) and first and second)


def _volumes(corners: NDArray[Any]) -> NDArray[Any]:
    """Volumes of a triangle with both ends p, q of an edge, and of the edge with the triangle's sides."""
    p, q, a, b, c = corners
    return np.stack(
        [_volume(a, b, c, p), _volume(a, b, c, q), *(_volume(p, q, *two) for two in ((a, b), (b, c), (c, a)))]
    )


def _volume(a: NDArray[Any], b: NDArray[Any], c: NDArray[Any], d: NDArray[Any]) -> Any:
    """Six times the signed volume of a tetrahedron."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = a - d, b - d, c - d
    return ax * (by * cz - bz * cy) - ay * (bx * cz - bz * cx) + az * (bx * cy - by * cx)
