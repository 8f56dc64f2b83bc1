"""A cloth of damped springs in 2D by velocity Verlet, with damping at the predicted velocity, as physcore has it.

Of an arbitrary network, springs scatter to their ends (NumPy's bincount) or particles gather from their partners (Numba).
Of a grid, springs of one kind join slices that are shifted against each other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import prange  # type: ignore[import-untyped]
from numpy.typing import NDArray

import physcore as pc
from rivals.jit import columns, jit

OFFSETS = ((1, 0), (0, 1), (1, 1), (-1, 1), (2, 0), (0, 2))
"""The kinds of spring in a cloth, in columns and rows."""


@dataclass
class Network:
    """What the body is, in the precision of the run."""

    body: pc.SpringNetwork
    shape: tuple[int, int]
    dtype: type
    h: float
    gravity: float

    def __post_init__(self) -> None:
        self.x, self.y = columns(self.body.positions, self.dtype)
        self.u, self.v = columns(self.body.velocities, self.dtype)
        self.weight = np.where(self.body.fixed, 0.0, 1.0 / self.body.mass).astype(self.dtype)
        self.k, self.c, self.rest = (
            array.astype(self.dtype) for array in (self.body.stiffness, self.body.damping, self.body.rest_length)
        )
        self.pull_down = np.where(self.body.fixed, 0.0, self.gravity).astype(self.dtype)
        self.a, self.b = np.zeros_like(self.x), np.zeros_like(self.x)
        self.long, self.short = self.dtype(self.h), self.dtype(0.5 * self.h)
        self.begin()

    def begin(self) -> None:
        """Find the acceleration at the start."""
        raise NotImplementedError

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (N, 2)."""
        return np.stack([self.x, self.y], axis=1)


class NumpyNetwork(Network):
    """The integrator; versions differ in `forces`."""

    def begin(self) -> None:
        """Find the acceleration at the start."""
        self.forces(self.u, self.v)

    def step(self, steps: int) -> None:
        """Advance in place."""
        for _ in range(steps):
            for x, v, a in ((self.x, self.u, self.a), (self.y, self.v, self.b)):
                a *= self.short
                v += a
                x += self.long * v
            self.forces(self.u + self.a, self.v + self.b)
            for v, a in ((self.u, self.a), (self.v, self.b)):
                v += self.short * a

    def forces(self, u: Any, v: Any) -> None:
        """Fill the accelerations, given the predicted velocities."""
        raise NotImplementedError

    def pull(self, dx: Any, dy: Any, du: Any, dv: Any, k: Any, c: Any, rest: Any) -> tuple[Any, Any]:
        """The force on the first end of springs along (dx, dy)."""
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

    def forces(self, u: Any, v: Any) -> None:
        i, j = self.body.pairs.T
        n = len(self.x)
        x, y = self.x, self.y
        fx, fy = self.pull(x[j] - x[i], y[j] - y[i], u[j] - u[i], v[j] - v[i], self.k, self.c, self.rest)
        self.a[:] = np.bincount(i, fx, n) - np.bincount(j, fx, n)
        self.b[:] = np.bincount(i, fy, n) - np.bincount(j, fy, n)
        self.a *= self.weight
        self.b *= self.weight
        self.b += self.pull_down


class Slices(NumpyNetwork):
    """A grid with one law for all springs of a kind."""

    def forces(self, u: Any, v: Any) -> None:
        grid = self.shape[::-1]
        x, y, u, v, a, b = (array.reshape(grid) for array in (self.x, self.y, u, v, self.a, self.b))
        a[:], b[:] = 0, 0
        start = 0
        for near, far, count in kinds(self.shape):
            law = (self.k[start], self.c[start], self.rest[start])
            fx, fy = self.pull(x[far] - x[near], y[far] - y[near], u[far] - u[near], v[far] - v[near], *law)
            a[near] += fx
            a[far] -= fx
            b[near] += fy
            b[far] -= fy
            start += count
        self.a *= self.weight
        self.b *= self.weight
        self.b += self.pull_down


Window = tuple[slice, slice]


def kinds(shape: tuple[int, int]) -> list[tuple[Window, Window, int]]:
    """Where the lower and the upper ends of each kind of spring are in the grid, and their number."""
    windows = []
    for column, row in OFFSETS:
        near = tuple(slice(max(0, -o), size - max(0, o)) for o, size in zip((row, column), shape[::-1], strict=True))
        far = tuple(slice(max(0, o), size + min(0, o)) for o, size in zip((row, column), shape[::-1], strict=True))
        count = (shape[0] - abs(column)) * (shape[1] - abs(row))
        windows.append(((near[0], near[1]), (far[0], far[1]), count))
    return windows


