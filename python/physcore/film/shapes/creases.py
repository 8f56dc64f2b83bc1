"""Normals of surfaces of triangles, smooth except across sharp edges."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray, IntArray

CREASE = 0.75
"""Cosine of the angle between two faces below which their common edge is drawn sharp."""


def face_normals(positions: FloatArray, faces: IntArray) -> FloatArray:
    """Normals of faces (T, 3); their length is twice the area."""
    first, second, third = (positions[faces[:, corner]] for corner in (0, 1, 2))
    return np.cross(second - first, third - first)


def around(positions: FloatArray, faces: IntArray) -> tuple[IntArray, IntArray] | None:
    """The faces around each corner of each face that are not beyond a sharp edge: corners (K,) of 3T and faces (K,) of
    T.

    The result is None if there are no sharp edges, so that all faces of a point count.
    """
    corners, normals = faces.ravel(), units(face_normals(positions, faces))
    order = np.argsort(corners, kind="stable")
    counts = np.bincount(corners, minlength=len(positions))
    starts = np.cumsum(counts) - counts
    corner = np.repeat(np.arange(len(corners)), counts[corners])
    step = np.arange(len(corner)) - np.repeat(np.cumsum(counts[corners]) - counts[corners], counts[corners])
    face = order[starts[corners[corner]] + step] // 3
    level = np.einsum("kd,kd->k", normals[corner // 3], normals[face]) > CREASE
    return None if level.all() else (corner[level], face[level])


def units(vectors: FloatArray) -> FloatArray:
    """Vectors (N, 3) scaled to length 1."""
    length = np.sqrt(np.einsum("nd,nd->n", vectors, vectors))
    result: FloatArray = vectors / np.maximum(length, 1e-300)[:, np.newaxis]
    return result


def sums(index: IntArray, values: FloatArray, count: int) -> FloatArray:
    """The sums (count, D) of the rows (N, D) with the same index (N,)."""
    return np.stack([np.bincount(index, weights=column, minlength=count) for column in values.T], axis=1)


def corner_normals(
    faces: IntArray, normals: FloatArray, count: int, near: tuple[IntArray, IntArray] | None
) -> FloatArray:
    """Unit normals at the corners of all faces (3T, 3): means over the faces around each, weighted by their areas.

    Args:
        faces: corners of the faces (T, 3).
        normals: normals of the faces (T, 3), as long as their areas.
        count: the number of points.
        near: the result of `around`.
    """
    if near is None:
        corners = faces.ravel()
        return units(sums(corners, np.repeat(normals, 3, axis=0), count))[corners]
    corner, face = near
    return units(sums(corner, normals[face], 3 * len(normals)))
