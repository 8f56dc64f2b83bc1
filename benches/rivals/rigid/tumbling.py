"""Free rotation of bodies of one shape as NumPy and Numba users write it, by a symmetric splitting of order 2.

Bodies turn about their angular momentum, then about two of their axes and back: the splitting that is physcore's, with
the components of the angular momentum along the axes of the body in memory, and the first turn once and for all.
Source: F. Fassò, J. Comput. Phys. 189, 527 (2003).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rivals.jit import columns, jit
from rivals.rigid.pile import Array, rotations

SERIES = 0.5
"""Largest half of an angle for which the Taylor series is exact to rounding."""


class Tumbling:
    """An opponent's state, one array per component; axes are renamed so that the axis of reference is the first."""

    def __init__(self, moments: Array, turns: Array, spins: Array, velocities: Array, h: float) -> None:
        inverse = 1.0 / moments
        spread = [abs((inverse[k - 2] - inverse[k]) * (inverse[k - 1] - inverse[k])) for k in range(3)]
        first = int(np.argmin(spread))
        order = [first, (first + 1) % 3, (first + 2) % 3]
        along = np.einsum("bij,bi->bj", rotations(turns), spins) * moments
        momentum = np.einsum("bij,bj->bi", rotations(turns), along)
        angle = 0.5 * h * inverse[first] * np.linalg.norm(momentum, axis=1)
        turned = 0.5 * h * inverse[first] * np.sinc(angle / np.pi)[:, None] * momentum
        self.l, self.q = (
            columns(along[:, order], np.float64),
            columns(turns[:, [0, *(k + 1 for k in order)]], np.float64),
        )
        # The turn about the angular momentum, along the axes of the world, which are renamed too.
        self.r = columns(np.column_stack([np.cos(angle), turned[:, order]]), np.float64)
        self.x, self.v = columns(np.zeros_like(velocities), np.float64), columns(velocities, np.float64)
        self.h, self.factors = h, (0.5 * h * (inverse[order[1:]] - inverse[first])).tolist()
        largest = max(abs(factor) for factor in self.factors) * np.linalg.norm(momentum, axis=1).max()
        assert largest < SERIES, "the Taylor series needs smaller steps"
        self.order = order

    def turns(self) -> Array:
        """Quaternions (w, x, y, z), shape (B, 4)."""
        out = np.empty((len(self.q[0]), 4))
        out[:, 0] = self.q[0]
        for k, axis in enumerate(self.order):
            out[:, axis + 1] = self.q[k + 1]
        return out

    def step(self, steps: int) -> None:
        """Take steps."""
        raise NotImplementedError


class NumpyTumbling(Tumbling):
    """Whole arrays at a time."""

    def step(self, steps: int) -> None:
        """Take steps."""
        (w, x, y, z), (rw, rx, ry, rz), (a, b, c) = self.q, self.r, self.l
        first, second = self.factors
        for _ in range(steps):
            for place, velocity in zip(self.x, self.v, strict=True):
                place += self.h * velocity
            w[:], x[:], y[:], z[:] = (
                rw * w - rx * x - ry * y - rz * z,
                rw * x + rx * w + ry * z - rz * y,
                rw * y + ry * w + rz * x - rx * z,
                rw * z + rz * w + rx * y - ry * x,
            )
            for one, factor in ((True, 0.5 * first), (False, second), (True, 0.5 * first)):
                half = factor * (b if one else c)
                cos, sin = np.cos(half), np.sin(half)
                twice, full = 2.0 * sin * cos, 1.0 - 2.0 * sin * sin
                if one:
                    c[:], a[:] = full * c + twice * a, full * a - twice * c
                    w[:], y[:] = cos * w - sin * y, cos * y + sin * w
                    x[:], z[:] = cos * x - sin * z, cos * z + sin * x
                else:
                    a[:], b[:] = full * a + twice * b, full * b - twice * a
                    w[:], z[:] = cos * w - sin * z, cos * z + sin * w
                    x[:], y[:] = cos * x + sin * y, cos * y - sin * x


