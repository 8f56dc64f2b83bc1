"""Gray and Scott's reaction as NumPy and Numba users write it: Euler's method on a square without flux, padded arrays.

Cells around the square hold the values of those beside them, so that nothing flows through the faces.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rivals.jit import jit, prange
from rivals.waves import BAND

Array = NDArray[Any]


class Dish(Protocol):
    """An opponent's state."""

    def step(self, steps: int) -> None:
        """Take steps."""

    def species(self) -> Array:
        """u and v now, shape (2, *cells)."""


class _Euler:
    """Two times of both species, padded."""

    def __init__(self, start: Array, dtype: type, numbers: tuple[float, ...]) -> None:
        """`numbers`: D_u h/Δ², D_v h/Δ², F, k and h."""
        self.numbers = tuple(map(dtype, numbers))
        now = np.pad(start.astype(dtype), ((0, 0), (1, 1), (1, 1)), mode="edge")
        self.fields = [now, now.copy()]

    def species(self) -> Array:
        """u and v now."""
        return self.fields[0][:, 1:-1, 1:-1]


class NumpyDish(_Euler):
    """Slices, band by band, without temporary arrays as large as the field."""

    def step(self, steps: int) -> None:
        """Take steps."""
        a, b, feed, kill, h = self.numbers
        count, width = self.fields[0].shape[1:]
        sums, rows = np.empty((2, 2, BAND, width - 2), self.fields[0].dtype)
        for _ in range(steps):
            now, following = self.fields
            for first in range(1, count - 1, BAND):
                last = min(first + BAND, count - 1)
                u, v = now[:, first:last, 1:-1]
                for species, factor in ((0, a), (1, b)):
                    field, total, along = now[species], sums[species, : last - first], rows[species, : last - first]
                    np.add(field[first - 1 : last - 1, 1:-1], field[first + 1 : last + 1, 1:-1], out=total)
                    np.add(field[first:last, :-2], field[first:last, 2:], out=along)
                    total += along
                    np.multiply(field[first:last, 1:-1], 4, out=along)
                    total -= along
                    total *= factor
                gain, rate = rows[0, : last - first], rows[1, : last - first]
                np.multiply(u, v, out=gain)
                gain *= v
                np.subtract(1, u, out=rate)
                rate *= feed
                rate -= gain
                rate *= h
                rate += u
                np.add(rate, sums[0, : last - first], out=following[0, first:last, 1:-1])
                np.multiply(v, -(feed + kill), out=rate)
                rate += gain
                rate *= h
                rate += v
                np.add(rate, sums[1, : last - first], out=following[1, first:last, 1:-1])
            following[:, 0], following[:, -1] = following[:, 1], following[:, -2]
            following[:, :, 0], following[:, :, -1] = following[:, :, 1], following[:, :, -2]
            self.fields = [following, now]


def numba_dish(fastmath: bool, fused: int) -> type[Any]:
    """The same in compiled loops: a parallel sweep for each step, or on one thread `fused` steps in one pass over
    memory, each one row behind the one before.
    """

    @jit(fastmath)
    def row(now: Array, following: Array, i: int, a: Any, b: Any, feed: Any, kill: Any, h: Any) -> None:
        count, width = now.shape[1:]
        for j in range(1, width - 1):
            u, v = now[0, i, j], now[1, i, j]
            gain = u * v * v
            one = (now[0, i - 1, j] + now[0, i + 1, j]) + (now[0, i, j - 1] + now[0, i, j + 1]) - 4 * u
            two = (now[1, i - 1, j] + now[1, i + 1, j]) + (now[1, i, j - 1] + now[1, i, j + 1]) - 4 * v
            following[0, i, j] = u + a * one + h * (feed * (1 - u) - gain)
            following[1, i, j] = v + b * two + h * (gain - (feed + kill) * v)
        for species in range(2):
            new = following[species]
            new[i, 0], new[i, width - 1] = new[i, 1], new[i, width - 2]
            if i == 1:
                new[0] = new[1]
            if i == count - 2:
                new[count - 1] = new[count - 2]

    @jit(fastmath, parallel=True)
    def sweep(now: Array, following: Array, a: Any, b: Any, feed: Any, kill: Any, h: Any) -> None:
        for i in prange(1, now.shape[1] - 1):
            row(now, following, i, a, b, feed, kill, h)

    @jit(fastmath)
    def together(now: Array, following: Array, a: Any, b: Any, feed: Any, kill: Any, h: Any) -> None:
        count = now.shape[1]
        for front in range(1, count - 1 + fused):
            for stage in range(fused):
                i = front - stage
                if 1 <= i < count - 1:
                    if stage % 2 == 0:
                        row(now, following, i, a, b, feed, kill, h)
                    else:
                        row(following, now, i, a, b, feed, kill, h)

    class NumbaDish(_Euler):
        def step(self, steps: int) -> None:
            """Take steps, a multiple of `fused`."""
            for _ in range(steps // fused):
                now, following = self.fields
                if fused == 1:
                    sweep(now, following, *self.numbers)
                    self.fields = [following, now]
                else:
                    together(now, following, *self.numbers)

    return NumbaDish
