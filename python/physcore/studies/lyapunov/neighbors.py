"""Paths with neighbors, whose offsets are orthonormalized again and again."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from physcore.checks import FloatArray
from physcore.errors import PhyscoreError

APART = 1e-7
"""The distance of neighbors, as a fraction of the extent of the motion: truncation is relative to it, and rounding to
1e-16 over it."""
TINY = 1e-30
"""The smallest extent."""
FARTHEST = 1e4
"""The largest growth of a distance between two orthonormalizations: neighbors stay in the linear range."""


class Paths(Protocol):
    """Paths, each with its neighbors."""

    @property
    def time(self) -> float:
        """Until when they have been followed [s]."""

    @property
    def directions(self) -> int:
        """The dimension of the tangent space."""

    @property
    def intervals(self) -> tuple[int, int]:
        """How often they have to be advanced: before averaging, and while it lasts."""

    def advance(self) -> FloatArray:
        """Follow them for an interval, and give the logarithms of the growth along each direction (N, K)."""


def orthonormalized(offsets: FloatArray, interval: float) -> tuple[FloatArray, FloatArray]:
    """The logarithms of the growth along each direction (N, K), and orthonormal frames (N, K, P) of rows, for what has
    become of such frames in an interval [s], shape (N, K, P).

    Raises:
        PhyscoreError: neighbors have parted too far.
    """
    q, r = np.linalg.qr(offsets.swapaxes(1, 2))
    diagonal = np.diagonal(r, axis1=1, axis2=2)
    if not np.abs(r).max() <= FARTHEST:
        raise PhyscoreError(
            f"lyapunov.interval: neighbors parted by {np.abs(r).max():.1e} in {interval:g} s; take a shorter interval"
        )
    growth: FloatArray = np.log(np.abs(diagonal))
    turned: FloatArray = (q * np.sign(diagonal)[:, np.newaxis, :]).swapaxes(1, 2)
    return growth, turned


def random_frame(rows: int, columns: int) -> FloatArray:
    """Normal deviates (rows, columns): along no axis, which may be a direction in which all stay that are on it."""
    return np.random.default_rng(0).normal(size=(rows, columns))