VERSIONS = {"sin and cos": False, "series": True}
"""Ways to compute them: by the library at any angle, or by Taylor's series at small ones."""


def sine_and_cosine(fastmath: bool, series: bool) -> Callable[[float], tuple[float, float]]:
    """Both of a small angle: by the library, or by Taylor's series, which vectorizes."""

    @jit(fastmath)
    def by_library(angle: float) -> tuple[float, float]:
        return np.sin(angle), np.cos(angle)

    sines, cosines = ([(-1.0) ** k / np.prod(np.arange(1.0, 2 * k + odd + 1)) for k in range(8)] for odd in (1, 0))
    s1, s2, s3, s4, s5, s6 = map(float, sines[1:7])
    c1, c2, c3, c4, c5, c6, c7 = map(float, cosines[1:8])

    @jit(fastmath)
    def by_series(angle: float) -> tuple[float, float]:
        t = angle * angle
        sin = angle + angle * t * (s1 + t * (s2 + t * (s3 + t * (s4 + t * (s5 + t * s6)))))
        return sin, 1.0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * (c5 + t * (c6 + t * c7))))))

    return by_series if series else by_library


def numba_tumbling(fastmath: bool, series: bool) -> type[Tumbling]:
    """Compiled, body by body."""
    both = sine_and_cosine(fastmath, series)

    @jit(fastmath)
    def steps(
        w: Array,
        x: Array,
        y: Array,
        z: Array,
        rw: Array,
        rx: Array,
        ry: Array,
        rz: Array,
        a: Array,
        b: Array,
        c: Array,
        first: float,
        second: float,
    ) -> None:
        for i in range(len(w)):
            qw, qx, qy, qz, la, lb, lc = w[i], x[i], y[i], z[i], a[i], b[i], c[i]
            qw, qx, qy, qz = (
                rw[i] * qw - rx[i] * qx - ry[i] * qy - rz[i] * qz,
                rw[i] * qx + rx[i] * qw + ry[i] * qz - rz[i] * qy,
                rw[i] * qy + ry[i] * qw + rz[i] * qx - rx[i] * qz,
                rw[i] * qz + rz[i] * qw + rx[i] * qy - ry[i] * qx,
            )
            sin, cos = both(0.5 * first * lb)
            twice, full = 2.0 * sin * cos, 1.0 - 2.0 * sin * sin
            lc, la = full * lc + twice * la, full * la - twice * lc
            qw, qy, qx, qz = cos * qw - sin * qy, cos * qy + sin * qw, cos * qx - sin * qz, cos * qz + sin * qx
            sin, cos = both(second * lc)
            twice, full = 2.0 * sin * cos, 1.0 - 2.0 * sin * sin
            la, lb = full * la + twice * lb, full * lb - twice * la
            qw, qz, qx, qy = cos * qw - sin * qz, cos * qz + sin * qw, cos * qx + sin * qy, cos * qy - sin * qx
            sin, cos = both(0.5 * first * lb)
            twice, full = 2.0 * sin * cos, 1.0 - 2.0 * sin * sin
            lc, la = full * lc + twice * la, full * la - twice * lc
            qw, qy, qx, qz = cos * qw - sin * qy, cos * qy + sin * qw, cos * qx - sin * qz, cos * qz + sin * qx
            w[i], x[i], y[i], z[i], a[i], b[i], c[i] = qw, qx, qy, qz, la, lb, lc

    @jit(fastmath)
    def drift(x: Array, v: Array, h: float) -> None:
        for i in range(len(x)):
            x[i] += h * v[i]

    class NumbaTumbling(Tumbling):
        """Loops."""

        def step(self, count: int) -> None:
            """Take steps."""
            for _ in range(count):
                for x, v in zip(self.x, self.v, strict=True):
                    drift(x, v, self.h)
                steps(*self.q, *self.r, *self.l, *self.factors)

    return NumbaTumbling
