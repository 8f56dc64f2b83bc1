"""A cloth of damped springs in 2D by velocity Verlet: Numba. Particles gather, so that all cores can share the work.

Two sweeps per step: one moves all particles, one sums the forces and ends the kicks. In an arbitrary network a particle
goes through the list of its partners; in a grid a row adds up twelve rows that are shifted against it, vectorised.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rivals.jit import jit, prange
from rivals.springs import OFFSETS, Network


def numba_network(fastmath: bool, grid: bool) -> type[Network]:
    """A version for grids, or for any network."""
    move, sweep = _move(fastmath), (_shifted if grid else _gather)(fastmath)

    class NumbaNetwork(Network):
        def begin(self) -> None:
            self.p, self.q = self.u.copy(), self.v.copy()
            state = (self.x, self.y, self.p, self.q, self.u, self.v, self.a, self.b, self.weight, self.down)
            self.ends: tuple[Any, ...]
            if grid:
                first = [first for *_, first in self.kinds()]
                self.laws = np.tile(np.stack([self.k[first], self.c[first], self.rest[first]]), 2)
                self.ends = (np.concatenate([np.array(OFFSETS), -np.array(OFFSETS)]),)
                self.state = tuple(array.reshape(self.grid) for array in state)
            else:
                first_end, partner, self.laws = _compressed(self)
                self.ends = (first_end, partner)
                self.state = state
            self._sum(self.dtype(0.0))

        def step(self, steps: int) -> None:
            for _ in range(steps):
                move(self.x, self.y, self.u, self.v, self.a, self.b, self.p, self.q, self.long, self.short)
                self._sum(self.short)

        def _sum(self, short: Any) -> None:
            sweep(self.state, *self.ends, self.laws, short, self.dtype(1.0))

    return NumbaNetwork


def _compressed(network: Network) -> tuple[Any, Any, Any]:
    """The partners of every particle and the laws of their springs, particle by particle."""
    ends = np.concatenate([network.body.pairs, network.body.pairs[:, ::-1]])
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    first = np.searchsorted(ends[order, 0], np.arange(len(network.x) + 1)).astype(np.int32)
    laws = np.stack([np.tile(values, 2)[order] for values in (network.k, network.c, network.rest)])
    return first, ends[order, 1].astype(np.int32), np.ascontiguousarray(laws)


def _move(fastmath: bool) -> Any:
    """Half a kick and the drift; p and q are the predicted velocities."""

    @jit(fastmath, parallel=True)
    def move(x: Any, y: Any, u: Any, v: Any, a: Any, b: Any, p: Any, q: Any, long: Any, short: Any) -> None:
        for i in prange(x.size):
            kick, rise = short * a[i], short * b[i]
            u[i] += kick
            v[i] += rise
            x[i] += long * u[i]
            y[i] += long * v[i]
            p[i], q[i] = u[i] + kick, v[i] + rise

    return move


def _gather(fastmath: bool) -> Any:
    """Forces and half a kick of any network."""

    @jit(fastmath)
    def force(i: int, x: Any, y: Any, p: Any, q: Any, ends: range, partner: Any, laws: Any, one: Any) -> Any:
        k, c, rest = laws[0], laws[1], laws[2]
        fx, fy = one - one, one - one
        for e in ends:
            j = partner[e]
            dx, dy = x[j] - x[i], y[j] - y[i]
            length = np.sqrt(dx * dx + dy * dy)
            inverse = one / length
            rate = ((p[j] - p[i]) * dx + (q[j] - q[i]) * dy) * inverse
            pull = (k[e] * (length - rest[e]) + c[e] * rate) * inverse
            fx += pull * dx
            fy += pull * dy
        return fx, fy

    # A function of its own: in a parallel loop Numba loses what is written to arrays that were unpacked from a tuple.
    @jit(fastmath)
    def one_particle(i: int, state: Any, first: Any, partner: Any, laws: Any, short: Any, one: Any) -> None:
        x, y, p, q, u, v, a, b, weight, down = state
        fx, fy = force(i, x, y, p, q, range(first[i], first[i + 1]), partner, laws, one)
        a[i], b[i] = fx * weight[i], fy * weight[i] + down[i]
        u[i] += short * a[i]
        v[i] += short * b[i]

    @jit(fastmath, parallel=True)
    def gather(state: Any, first: Any, partner: Any, laws: Any, short: Any, one: Any) -> None:
        for i in prange(first.size - 1):
            one_particle(i, state, first, partner, laws, short, one)

    return gather


def _shifted(fastmath: bool) -> Any:
    """Forces and half a kick of a grid."""

    @jit(fastmath)
    def row(near: Any, far: Any, force: Any, k: Any, c: Any, rest: Any, one: Any) -> None:
        x, y, p, q = near
        other_x, other_y, other_p, other_q = far
        fx, fy = force
        for i in range(x.size):
            dx, dy = other_x[i] - x[i], other_y[i] - y[i]
            length = np.sqrt(dx * dx + dy * dy)
            inverse = one / length
            rate = ((other_p[i] - p[i]) * dx + (other_q[i] - q[i]) * dy) * inverse
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
    def shifted(state: Any, offsets: Any, laws: Any, short: Any, one: Any) -> None:
        x, y, p, q, u, v, a, b, weight, down = state
        rows, size = x.shape
        for r in prange(rows):
            a[r, :] = one - one
            b[r, :] = one - one
            for e in range(offsets.shape[0]):
                shift, s = offsets[e, 0], r + offsets[e, 1]
                if 0 <= s < rows:
                    i, j = max(0, -shift), size - max(0, shift)
                    m, n = i + shift, j + shift
                    near = (x[r, i:j], y[r, i:j], p[r, i:j], q[r, i:j])
                    far = (x[s, m:n], y[s, m:n], p[s, m:n], q[s, m:n])
                    row(near, far, (a[r, i:j], b[r, i:j]), laws[0, e], laws[1, e], laws[2, e], one)
            finish(a[r], b[r], u[r], v[r], weight[r], down[r], short)

    return shifted
