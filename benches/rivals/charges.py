"""Charges in a Penning trap as NumPy and Numba users write it: Boris' method."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rivals.jit import columns, jit, prange

Array = NDArray[Any]
BLOCK = 512
"""Charges that stay in the first-level cache."""


class Ions:
    """An opponent's state, one array per coordinate; charge and mass are 1."""

    def __init__(
        self, positions: Array, velocities: Array, dtype: type, h: float, strength: float, turn: Array
    ) -> None:
        self.x, self.v = columns(positions, dtype), columns(velocities, dtype)
        self.dtype, self.h, self.strength = dtype, dtype(h), dtype(strength)
        self.t = [dtype(0.5 * h * b) for b in turn]
        """B h/2 along each axis."""

    def step(self, steps: int) -> None:
        """Take steps."""
        raise NotImplementedError

    def positions(self) -> Array:
        """Positions, shape (N, 3)."""
        return np.stack(self.x, axis=1)


class NumpyIons(Ions):
    """Some ions at a time, each through all steps."""

    def step(self, steps: int) -> None:
        """Take steps."""
        half, t = self.dtype(0.5) * self.h, self.t
        scale = self.dtype(2.0) / (1 + t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
        shape = [half * self.strength * self.dtype(factor) for factor in (0.5, 0.5, -1.0)]
        for first in range(0, len(self.x[0]), 16 * BLOCK):
            x, v = ([axis[first : first + 16 * BLOCK] for axis in state] for state in (self.x, self.v))
            for _ in range(steps):
                for axis in range(3):
                    x[axis] += half * v[axis]
                    v[axis] += shape[axis] * x[axis]
                m = [v[i] + v[(i + 1) % 3] * t[(i + 2) % 3] - v[(i + 2) % 3] * t[(i + 1) % 3] for i in range(3)]
                for i in range(3):
                    v[i] += scale * (m[(i + 1) % 3] * t[(i + 2) % 3] - m[(i + 2) % 3] * t[(i + 1) % 3])
                for axis in range(3):
                    v[axis] += shape[axis] * x[axis]
                    x[axis] += half * v[axis]


def numba_ions(fastmath: bool, blocks: bool) -> type[Ions]:
    """Compiled, on the threads that Numba has: a block of ions or a single one through all steps."""

    @jit(fastmath=fastmath)
    def advance(state: Any, half: Any, kick: Any, t: Any, scale: Any) -> Any:
        x, y, z, u, v, w = state
        x, y, z = x + half * u, y + half * v, z + half * w
        u, v, w = u + kick[0] * x, v + kick[0] * y, w + kick[1] * z
        a, b, c = u + v * t[2] - w * t[1], v + w * t[0] - u * t[2], w + u * t[1] - v * t[0]
        u, v, w = (
            u + scale * (b * t[2] - c * t[1]),
            v + scale * (c * t[0] - a * t[2]),
            w + scale * (a * t[1] - b * t[0]),
        )
        u, v, w = u + kick[0] * x, v + kick[0] * y, w + kick[1] * z
        return x + half * u, y + half * v, z + half * w, u, v, w

    @jit(fastmath=fastmath, parallel=True)
    def run(x: Any, v: Any, half: Any, kick: Any, t: Any, scale: Any, steps: int) -> None:
        size = BLOCK if blocks else 1
        (x0, x1, x2), (v0, v1, v2) = x, v
        for block in prange((len(x0) + size - 1) // size):
            first, last = block * size, min((block + 1) * size, len(x0))
            for _ in range(steps):
                for i in range(first, last):
                    state = (x0[i], x1[i], x2[i], v0[i], v1[i], v2[i])
                    x0[i], x1[i], x2[i], v0[i], v1[i], v2[i] = advance(state, half, kick, t, scale)

    class NumbaIons(Ions):
        """All of them."""

        def step(self, steps: int) -> None:
            """Take steps."""
            half, t = self.dtype(0.5) * self.h, tuple(self.t)
            scale = self.dtype(2.0) / (self.dtype(1.0) + t[0] * t[0] + t[1] * t[1] + t[2] * t[2])
            kick = (self.dtype(0.5) * half * self.strength, -half * self.strength)
            run(tuple(self.x), tuple(self.v), half, kick, t, scale, steps)

    return NumbaIons
