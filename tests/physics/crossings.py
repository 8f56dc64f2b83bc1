"""Edges through triangles, decided in exact arithmetic."""

from __future__ import annotations

from fractions import Fraction
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
    """How many edges are strictly through triangles with which they share no vertex."""
    line, face = points[edges], points[faces]
    near = (line.min(axis=1)[:, None] <= face.max(axis=1)) & (face.min(axis=1) <= line.max(axis=1)[:, None])
    apart = ~(edges[:, None, :, None] == faces[None, :, None, :]).any(axis=(2, 3))
    return sum(_pierces(points, edges[e], faces[f]) for e, f in np.argwhere(near.all(axis=2) & apart))


def _pierces(points: NDArray[np.float64], edge: Any, face: Any) -> bool:
    """Whether an edge passes through a triangle: floats decide where they can, fractions elsewhere."""
    for exact in (False, True):
        p, q, a, b, c = ([Fraction(x) if exact else x for x in points[k].tolist()] for k in (*edge, *face))
        volumes = [_volume(a, b, c, p), _volume(a, b, c, q), *(_volume(p, q, *two) for two in ((a, b), (b, c), (c, a)))]
        size = 1e-14 * float(np.ptp(points[[*edge, *face]], axis=0).max()) ** 3
        if exact or min(abs(volume) for volume in volumes) > size:
            break
    first, second, *turns = volumes
    return bool((first > 0) != (second > 0) and (min(turns) > 0 or max(turns) < 0) and first and second)


def _volume(a: Any, b: Any, c: Any, d: Any) -> Any:
    """Six times the signed volume of a tetrahedron."""
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (
        [one - other for one, other in zip(p, d, strict=True)] for p in (a, b, c)
    )
    return ax * (by * cz - bz * cy) - ay * (bx * cz - bz * cx) + az * (bx * cy - by * cx)
