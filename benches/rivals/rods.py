"""A chain of rods in Numba, as somebody writes it who knows that it is a chain: RATTLE with a tridiagonal matrix."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rivals.jit import jit

Array = NDArray[np.float64]


def numba_chain(fastmath: bool) -> Callable[..., None]:
    """Steps of a chain in the plane whose first node is fixed, under gravity."""

    @jit(fastmath)
    def factorize(n: Array, inverse: Array, pivots: Array, ratios: Array) -> None:
        for k in range(len(n)):
            pivots[k] = inverse[k] + inverse[k + 1]
            if k > 0:
                coupling = -inverse[k] * (n[k, 0] * n[k - 1, 0] + n[k, 1] * n[k - 1, 1])
                ratios[k] = coupling / pivots[k - 1]
                pivots[k] -= ratios[k] * coupling

    @jit(fastmath)
    def solve(pivots: Array, ratios: Array, b: Array) -> None:
        for k in range(1, len(b)):
            b[k] -= ratios[k] * b[k - 1]
        b[-1] /= pivots[-1]
        for k in range(len(b) - 2, -1, -1):
            b[k] = b[k] / pivots[k] - ratios[k + 1] * b[k + 1]

    @jit(fastmath)
    def steps(count: int, x: Array, v: Array, length: Array, mass: Array, g: float, h: float, tolerance: float) -> None:
        links = len(length)
        n, b, pivots, ratios = np.empty((links, 2)), np.empty(links), np.empty(links), np.zeros(links)
        inverse = 1.0 / mass
        inverse[0] = 0.0
        for k in range(links):
            for axis in range(2):
                n[k, axis] = (x[k + 1, axis] - x[k, axis]) / length[k]
        factorize(n, inverse, pivots, ratios)
        for _ in range(count):
            for i in range(1, links + 1):
                v[i, 1] -= 0.5 * h * g
                x[i, 0] += h * v[i, 0]
                x[i, 1] += h * v[i, 1]
            while True:
                worst = 0.0
                for k in range(links):
                    dx, dy = x[k + 1, 0] - x[k, 0], x[k + 1, 1] - x[k, 1]
                    b[k] = (dx * dx + dy * dy - length[k] * length[k]) / (2.0 * length[k])
                    worst = max(worst, abs(b[k]))
                if worst <= tolerance:
                    break
                solve(pivots, ratios, b)
                for k in range(links):
                    for axis in range(2):
                        impulse = b[k] * n[k, axis]
                        x[k, axis] += inverse[k] * impulse
                        x[k + 1, axis] -= inverse[k + 1] * impulse
                        v[k, axis] += inverse[k] * impulse / h
                        v[k + 1, axis] -= inverse[k + 1] * impulse / h
            for i in range(1, links + 1):
                v[i, 1] -= 0.5 * h * g
            for k in range(links):
                for axis in range(2):
                    n[k, axis] = (x[k + 1, axis] - x[k, axis]) / length[k]
            factorize(n, inverse, pivots, ratios)
            for k in range(links):
                b[k] = n[k, 0] * (v[k + 1, 0] - v[k, 0]) + n[k, 1] * (v[k + 1, 1] - v[k, 1])
            solve(pivots, ratios, b)
            for k in range(links):
                for axis in range(2):
                    impulse = b[k] * n[k, axis]
                    v[k, axis] += inverse[k] * impulse
                    v[k + 1, axis] -= inverse[k + 1] * impulse

    run: Any = steps
    return run


class Chain:
    """An opponent's state."""

    def __init__(self, fastmath: bool, positions: Array, length: Array, mass: Array, h: float) -> None:
        self.x, self.v = positions.copy(), np.zeros_like(positions)
        self.length, self.mass, self.h = length.copy(), mass.copy(), h
        self._steps = numba_chain(fastmath)

    def step(self, steps: int) -> None:
        """Take steps."""
        # To the roundings of coordinates of one meter, as physcore does.
        self._steps(steps, self.x, self.v, self.length, self.mass, 9.81, self.h, 2.0 * np.finfo(np.float64).eps)
