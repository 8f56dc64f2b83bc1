"""Gravitation by the exact sum as NumPy and Numba users write it: velocity Verlet, softened, G = 1."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rivals.jit import columns, jit, prange

Array = NDArray[Any]
ROWS = 256
"""Targets that NumPy computes at a time."""


class Cluster:
    """An opponent's state, one array per component."""

    def __init__(
        self, positions: Array, velocities: Array, mass: Array, dtype: type, h: float, softening: float
    ) -> None:
        self.x, self.v = columns(positions, dtype), columns(velocities, dtype)
        self.mass, self.h, self.square = mass.astype(dtype), dtype(h), dtype(softening * softening)
        self.a = [np.empty_like(x) for x in self.x]
        self.attract()

    def attract(self) -> None:
        """Set the accelerations."""
        raise NotImplementedError

    def step(self, steps: int) -> None:
        """Take steps."""
        half = self.h * type(self.h)(0.5)
        for _ in range(steps):
            for x, v, a in zip(self.x, self.v, self.a, strict=True):
                v += half * a
                x += self.h * v
            self.attract()
            for v, a in zip(self.v, self.a, strict=True):
                v += half * a

    def positions(self) -> Array:
        """Positions [m], shape (N, 3)."""
        return np.stack(self.x, axis=1)


class NumpyCluster(Cluster):
    """Some rows of the matrix of pairs at a time."""

    def attract(self) -> None:
        """Set the accelerations."""
        for start in range(0, len(self.mass), ROWS):
            rows = slice(start, start + ROWS)
            d = [x - x[rows, np.newaxis] for x in self.x]
            square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + self.square
            weight = self.mass / (square * np.sqrt(square))
            for a, each in zip(self.a, d, strict=True):
                a[rows] = (weight * each).sum(axis=1)


def numba_cluster(fastmath: bool) -> type[Cluster]:
    """Compiled, on the threads that Numba has; `fastmath` lets the sum be vectorized."""

    @jit(fastmath=fastmath, parallel=True)
    def attract(x: Array, y: Array, z: Array, mass: Array, square: Any, ax: Array, ay: Array, az: Array) -> None:
        for i in prange(len(mass)):
            sx, sy, sz = x[i] - x[i], y[i] - y[i], z[i] - z[i]
            for j in range(len(mass)):
                dx, dy, dz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
                r2 = dx * dx + dy * dy + dz * dz + square
                weight = mass[j] / (r2 * np.sqrt(r2))
                sx += weight * dx
                sy += weight * dy
                sz += weight * dz
            ax[i], ay[i], az[i] = sx, sy, sz

    class NumbaCluster(Cluster):
        """One target after the other."""

        def attract(self) -> None:
            """Set the accelerations."""
            attract(*self.x, self.mass, self.square, *self.a)

    return NumbaCluster
