"""Elementary functions and small products that give the same bits on every processor.

The exponentials, powers and angles of NumPy and of `math` depend on the vector instructions and the C library of the
machine. The products and factorizations of BLAS and LAPACK do so too. All computations with a user's numbers use these
functions; `tests/test_arithmetic.py` checks this.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from physcore import _core
from physcore.checks import FloatArray

SWEEPS = 4
"""Number of rotations in each plane; from sweep to sweep what is left is squared."""


def exp(x: ArrayLike) -> FloatArray:
    """The exponential eˣ."""
    return _of(_core.exp, x)


def log(x: ArrayLike) -> FloatArray:
    """The natural logarithm ln x of positive numbers."""
    return _of(_core.log, x)


def sin(x: ArrayLike) -> FloatArray:
    """The sine of angles [rad]."""
    return _of(_core.sin, x)


def cos(x: ArrayLike) -> FloatArray:
    """The cosine of angles [rad]."""
    return _of(_core.cos, x)


def arctan2(y: ArrayLike, x: ArrayLike) -> FloatArray:
    """The angle of the point (x, y) from the x axis [rad], from −π to π."""
    return _of(_core.arctan2, y, x)


def power(x: ArrayLike, exponent: ArrayLike) -> FloatArray:
    """The power xʸ."""
    return _of(_core.power, x, exponent)


def dots(one: FloatArray, other: FloatArray) -> FloatArray:
    """Dot products (…) of vectors (…, D)."""
    products: FloatArray = (one * other).sum(axis=-1)
    return products


def lengths(vectors: FloatArray) -> FloatArray:
    """Lengths (…) of vectors (…, D)."""
    return np.sqrt(dots(vectors, vectors))


def combined(coefficients: FloatArray, rows: FloatArray) -> FloatArray:
    """Linear combinations (N, D) of rows (K, D) with coefficients (N, K)."""
    total = np.zeros((len(coefficients), rows.shape[1]))
    for column, row in zip(coefficients.T, rows, strict=True):
        total += column[:, np.newaxis] * row
    return total


def orthonormal(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Orthonormalize linearly independent rows (…, K, P) by the modified Gram–Schmidt process.

    The first 1, 2, …, K rows of the result span the same spaces as those of `rows`. The second result (…, K) is the
    length of each row before its normalization: the diagonal of R in a QR decomposition.
    """
    basis = rows.copy()
    left = np.empty(rows.shape[:-1])
    for k in range(rows.shape[-2]):
        left[..., k] = lengths(basis[..., k, :])
        basis[..., k, :] /= left[..., k, np.newaxis]
        _remove(basis[..., k + 1 :, :], basis[..., k, :])
    return basis, left


def row_space(rows: FloatArray, smallest: float) -> FloatArray:
    """Orthonormal basis (R, P) of the span of rows (M, P) of length at most 1, by the pivoted Gram–Schmidt process.

    Args:
        rows: overwritten.
        smallest: rows whose remainder is not longer than this count as rounding errors.
    """
    basis: list[FloatArray] = []
    while len(rows):
        left = lengths(rows)
        longest = int(np.argmax(left))
        if not left[longest] > smallest:
            break
        row = rows[longest] / left[longest]
        # Reorthogonalization: a second pass removes the components that rounding has left along the basis.
        for known in basis:
            row -= dots(row, known) * known
        basis.append(row / lengths(row))
        _remove(rows, basis[-1])
    return np.array(basis) if basis else rows[:0]


def along_own_axes(points: FloatArray) -> FloatArray:
    """Points (N, D) in coordinates along their principal axes, relative to their mean, by Jacobi's rotations."""
    turned: FloatArray = points - points.mean(axis=0)
    for one, other in list(combinations(range(points.shape[1]), 2)) * SWEEPS:
        x, y = turned[:, one], turned[:, other]
        angle = 0.5 * arctan2(2.0 * (x * y).sum(), (x * x).sum() - (y * y).sum())
        sine, cosine = sin(angle), cos(angle)
        turned[:, one], turned[:, other] = cosine * x + sine * y, cosine * y - sine * x
    return turned


def _remove(rows: FloatArray, direction: FloatArray) -> None:
    """Subtract from rows (…, K, P) their components along unit vectors (…, P), in place."""
    along = direction[..., np.newaxis, :]
    rows -= dots(rows, along)[..., np.newaxis] * along


def _of(function: Callable[..., FloatArray], *arguments: ArrayLike) -> FloatArray:
    """Evaluate a function of the engine at every entry of arrays, after broadcasting them."""
    arrays = np.broadcast_arrays(*(np.asarray(argument, dtype=np.float64) for argument in arguments))
    return function(*(np.ascontiguousarray(values).ravel() for values in arrays)).reshape(arrays[0].shape)
