"""Sweeps of extended position-based dynamics in Numba: springs in colors, one after another."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rivals.jit import jit

Array = NDArray[Any]


def numba_sweep(fastmath: bool) -> Callable[..., None]:
    """Steps of XPBD with some sweeps each, under gravity along the last axis."""

    @jit(fastmath)
    def steps(
        count: int,
        sweeps: int,
        x: Array,
        v: Array,
        w: Array,
        pairs: Array,
        rest: Array,
        compliance: Array,
        multipliers: Array,
        g: float,
        h: float,
    ) -> None:
        before = np.empty_like(x)
        for _ in range(count):
            for i in range(len(x)):
                for axis in range(3):
                    before[i, axis] = x[i, axis]
                if w[i] > 0.0:
                    v[i, 2] -= h * g
                for axis in range(3):
                    x[i, axis] += h * v[i, axis]
            for sweep in range(sweeps):
                for k in range(len(pairs)):
                    i, j = pairs[k, 0], pairs[k, 1]
                    dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
                    length = math.sqrt(dx * dx + dy * dy + dz * dz)
                    stretch = length - rest[k]
                    if sweep > 0:
                        stretch -= compliance[k] * multipliers[k]
                    change = stretch / (w[i] + w[j] + compliance[k])
                    if sweeps > 1:
                        multipliers[k] = change + (multipliers[k] if sweep > 0 else 0.0)
                    pull = change / length
                    a, b = pull * w[i], pull * w[j]
                    x[i, 0] += a * dx
                    x[i, 1] += a * dy
                    x[i, 2] += a * dz
                    x[j, 0] -= b * dx
                    x[j, 1] -= b * dy
                    x[j, 2] -= b * dz
            for i in range(len(x)):
                for axis in range(3):
                    v[i, axis] = (x[i, axis] - before[i, axis]) / h

    run: Any = steps
    return run


def colors(pairs: Array) -> Array:
    """A color for each spring, so that no two of one share a particle."""
    taken: list[set[int]] = [set() for _ in range(int(pairs.max()) + 1)]
    found = np.empty(len(pairs), dtype=np.int64)
    for k, (i, j) in enumerate(pairs.tolist()):
        color = next(c for c in range(len(pairs)) if c not in taken[i] and c not in taken[j])
        found[k] = color
        taken[i].add(color)
        taken[j].add(color)
    return found


class Sheet:
    """An opponent's state."""

    def __init__(self, fastmath: bool, body: Any, dtype: type, h: float, sweeps: int = 1) -> None:
        order = np.argsort(colors(body.pairs), kind="stable")
        self.x, self.v = body.positions.astype(dtype), body.velocities.astype(dtype)
        self.w = np.where(body.fixed, 0.0, 1.0 / body.mass).astype(dtype)
        self.pairs = body.pairs[order].astype(np.int32)
        self.rest = body.rest_length[order].astype(dtype)
        self.compliance = (1.0 / (body.stiffness[order] * h * h)).astype(dtype)
        self.h, self.g = dtype(h), dtype(9.81)
        self._multipliers = np.zeros_like(self.rest)
        self._sweeps, self._steps = sweeps, numba_sweep(fastmath)

    def step(self, steps: int) -> None:
        """Take steps."""
        springs = (self.pairs, self.rest, self.compliance, self._multipliers)
        self._steps(steps, self._sweeps, self.x, self.v, self.w, *springs, self.g, self.h)