def numba_network(fastmath: bool, grid: bool) -> type[Network]:
    """Two sweeps per step: one moves all particles, one sums the forces and ends the kicks."""

    @jit(fastmath, parallel=True)
    def move(x: Any, y: Any, u: Any, v: Any, a: Any, b: Any, p: Any, q: Any, long: Any, short: Any) -> None:
        for i in prange(x.size):
            kick, rise = short * a[i], short * b[i]
            u[i] += kick
            v[i] += rise
            x[i] += long * u[i]
            y[i] += long * v[i]
            p[i], q[i] = u[i] + kick, v[i] + rise

    @jit(fastmath, parallel=True)
    def gather(
        x: Any, y: Any, p: Any, q: Any, u: Any, v: Any, a: Any, b: Any, first: Any, partner: Any, laws: Any,
        weight: Any, down: Any, short: Any, one: Any,
    ) -> None:  # fmt: skip
        k, c, rest = laws[0], laws[1], laws[2]
        for i in prange(x.size):
            fx, fy = one - one, one - one
            for e in range(first[i], first[i + 1]):
                j = partner[e]
                dx, dy = x[j] - x[i], y[j] - y[i]
                length = np.sqrt(dx * dx + dy * dy)
                inverse = one / length
                rate = ((p[j] - p[i]) * dx + (q[j] - q[i]) * dy) * inverse
                pull = (k[e] * (length - rest[e]) + c[e] * rate) * inverse
                fx += pull * dx
                fy += pull * dy
            a[i], b[i] = fx * weight[i], fy * weight[i] + down[i]
            u[i] += short * a[i]
            v[i] += short * b[i]

    @jit(fastmath)
    def row(x: Any, y: Any, p: Any, q: Any, X: Any, Y: Any, P: Any, Q: Any, k: Any, c: Any, rest: Any, one: Any, fx: Any, fy: Any) -> None:  # noqa: E501, N803
        for i in range(x.size):
            dx, dy = X[i] - x[i], Y[i] - y[i]
            length = np.sqrt(dx * dx + dy * dy)
            inverse = one / length
            rate = ((P[i] - p[i]) * dx + (Q[i] - q[i]) * dy) * inverse
            pull = (k * (length - rest) + c * rate) * inverse
            fx[i] += pull * dx
            fy[i] += pull * dy

    @jit(fastmath)
    def finish(a: Any, b: Any, u: Any, v: Any, weight: Any, down: Any, short: Any) -> None:
        for i in range(a.size):
            a[i], b[i] = a[i] * weight[i], b[i] * weight[i] + down[i]
            u[i] += short * a[i]
            v[i] += short * b[i]

    @jit(fastmath, parallel=True)
    def shifted(
        x: Any, y: Any, p: Any, q: Any, u: Any, v: Any, a: Any, b: Any, offsets: Any, laws: Any, weight: Any,
        down: Any, short: Any, one: Any,
    ) -> None:  # fmt: skip
        rows, size = x.shape
        for r in prange(rows):
            a[r, :] = one - one
            b[r, :] = one - one
            for e in range(offsets.shape[0]):
                dc, s = offsets[e, 0], r + offsets[e, 1]
                if 0 <= s < rows:
                    i, j = max(0, -dc), size - max(0, dc)
                    I, J = i + dc, j + dc  # noqa: E741, N806
                    row(
                        x[r, i:j], y[r, i:j], p[r, i:j], q[r, i:j], x[s, I:J], y[s, I:J], p[s, I:J], q[s, I:J],
                        laws[0, e], laws[1, e], laws[2, e], one, a[r, i:j], b[r, i:j],
                    )  # fmt: skip
            finish(a[r], b[r], u[r], v[r], weight[r], down[r], short)

    class NumbaNetwork(Network):
        def begin(self) -> None:
            self.p, self.q = self.u.copy(), self.v.copy()
            if grid:
                starts = np.cumsum([0, *(count for *_, count in kinds(self.shape))])[:-1]
                self.laws = np.tile(np.stack([self.k[starts], self.c[starts], self.rest[starts]]), 2)
                self.ends = (np.concatenate([np.array(OFFSETS), -np.array(OFFSETS)]),)
            else:
                first, partner, self.laws = compressed(self)
                self.ends = (first, partner)
            self.sum(self.dtype(0.0))

        def sum(self, short: Any) -> None:
            state = (self.x, self.y, self.p, self.q, self.u, self.v, self.a, self.b)
            factors = (self.weight, self.pull_down)
            if grid:
                state, factors = (tuple(one.reshape(self.shape[::-1]) for one in all) for all in (state, factors))
            (shifted if grid else gather)(*state, *self.ends, self.laws, *factors, short, self.dtype(1.0))

        def step(self, steps: int) -> None:
            for _ in range(steps):
                move(self.x, self.y, self.u, self.v, self.a, self.b, self.p, self.q, self.long, self.short)
                self.sum(self.short)

    return NumbaNetwork


def compressed(network: Network) -> tuple[Any, Any, Any]:
    """The partners of every particle and the laws of their springs, particle by particle."""
    ends = np.concatenate([network.body.pairs, network.body.pairs[:, ::-1]])
    order = np.argsort(ends[:, 0], kind="stable")
    first = np.searchsorted(ends[order, 0], np.arange(len(network.x) + 1)).astype(np.int32)
    laws = np.stack([np.tile(values, 2)[order] for values in (network.k, network.c, network.rest)])
    return first, ends[order, 1].astype(np.int32), np.ascontiguousarray(laws)


Maker = Callable[[pc.SpringNetwork, tuple[int, int], type, float, float], Network]
