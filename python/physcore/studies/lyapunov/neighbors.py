"""Paths with neighbors, whose offsets are orthonormalized again and again."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from physcore.arithmetic import lengths, log, orthonormal
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
    farthest = float(lengths(offsets).max())
    if not farthest <= FARTHEST:
        raise PhyscoreError(
            f"lyapunov.interval: neighbors parted by {farthest:.1e} in {interval:g} s; take a shorter interval"
        )
    frames, growth = orthonormal(offsets)
    return log(growth), frames


def random_frame(count: int, columns: int, forbidden: FloatArray | None = None) -> FloatArray:
    """Orthonormal rows (count, columns), along no axis, which may be a direction in which all stay that are on it.

    Args:
        count: of rows.
        columns: of each.
        forbidden: orthonormal rows to which they are perpendicular.
    """
    rows = np.random.default_rng(0).uniform(-1.0, 1.0, size=(count, columns))
    first = np.zeros((0, columns)) if forbidden is None else forbidden
    return orthonormal(np.concatenate([first, rows]))[0][len(first) :]
