"""Weights of the edges of a triangulated plate, with which hinges bend as a plate in every direction.

A uniform bending moment M turns the edge e by an angle θ. With the edge's normal n in the plane, the torque is
|e| nᵀM n. It is in equilibrium on every mesh. θ is this torque over B w. The compliance of the hinges is therefore

    Σ a nnnn/B,   a = |e|²/w,

summed over the edges. It is that of a plate of the rigidity B and Poisson's ratio −1/3 if the sum is isotropic and the
sum of a is three times the area. Faces give their area to each of their edges, so that the total is right on every
mesh. On equilateral triangles the sum is isotropic too. On other meshes, a is corrected by a factor g, a polynomial of
the direction of the edge. For each particle, g has an isotropic sum over the faces, and the least square of g − 1.
"""

from __future__ import annotations

import numpy as np

from physcore.arithmetic import dots, lengths
from physcore.checks import FloatArray, IntArray

LEAST = 0.25
"""Smallest factor g. Where isotropy needs a smaller one, the correction is scaled down."""
RIDGE, REPEATED = 1e-3, 4
"""Regularization of the equations for g, relative, and how often it is repeated for what it has left (iterated
Tikhonov regularization). Directions that do not occur make the equations singular.
"""
TERMS = 5
"""Terms of g in the angle φ of an edge: 1, cos 2φ, sin 2φ, cos 4φ, sin 4φ."""


def face_shares(positions: FloatArray, faces: IntArray) -> FloatArray:
    """The area a that each face gives to its sides [m²], shape (T, 3); side k is from corner k to corner k + 1."""
    corners = positions[faces]
    sides = np.roll(corners, -1, axis=1) - corners
    normals = np.cross(sides[:, 0], sides[:, 1])
    doubled = lengths(normals)
    frames = _frames(len(positions), faces, normals, sides[:, 0])
    terms = [_terms(sides, frames[faces[:, k]]) for k in range(3)]
    factors = _factors(len(positions), faces, 0.5 * doubled, terms)
    mean = sum(dots(own, factors[faces[:, k], np.newaxis]) for k, own in enumerate(terms)) / 3.0
    shares: FloatArray = 0.5 * doubled[:, np.newaxis] * mean
    return shares


def _frames(count: int, faces: IntArray, normals: FloatArray, sides: FloatArray) -> FloatArray:
    """Two orthonormal tangents at each particle, shape (N, 2, 3).

    The normal is the mean of the faces' normals, turned to the side of the normal of one of them. This is the first in
    the order of corners, so that neither the order of faces nor their sense matters.
    """
    owners = faces.ravel()
    order = np.lexsort(np.sort(faces, axis=1).T[::-1])[::-1]
    first: IntArray = np.zeros(count, dtype=np.int64)
    first[faces[order]] = order[:, np.newaxis]
    own = np.repeat(normals, 3, axis=0)
    same = np.where(dots(own, normals[first][owners]) < 0.0, -1.0, 1.0)
    mean = np.asarray([np.bincount(owners, same * column, count) for column in own.T], dtype=np.float64).T
    upward = np.where(lengths(mean)[:, np.newaxis] > 0.0, mean, normals[first])
    upward = upward / lengths(upward)[:, np.newaxis]
    along = sides[first] - dots(sides[first], upward)[:, np.newaxis] * upward
    along = along / np.maximum(lengths(along), np.finfo(float).tiny)[:, np.newaxis]
    return np.stack([along, np.cross(upward, along)], axis=1)


def _terms(sides: FloatArray, frames: FloatArray) -> FloatArray:
    """The terms of g for the sides (T, 3, 3) of faces in frames (T, 2, 3), shape (T, 3, TERMS)."""
    x, y = (dots(sides, frames[:, np.newaxis, k]) for k in range(2))
    square = np.maximum(x * x + y * y, np.finfo(float).tiny)
    cosine, sine = (x * x - y * y) / square, 2.0 * x * y / square
    return np.stack([np.ones_like(x), cosine, sine, cosine * cosine - sine * sine, 2.0 * cosine * sine], axis=-1)


def _factors(count: int, faces: IntArray, areas: FloatArray, terms: list[FloatArray]) -> FloatArray:
    """The coefficients of g at each particle, shape (N, TERMS)."""
    matrix = np.zeros((count, TERMS, TERMS))
    for corner, own in enumerate(terms):
        for i, j in np.ndindex(TERMS, TERMS):
            products = areas * dots(own[..., i], own[..., j])
            matrix[:, i, j] += np.bincount(faces[:, corner], products, count)
    total = np.maximum(matrix[:, 0, 0], np.finfo(float).tiny)
    matrix /= total[:, np.newaxis, np.newaxis]
    moments = matrix[:, 0].copy()
    moments[:, 0] = 0.0
    change = np.zeros_like(moments)
    for _ in range(REPEATED):
        change -= _solved(matrix + RIDGE * np.eye(TERMS), moments + dots(matrix, change[:, np.newaxis]))
    # The most that a side of one of the particle's faces is reduced by.
    lowest = np.zeros(count)
    for corner, own in enumerate(terms):
        np.minimum.at(lowest, faces[:, corner], dots(own, change[faces[:, corner], np.newaxis]).min(axis=1))
    change *= np.minimum(1.0, (LEAST - 1.0) / np.minimum(lowest, LEAST - 1.0))[:, np.newaxis]
    mean = 1.0 + dots(matrix[:, 0], change)
    change[:, 0] += 1.0
    result: FloatArray = change / mean[:, np.newaxis]
    return result


def _solved(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """The solutions (N, K) of symmetric positive definite systems (N, K, K), by Gaussian elimination."""
    left, result = matrices.copy(), right.copy()
    size = right.shape[1]
    for pivot in range(size):
        for row in range(pivot + 1, size):
            factor = left[:, row, pivot] / left[:, pivot, pivot]
            left[:, row] -= factor[:, np.newaxis] * left[:, pivot]
            result[:, row] -= factor * result[:, pivot]
    for pivot in reversed(range(size)):
        result[:, pivot] -= dots(left[:, pivot, pivot + 1 :], result[:, pivot + 1 :])
        result[:, pivot] /= left[:, pivot, pivot]
    return result
