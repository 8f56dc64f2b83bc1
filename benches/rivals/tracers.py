"""Tracers in Lorenz' flow as NumPy and Numba users write them: the classical Runge–Kutta method."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rivals.jit import columns, jit, prange

Array = NDArray[Any]
BLOCK = 512
"""Tracers that stay in the first-level cache."""


class Cloud:
    """An opponent's state, one array per coordinate."""

    def __init__(self, positions: Array, dtype: type, h: float) -> None:
        self.x = columns(positions, dtype)
        self.dtype, self.h = dtype, dtype(h)

    def step(self, steps: int) -> None:
        """Take steps."""
        raise NotImplementedError

    def positions(self) -> Array:
        """Positions, shape (N, 3)."""
        return np.stack(self.x, axis=1)


class NumpyCloud(Cloud):
    """Some tracers at a time, each through all steps."""

    def step(self, steps: int) -> None:
        """Take steps."""
        rho, beta, h = self.dtype(28.0), self.dtype(8.0 / 3.0), self.h

        def velocity(x: Array, y: Array, z: Array) -> list[Array]:
            return [self.dtype(10.0) * (y - x), x * (rho - z) - y, x * y - beta * z]

        for first in range(0, len(self.x[0]), 16 * BLOCK):
            now = [x[first : first + 16 * BLOCK] for x in self.x]
            for _ in range(steps):
                one = velocity(*now)
                two = velocity(*(x + h / 2 * k for x, k in zip(now, one, strict=True)))
                three = velocity(*(x + h / 2 * k for x, k in zip(now, two, strict=True)))
                four = velocity(*(x + h * k for x, k in zip(now, three, strict=True)))
                for x, a, b, c, d in zip(now, one, two, three, four, strict=True):
                    x += h / 6 * (a + 2 * (b + c) + d)


def numba_cloud(fastmath: bool, blocks: bool) -> type[Cloud]:
    """Compiled, on the threads that Numba has: a block of tracers or a single one through all steps."""

    @jit(fastmath=fastmath)
    def velocity(x: Any, y: Any, z: Any, numbers: Any) -> Any:
        sigma, rho, beta = numbers
        return sigma * (y - x), x * (rho - z) - y, x * y - beta * z

    @jit(fastmath=fastmath)
    def advance(x: Any, y: Any, z: Any, numbers: Any, weights: Any) -> Any:
        half, whole, sixth, two = weights
        u1, v1, w1 = velocity(x, y, z, numbers)
        u2, v2, w2 = velocity(x + half * u1, y + half * v1, z + half * w1, numbers)
        u3, v3, w3 = velocity(x + half * u2, y + half * v2, z + half * w2, numbers)
        u4, v4, w4 = velocity(x + whole * u3, y + whole * v3, z + whole * w3, numbers)
        return (
            x + sixth * (u1 + two * (u2 + u3) + u4),
            y + sixth * (v1 + two * (v2 + v3) + v4),
            z + sixth * (w1 + two * (w2 + w3) + w4),
        )

    @jit(fastmath=fastmath, parallel=True)
    def run(x: Array, y: Array, z: Array, numbers: Any, weights: Any, steps: int) -> None:
        size = BLOCK if blocks else 1
        for block in prange((len(x) + size - 1) // size):
            first, last = block * size, min((block + 1) * size, len(x))
            for _ in range(steps):
                for i in range(first, last):
                    x[i], y[i], z[i] = advance(x[i], y[i], z[i], numbers, weights)

    class NumbaCloud(Cloud):
        """All of them."""

        def step(self, steps: int) -> None:
            """Take steps."""
            numbers = tuple(map(self.dtype, (10.0, 28.0, 8.0 / 3.0)))
            weights = tuple(map(self.dtype, (self.h / 2, self.h, self.h / 6, 2.0)))
            run(*self.x, numbers, weights, steps)

    return NumbaCloud
