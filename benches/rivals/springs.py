"""A cloth of damped springs in 2D by velocity Verlet, with damping at the predicted velocity as physcore has it: NumPy.

In an arbitrary network, springs scatter to their ends by bincount. In a grid, springs of one kind join two slices of it
that are shifted against each other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physcore as pc
from rivals.jit import columns

OFFSETS = ((1, 0), (0, 1), (1, 1), (-1, 1), (2, 0), (0, 2))
"""The kinds of spring in a cloth, in columns and rows."""

Window = tuple[slice, slice]
Array = NDArray[Any]


class Network:
    """What the body is, in the precision of the run."""

    def __init__(self, body: pc.SpringNetwork, shape: tuple[int, int], dtype: type, h: float, gravity: float) -> None:
        self.body, self.dtype = body, dtype
        self.grid = shape[::-1]
        self.x, self.y = columns(body.positions, dtype)
        self.u, self.v = columns(body.velocities, dtype)
        self.k, self.c, self.rest = self._narrow(body.stiffness, body.damping, body.rest_length)
        self.weight, self.down = self._narrow(
            np.where(body.fixed, 0.0, 1.0 / body.mass), np.where(body.fixed, 0.0, gravity)
        )
        self.a, self.b = np.zeros_like(self.x), np.zeros_like(self.x)
        self.long, self.short = dtype(h), dtype(0.5 * h)
        self.begin()

    def _narrow(self, *arrays: Array) -> tuple[Array, ...]:
        return tuple(array.astype(self.dtype) for array in arrays)

    def begin(self) -> None:
        """Find the acceleration at the start."""
        raise NotImplementedError

    def step(self, steps: int) -> None:
        """Advance by a number of steps."""
        raise NotImplementedError

    def positions(self) -> Array:
        """Positions [m], shape (N, 2)."""
        return np.stack([self.x, self.y], axis=1)

    def kinds(self) -> list[tuple[Window, Window, int]]:
        """Where the lower and the upper ends of each kind of spring are in the grid, and the first of its springs."""
        windows, first = [], 0
        for offset in OFFSETS:
            (low, high), (other_low, other_high) = (
                (slice(max(0, -o), size - max(0, o)), slice(max(0, o), size + min(0, o)))
                for o, size in zip(offset[::-1], self.grid, strict=True)
            )
            windows.append(((low, other_low), (high, other_high), first))
            first += (self.grid[0] - abs(offset[1])) * (self.grid[1] - abs(offset[0]))
        return windows


Maker = Callable[[pc.SpringNetwork, tuple[int, int], type, float, float], Network]


class NumpyNetwork(Network):
    """The integrator; versions differ in how springs act on their ends."""

    def begin(self) -> None:
        """Find the acceleration at the start."""
        self._accelerate(self.u, self.v)

    def step(self, steps: int) -> None:
        """Advance in place."""
        for _ in range(steps):
            for x, v, a in ((self.x, self.u, self.a), (self.y, self.v, self.b)):
                a *= self.short
                v += a
                x += self.long * v
            self._accelerate(self.u + self.a, self.v + self.b)
            for v, a in ((self.u, self.a), (self.v, self.b)):
                v += self.short * a

    def _accelerate(self, u: Array, v: Array) -> None:
        """Fill the accelerations, given the predicted velocities."""
        self.sum(u, v)
        self.a *= self.weight
        self.b *= self.weight
        self.b += self.down

    def sum(self, u: Array, v: Array) -> None:
        """Set the forces on all particles."""
        raise NotImplementedError


def pull(dx: Array, dy: Array, du: Array, dv: Array, k: Any, c: Any, rest: Any) -> tuple[Array, Array]:
    """The force on the first end of springs along (dx, dy); works in its arguments."""
    square = dx * dx
    square += dy * dy
    length = np.sqrt(square)
    du *= dx
    dv *= dy
    du += dv
    du /= square
    du *= c
    strain = length - rest
    strain /= length
    strain *= k
    strain += du
    dx *= strain
    dy *= strain
    return dx, dy


class Bincount(NumpyNetwork):
    """Any network."""

    def sum(self, u: Array, v: Array) -> None:
        """Set the forces on all particles."""
        i, j = self.body.pairs.T
        n, x, y = len(self.x), self.x, self.y
        fx, fy = pull(x[j] - x[i], y[j] - y[i], u[j] - u[i], v[j] - v[i], self.k, self.c, self.rest)
        self.a[:] = np.bincount(i, fx, n) - np.bincount(j, fx, n)
        self.b[:] = np.bincount(i, fy, n) - np.bincount(j, fy, n)


class Slices(NumpyNetwork):
    """A grid with one law for all springs of a kind."""

    def sum(self, u: Array, v: Array) -> None:
        """Set the forces on all particles."""
        x, y, u, v, a, b = (array.reshape(self.grid) for array in (self.x, self.y, u, v, self.a, self.b))
        a[:], b[:] = 0, 0
        for near, far, first in self.kinds():
            law = (self.k[first], self.c[first], self.rest[first])
            fx, fy = pull(x[far] - x[near], y[far] - y[near], u[far] - u[near], v[far] - v[near], *law)
            a[near] += fx
            a[far] -= fx
            b[near] += fy
            b[far] -= fy
