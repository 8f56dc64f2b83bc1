"""The wave equation as NumPy and Numba users write it: leapfrog on a square between fixed edges, of padded arrays.

u(t + h) = 2 u(t) − u(t − h) + (c h/Δ)² L u(t), which gives Verlet's displacements. Cells around the square hold −u of
those beside them, so that u is zero on the faces.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rivals.jit import jit, prange

Array = NDArray[Any]
BAND = 64
"""Rows that NumPy computes at a time: some of them fit into a cache."""


class Pond(Protocol):
    """An opponent's state."""

    def step(self, steps: int) -> None:
        """Take steps."""

    def displacement(self) -> Array:
        """u now."""


class _Leapfrog:
    """Two times of the field, padded."""

    def __init__(self, start: Array, dtype: type, number: float) -> None:
        """Begin at rest; `number` is c h/Δ."""
        self.factor = dtype(number * number)
        now = np.zeros((start.shape[0] + 2, start.shape[1] + 2), dtype)
        now[1:-1, 1:-1] = start
        mirror(now)
        before = now.copy()
        before[1:-1, 1:-1] += dtype(0.5) * self.factor * laplacian(now)
        mirror(before)
        self.fields = [before, now]

    def displacement(self) -> Array:
        """u now."""
        return self.fields[1][1:-1, 1:-1]


def laplacian(u: Array) -> Array:
    """L u of the inner cells."""
    return (u[:-2, 1:-1] + u[2:, 1:-1]) + (u[1:-1, :-2] + u[1:-1, 2:]) - 4 * u[1:-1, 1:-1]


def mirror(u: Array) -> None:
    """Fill the cells around the square."""
    u[0], u[-1] = -u[1], -u[-2]
    u[:, 0], u[:, -1] = -u[:, 1], -u[:, -2]


class NumpyPond(_Leapfrog):
    """Slices, band by band, without temporary arrays as large as the field."""

    def step(self, steps: int) -> None:
        """Take steps."""
        count, width = self.fields[0].shape
        sums, rows = np.empty((2, BAND, width - 2), self.fields[0].dtype)
        for _ in range(steps):
            before, now = self.fields
            for first in range(1, count - 1, BAND):
                last = min(first + BAND, count - 1)
                u, total, along = now[first:last, 1:-1], sums[: last - first], rows[: last - first]
                np.add(now[first - 1 : last - 1, 1:-1], now[first + 1 : last + 1, 1:-1], out=total)
                np.add(now[first:last, :-2], now[first:last, 2:], out=along)
                total += along
                np.multiply(u, 4, out=along)
                total -= along
                total *= self.factor
                np.multiply(u, 2, out=along)
                along -= before[first:last, 1:-1]
                np.add(along, total, out=before[first:last, 1:-1])
            mirror(before)
            self.fields = [now, before]


def numba_pond(fastmath: bool, fused: int) -> type[Any]:
    """The same in compiled loops: a parallel sweep for each step, or on one thread `fused` steps in one pass over
    memory, each one row behind the one before.
    """

    @jit(fastmath)
    def row(before: Array, now: Array, i: int, factor: Any) -> None:
        count, width = before.shape
        for j in range(1, width - 1):
            beside = (now[i - 1, j] + now[i + 1, j]) + (now[i, j - 1] + now[i, j + 1])
            before[i, j] = (2 * now[i, j] - before[i, j]) + factor * (beside - 4 * now[i, j])
        before[i, 0], before[i, width - 1] = -before[i, 1], -before[i, width - 2]
        if i == 1:
            for j in range(width):
                before[0, j] = -before[1, j]
        if i == count - 2:
            for j in range(width):
                before[count - 1, j] = -before[count - 2, j]

    @jit(fastmath, parallel=True)
    def sweep(before: Array, now: Array, factor: Any) -> None:
        for i in prange(1, before.shape[0] - 1):
            row(before, now, i, factor)

    @jit(fastmath)
    def together(before: Array, now: Array, factor: Any) -> None:
        count = before.shape[0]
        for front in range(1, count - 1 + fused):
            for stage in range(fused):
                i = front - stage
                if 1 <= i < count - 1:
                    if stage % 2 == 0:
                        row(before, now, i, factor)
                    else:
                        row(now, before, i, factor)

    class NumbaPond(_Leapfrog):
        def step(self, steps: int) -> None:
            """Take steps, a multiple of `fused`."""
            for _ in range(steps // fused):
                before, now = self.fields
                if fused == 1:
                    sweep(before, now, self.factor)
                    self.fields = [now, before]
                else:
                    together(before, now, self.factor)

    return NumbaPond
