"""Independent particles in 3D: velocity Verlet under gravity and linear drag, RK4 in an inverse-square field.

All take blocks of particles that stay in the cache, through all steps, and keep one array per component. The Numba
versions take several steps per pass over the block, in registers. Masses are 1 kg.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rivals.jit import columns, jit, prange

NUMPY_BLOCK = 8192
NUMBA_BLOCK = 1024

Vectors = NDArray[np.float64]


class Swarm:
    """Particles as one array per component; `step` moves them."""

    dissipated: float | None = None
    """Energy that drag has dissipated [J]; None where it is not summed."""

    def __init__(self, positions: Vectors, velocities: Vectors, dtype: type, h: float) -> None:
        self.x = columns(positions, dtype)
        self.v = columns(velocities, dtype)
        self.dtype = dtype
        self.h = dtype(h)
        self.half = dtype(0.5 * h)

    def step(self, steps: int) -> None:
        """Advance by a number of steps."""
        raise NotImplementedError

    def positions(self) -> NDArray[Any]:
        """Positions [m], shape (N, 3)."""
        return np.stack(self.x, axis=1)


class Falling(Swarm):
    """Under gravity g [m/s²] and the drag −γv [N]."""

    def __init__(
        self, positions: Vectors, velocities: Vectors, dtype: type, h: float, gravity: float, drag: float
    ) -> None:
        super().__init__(positions, velocities, dtype, h)
        self.g = [dtype(0.0), dtype(0.0), dtype(gravity)]
        self.b = dtype(-drag)
        self.a = [g + self.b * v for g, v in zip(self.g, self.v, strict=True)]


class NumpyFalling(Falling):
    """In place, with two scratch arrays."""

    def step(self, steps: int) -> None:
        """Advance every block by all steps."""
        kicks: Any = np.empty(NUMPY_BLOCK, self.dtype)
        scratch = np.empty_like(kicks)
        for start in range(0, len(self.x[0]), NUMPY_BLOCK):
            for x, v, a, g in zip(self.x, self.v, self.a, self.g, strict=True):
                part = slice(start, start + NUMPY_BLOCK)
                self._block(x[part], v[part], a[part], g, kicks, scratch, steps)

    def _block(self, x: Any, v: Any, a: Any, g: Any, kicks: Any, scratch: Any, steps: int) -> None:
        kick, t = kicks[: len(x)], scratch[: len(x)]
        for _ in range(steps):
            np.multiply(a, self.half, out=kick)
            v += kick
            np.multiply(v, self.h, out=t)
            x += t
            np.add(v, kick, out=a)
            a *= self.b
            a += g
            np.multiply(a, self.half, out=t)
            v += t


def numba_falling(fastmath: bool, fused: int) -> type[Falling]:
    """A version that takes `fused` steps per pass."""

    @jit(fastmath)
    def block(x: Any, v: Any, a: Any, g: Any, b: Any, h: Any, half: Any, passes: int) -> None:
        for _ in range(passes):
            for i in range(x.size):
                xi, vi, ai = x[i], v[i], a[i]
                for _step in range(fused):
                    kick = half * ai
                    middle = vi + kick
                    xi += h * middle
                    ai = g + b * (middle + kick)
                    vi = middle + half * ai
                x[i], v[i], a[i] = xi, vi, ai

    @jit(fastmath, parallel=True)
    def sweep(position: Any, velocity: Any, acceleration: Any, g: Any, b: Any, h: Any, half: Any, passes: int) -> None:
        (x, y, z), (u, v, w), (ax, ay, az) = position, velocity, acceleration
        for index in prange((x.size + NUMBA_BLOCK - 1) // NUMBA_BLOCK):
            i, j = index * NUMBA_BLOCK, min((index + 1) * NUMBA_BLOCK, x.size)
            block(x[i:j], u[i:j], ax[i:j], g[0], b, h, half, passes)
            block(y[i:j], v[i:j], ay[i:j], g[1], b, h, half, passes)
            block(z[i:j], w[i:j], az[i:j], g[2], b, h, half, passes)

    class NumbaFalling(Falling):
        def step(self, steps: int) -> None:
            state = tuple(self.x), tuple(self.v), tuple(self.a)
            sweep(*state, tuple(self.g), self.b, self.h, self.half, steps // fused)

    return NumbaFalling


def numba_tallied(fastmath: bool, fused: int) -> type[Falling]:
    """A version that does the work of physcore: it sums what drag dissipates in every step, in double precision, and
    finds at the end of each pass whether a kinetic energy is not finite.
    """

    @jit(fastmath)
    def block(x: Any, v: Any, a: Any, g: Any, b: Any, h: Any, half: Any, passes: int, kinetic: Any) -> Any:
        lost = 0.0
        for index in range(passes):
            energy = 0.0
            for i in range(x.size):
                xi, vi, ai = x[i], v[i], a[i]
                power = vi - vi
                for _step in range(fused):
                    kick = half * ai
                    middle = vi + kick
                    xi += h * middle
                    ai = g + b * (middle + kick)
                    vi = middle + half * ai
                    power += middle * middle
                x[i], v[i], a[i] = xi, vi, ai
                lost += power
                energy += vi * vi
            kinetic[index] += energy
        return lost

    @jit(fastmath, parallel=True)
    def sweep(
        position: Any, velocity: Any, acceleration: Any, g: Any, b: Any, h: Any, half: Any, passes: int, kinetic: Any
    ) -> Any:
        (x, y, z), (u, v, w), (ax, ay, az) = position, velocity, acceleration
        lost = np.zeros(kinetic.shape[0])
        for index in prange((x.size + NUMBA_BLOCK - 1) // NUMBA_BLOCK):
            i, j = index * NUMBA_BLOCK, min((index + 1) * NUMBA_BLOCK, x.size)
            lost[index] += block(x[i:j], u[i:j], ax[i:j], g[0], b, h, half, passes, kinetic[index])
            lost[index] += block(y[i:j], v[i:j], ay[i:j], g[1], b, h, half, passes, kinetic[index])
            lost[index] += block(z[i:j], w[i:j], az[i:j], g[2], b, h, half, passes, kinetic[index])
        return lost.sum()

    class NumbaTallied(Falling):
        def __init__(self, *state: Any) -> None:
            super().__init__(*state)
            self.dissipated = 0.0

        def step(self, steps: int) -> None:
            blocks, passes = (self.x[0].size + NUMBA_BLOCK - 1) // NUMBA_BLOCK, steps // fused
            kinetic = np.zeros((blocks, passes))
            state = tuple(self.x), tuple(self.v), tuple(self.a)
            lost = sweep(*state, tuple(self.g), self.b, self.h, self.half, passes, kinetic)
            self.dissipated = (self.dissipated or 0.0) - float(self.b) * float(self.h) * lost
            if not np.isfinite(kinetic.sum(axis=0)).all():
                raise FloatingPointError("a particle has left")

    return NumbaTallied


class NumpyOrbit(Swarm):
    """Attracted to the origin by 1/r² [N]; the classical Runge–Kutta method."""

    def step(self, steps: int) -> None:
        """Advance every block by all steps."""
        sixth = self.dtype(self.h / 6)
        for start in range(0, len(self.x[0]), NUMPY_BLOCK):
            part = slice(start, start + NUMPY_BLOCK)
            x, v = (np.stack([component[part] for component in given]) for given in (self.x, self.v))
            for _ in range(steps):
                self._one(x, v, sixth)
            for axis in range(3):
                self.x[axis][part], self.v[axis][part] = x[axis], v[axis]

    def _one(self, x: Any, v: Any, sixth: Any) -> None:
        """One step of a block of shape (3, B)."""
        place, speed = x, v
        sum_x, sum_v = np.zeros_like(x), np.zeros_like(v)
        for weight, reach in ((1, self.half), (2, self.half), (2, self.h), (1, None)):
            square = place[0] * place[0]
            square += place[1] * place[1]
            square += place[2] * place[2]
            pull = np.sqrt(square)
            pull *= square
            np.divide(self.dtype(-1.0), pull, out=pull)
            a = place * pull
            sum_x += speed if weight == 1 else speed + speed
            sum_v += a if weight == 1 else a + a
            if reach is not None:
                place = speed * reach
                place += x
                speed = np.multiply(a, reach, out=a)
                speed += v
        x += np.multiply(sum_x, sixth, out=sum_x)
        v += np.multiply(sum_v, sixth, out=sum_v)


def numba_orbit(fastmath: bool) -> type[Swarm]:
    """A version that takes one step per pass; more of them in registers would only spill."""

    @jit(fastmath)
    def pull(x: Any, y: Any, z: Any, one: Any) -> Any:
        q = x * x + y * y + z * z
        return -one / (q * np.sqrt(q))

    @jit(fastmath)
    def block(x: Any, y: Any, z: Any, u: Any, v: Any, w: Any, h: Any, half: Any, sixth: Any, one: Any, n: int) -> None:
        for _ in range(n):
            for i in range(x.size):
                x0, y0, z0, u0, v0, w0 = x[i], y[i], z[i], u[i], v[i], w[i]
                p = pull(x0, y0, z0, one)
                a1, b1, c1 = p * x0, p * y0, p * z0
                x2, y2, z2 = x0 + half * u0, y0 + half * v0, z0 + half * w0
                u2, v2, w2 = u0 + half * a1, v0 + half * b1, w0 + half * c1
                p = pull(x2, y2, z2, one)
                a2, b2, c2 = p * x2, p * y2, p * z2
                x3, y3, z3 = x0 + half * u2, y0 + half * v2, z0 + half * w2
                u3, v3, w3 = u0 + half * a2, v0 + half * b2, w0 + half * c2
                p = pull(x3, y3, z3, one)
                a3, b3, c3 = p * x3, p * y3, p * z3
                x4, y4, z4 = x0 + h * u3, y0 + h * v3, z0 + h * w3
                u4, v4, w4 = u0 + h * a3, v0 + h * b3, w0 + h * c3
                p = pull(x4, y4, z4, one)
                us, vs, ws = u2 + u3, v2 + v3, w2 + w3
                a, b, c = a2 + a3, b2 + b3, c2 + c3
                x[i] = x0 + sixth * (u0 + us + us + u4)
                y[i] = y0 + sixth * (v0 + vs + vs + v4)
                z[i] = z0 + sixth * (w0 + ws + ws + w4)
                u[i] = u0 + sixth * (a1 + a + a + p * x4)
                v[i] = v0 + sixth * (b1 + b + b + p * y4)
                w[i] = w0 + sixth * (c1 + c + c + p * z4)

    @jit(fastmath, parallel=True)
    def sweep(position: Any, velocity: Any, h: Any, half: Any, sixth: Any, one: Any, n: int) -> None:
        (x, y, z), (u, v, w) = position, velocity
        for k in prange((x.size + NUMBA_BLOCK - 1) // NUMBA_BLOCK):
            i, j = k * NUMBA_BLOCK, min((k + 1) * NUMBA_BLOCK, x.size)
            block(x[i:j], y[i:j], z[i:j], u[i:j], v[i:j], w[i:j], h, half, sixth, one, n)

    class NumbaOrbit(Swarm):
        def step(self, steps: int) -> None:
            sweep(tuple(self.x), tuple(self.v), self.h, self.half, self.dtype(self.h / 6), self.dtype(1.0), steps)

    return NumbaOrbit
