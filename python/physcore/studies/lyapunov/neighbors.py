"""Trajectories with neighbors, whose offsets are orthonormalized repeatedly."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from physcore.arithmetic import lengths, log, orthonormal
from physcore.checks import FloatArray
from physcore.errors import PhyscoreError

APART = 1e-7
"""Distance of neighbors, relative to the extent of the motion. The truncation error is proportional to it, and the
rounding error is 1e-16 over it.
"""
TINY = 1e-30
"""Least extent of the motion."""
FARTHEST = 1e4
"""Largest growth of a distance between two orthonormalizations, such that neighbors remain in the linear range."""


class Paths(Protocol):
    """Trajectories with their neighbors."""

    @property
    def time(self) -> float:
        """The present time [s]."""

    @property
    def directions(self) -> int:
        """The dimension of the tangent space."""

    @property
    def intervals(self) -> tuple[int, int]:
        """The numbers of intervals before averaging and during averaging."""

    def advance(self) -> FloatArray:
        """Advance by an interval, and return the logarithms of the growth along each direction (N, K)."""


def orthonormalized(offsets: FloatArray, interval: float) -> tuple[FloatArray, FloatArray]:
    """Orthonormalize the images (N, K, P) of orthonormal frames after an interval [s].

    Returns the logarithms of the growth along each direction (N, K), and the new orthonormal frames (N, K, P) of rows.

    Raises:
        PhyscoreError: neighbors have separated too far.
    """
    farthest = float(lengths(offsets).max())
    if not farthest <= FARTHEST:
        raise PhyscoreError(
            f"lyapunov.interval: neighbors parted by {farthest:.1e} in {interval:g} s; take a shorter interval"
        )
    frames, growth = orthonormal(offsets)
    return log(growth), frames


def random_frame(count: int, columns: int, forbidden: FloatArray | None = None) -> FloatArray:
    """Random orthonormal rows (count, columns), not along axes, which may be invariant directions.

    Args:
        count: number of rows.
        columns: number of columns.
        forbidden: orthonormal rows that the result is perpendicular to.
    """
    rows = np.random.default_rng(0).uniform(-1.0, 1.0, size=(count, columns))
    first = np.zeros((0, columns)) if forbidden is None else forbidden
    return orthonormal(np.concatenate([first, rows]))[0][len(first) :]
