"""A weakly compressible fluid in a box, by the equations and the steps of physcore: Numba.

Each step sorts the particles by cells in its middle, by counting, and with them their images behind the walls: the sums
then run over contiguous rows of cells, which are cut to what is near the particle, without a branch, so that they are
vectorized. Both sums of the step use the same order; cells are larger than the support by what anybody moves meanwhile.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import ceil, pi
from typing import Any

import numpy as np
from numba import prange
from numpy.typing import NDArray

import physcore as pc
from rivals.jit import jit

Array = NDArray[Any]

LANES, MORE, SHIFT = np.uint64(8), np.uint64(7), np.uint64(3)
"""Numbers in a vector of the processor, one less, and the power of two."""
BLOCK = 512
"""Particles that a thread takes at a time."""
FINER = 4
"""Cells in the length of a support along x."""
SLACK = 0.1
"""By how many spacings two particles may come closer in half a step."""

STATE, ROWS = 7, 8
"""Rows of the state: x, y, z, u, v, w and density; the sums read volume and pressure, or enthalpy, in its place."""

DT, SUPPORT, STEEPNESS, MASS, REST, SOUND, ARTIFICIAL, LAMINAR, DIFFUSION, SOFTENING, CELL, FALL = range(12)
LOWER, UPPER, GRAVITY, CORNER = range(4)
ZERO, HALF, ONE, TWO, SIX, SEVEN, FINE = (np.float32(number) for number in (0, 0.5, 1, 2, 6, 7, FINER))


@dataclass(frozen=True)
class Tank:
    """A fluid in a box."""

    fluid: pc.Fluid
    density: Array
    """Of each particle [kg/m³]."""
    sound_speed: float
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    gravity: float
    """Downward, along the last axis [m/s²]."""
    walls: bool = True
    """Whether the box is there."""


class NumbaFluid:
    """The state, and the step."""

    def __init__(self, tank: Tank, dt: float) -> None:
        dtype = np.float32
        fluid = tank.fluid
        self.dimension = fluid.dimension
        self.state = np.zeros((STATE, len(fluid)), dtype)
        self.state[: self.dimension] = fluid.positions.T
        self.state[3 : 3 + self.dimension] = fluid.velocities.T
        self.state[6] = tank.density
        self.identity = np.arange(len(fluid), dtype=np.int32)
        self.acceleration = np.zeros((3, len(fluid)), dtype)

        length = fluid.kernel.smoothing * fluid.spacing
        support = 2.0 * length
        slope = -5.0 * _height(self.dimension) / length ** (self.dimension + 2) / _moment(fluid)
        down = np.zeros(3)
        down[self.dimension - 1] = -tank.gravity
        c, rest = tank.sound_speed, fluid.density
        cell = support + SLACK * fluid.spacing
        lower, upper = np.zeros(3), np.zeros(3)
        lower[: self.dimension], upper[: self.dimension] = tank.lower, tank.upper
        self.shape = np.array(
            [
                ceil((upper[axis] - lower[axis]) / cell) * (FINER if axis == 0 else 1) + 2 * margin
                for axis, margin in zip(range(3), (2 * FINER, 2, 2 if self.dimension == 3 else 0), strict=True)
            ]
        )
        self.shape[2] = max(1, self.shape[2])
        corner = lower - 2 * cell * (np.arange(3) < self.dimension)
        numbers = (
            dt,
            support,
            slope,
            fluid.mass[0],
            rest,
            c,
            fluid.artificial_viscosity * length * c * rest,
            2.0 * fluid.viscosity,
            2.0 * fluid.density_diffusion * length * c,
            0.01 * length**2,
            cell,
            -rest * tank.gravity / c**2,
        )
        self.numbers = np.array(numbers, dtype)
        self.space = np.array([lower, upper, down, corner], dtype)
        self.walls = tank.walls
        self.advance = _compile(self.dimension == 3)
        self.advance(self, first=True)

    def step(self, steps: int) -> None:
        """Advance by a number of steps."""
        for _ in range(steps):
            self.advance(self, first=False)

    def positions(self) -> Array:
        """Positions in the order of the beginning [m], shape (N, D)."""
        return self.state[: self.dimension, np.argsort(self.identity)].T


def _height(dimension: int) -> float:
    """Of Wendland's kernel C2 for unit smoothing length."""
    return (7.0 / (4.0 * pi), 21.0 / (16.0 * pi))[dimension - 2]


def _moment(fluid: pc.Fluid) -> float:
    """What the gradient of a linear field comes out as on a lattice: physcore divides by it."""
    spacing = 1.0 / fluid.kernel.smoothing
    points = spacing * np.array(list(product(range(-4, 5), repeat=fluid.dimension)))
    distance = np.minimum(np.linalg.norm(points, axis=1), 2.0)
    slope = -5.0 * _height(fluid.dimension) * (1.0 - 0.5 * distance) ** 3
    return float(-(slope * points[:, 0] ** 2).sum() * spacing**fluid.dimension)


_COMPILED: dict[bool, Any] = {}


def _compile(three: bool) -> Any:
    """The whole step in two or three dimensions, compiled once."""
    if three not in _COMPILED:
        _COMPILED[three] = _build(three)
    return _COMPILED[three]


def _build(three: bool) -> Any:
    drift, sort, finish = _drift(), _sort(), _finish()
    mirror, show = _mirror(three), _show(three)
    squeeze, push = _squeeze(three), _push(three)

    def advance(fluid: NumbaFluid, first: bool) -> None:
        numbers, space, shape = fluid.numbers, fluid.space, fluid.shape
        h = np.float32(0.0) if first else numbers[DT]
        drift(fluid.state, fluid.acceleration, h)
        parent, code, cells = mirror(fluid.state, numbers, space, shape, fluid.walls)
        order, starts, rank, place = sort(parent, code, cells, np.prod(shape))
        near = np.zeros((ROWS, order.size + int(LANES)), numbers.dtype)
        show(near, fluid.state, fluid.acceleration, order, parent, code, numbers, space, h, False)
        squeeze(near, order, parent, code, starts, shape, numbers, space, h, fluid.state)
        show(near, fluid.state, fluid.acceleration, order, parent, code, numbers, space, h, True)
        kick = np.empty_like(fluid.acceleration)
        push(near, order, rank, code, starts, shape, numbers, space, kick)
        state, identity = np.empty_like(fluid.state), np.empty_like(fluid.identity)
        finish(fluid.state, fluid.identity, place, kick, space, fluid.walls, state, identity, h)
        fluid.state, fluid.identity, fluid.acceleration = state, identity, kick

    return advance


def _drift() -> Any:
    """Half a kick, and half the way."""

    @jit(fastmath=True, parallel=True)
    def drift(state: Any, acceleration: Any, h: Any) -> None:
        half = h * HALF
        for i in prange(state.shape[1]):
            for axis in range(3):
                state[3 + axis, i] += half * acceleration[axis, i]
                state[axis, i] += half * state[3 + axis, i]

    return drift


def _mirror(three: bool) -> Any:
    """All particles, then their images: whose each is, in which walls (a digit to base 3 per axis), and its cell."""
    axes = 3 if three else 2

    @jit(fastmath=True)
    def walls_near(state: Any, i: int, axis: int, reach: Any, space: Any) -> Any:
        return state[axis, i] - space[LOWER, axis] < reach, space[UPPER, axis] - state[axis, i] < reach

    @jit(fastmath=True)
    def cell_of(state: Any, i: int, code: int, cell: Any, space: Any, shape: Any) -> int:
        index, stride = 0, 1
        for axis in range(axes):
            x, digit = state[axis, i], code % 3
            if digit > 0:
                x = TWO * space[LOWER if digit == 1 else UPPER, axis] - x
            finer = FINER if axis == 0 else 1
            index += stride * min(max(int((x - space[CORNER, axis]) * np.float32(finer) / cell), 0), shape[axis] - 1)
            stride *= shape[axis]
            code //= 3
        return index

    @jit(fastmath=True, parallel=True)
    def find_cells(state: Any, parent: Any, code: Any, cells: Any, cell: Any, space: Any, shape: Any) -> None:
        for i in prange(parent.size):
            cells[i] = cell_of(state, parent[i], code[i], cell, space, shape)

    @jit(fastmath=True)
    def images(state: Any, reach: Any, space: Any, walls: bool) -> Any:
        count = state.shape[1]
        parent, code = np.empty(27 * count, np.int32), np.zeros(27 * count, np.int8)
        size = count
        for i in range(count):
            parent[i] = i
        if walls:
            for i in range(count):
                begin, factor = size, 1
                for axis in range(axes):
                    low, high = walls_near(state, i, axis, reach, space)
                    end = size
                    for digit in range(1, 3):
                        if (low, high)[digit - 1]:
                            parent[size], code[size] = i, digit * factor
                            size += 1
                            for other in range(begin, end):
                                parent[size], code[size] = i, code[other] + digit * factor
                                size += 1
                    factor *= 3
        return parent[:size], code[:size]

    def mirror(state: Any, numbers: Any, space: Any, shape: Any, walls: bool) -> Any:
        parent, code = images(state, numbers[CELL], space, walls)
        cells = np.empty(parent.size, np.int32)
        find_cells(state, parent, code, cells, numbers[CELL], space, shape)
        return parent, code, cells

    return mirror


def _sort() -> Any:
    """By counting: the entries in the order of cells, where each cell starts, and which of the particles each is."""

    @jit(fastmath=True)
    def sort(parent: Any, code: Any, cells: Any, number: int) -> Any:
        starts = np.zeros(number + 2, np.int32)
        for i in range(cells.size):
            starts[cells[i] + 2] += 1
        for cell in range(2, starts.size):
            starts[cell] += starts[cell - 1]
        order = np.empty(cells.size, np.int32)
        for i in range(cells.size):
            order[starts[cells[i] + 1]] = i
            starts[cells[i] + 1] += 1
        rank, place = np.empty(cells.size, np.int32), np.empty(cells.size, np.int32)
        count = 0
        for i in range(order.size):
            if code[order[i]] == 0:
                rank[i] = count
                place[count] = order[i]
                count += 1
        return order, starts, rank, place[:count]

    return sort


def _show(three: bool) -> Any:
    """What the sums read: in the middle of the step, or at its end."""
    axes = 3 if three else 2

    @jit(fastmath=True, parallel=True)
    def show(
        near: Any,
        state: Any,
        acceleration: Any,
        order: Any,
        parent: Any,
        code: Any,
        numbers: Any,
        space: Any,
        h: Any,
        at_end: bool,
    ) -> None:
        rest, sound = numbers[REST], numbers[SOUND]
        for k in prange(order.size):
            i, digits = parent[order[k]], code[order[k]]
            density = state[6, i]
            ratio = density / rest
            cube = ratio * ratio * ratio
            content = rest / SIX * (cube * cube - ONE)
            gravity = rest / (sound * sound)
            if at_end:
                content = sound * sound * rest / SEVEN * (cube * cube * ratio - ONE)
                gravity = rest
            for axis in range(axes):
                x, u, digit = state[axis, i], state[3 + axis, i], digits % 3
                if at_end:
                    x += HALF * h * u
                    u += HALF * h * acceleration[axis, i]
                if digit > 0:
                    image = TWO * space[LOWER if digit == 1 else UPPER, axis] - x
                    content += gravity * space[GRAVITY, axis] * (image - x)
                    x, u = image, -u
                near[axis, k], near[3 + axis, k] = x, u
                digits //= 3
            near[6, k], near[7, k] = numbers[MASS] / density, content

    return show


def _around(three: bool, law: Any) -> Any:
    """The sums of a law over all who may be near a particle, row of cells by row of cells."""
    ends = (-1, 2) if three else (0, 1)
    first, last = ends

    @jit(fastmath=True)
    def around(i: int, near: Any, starts: Any, shape: Any, numbers: Any, space: Any) -> Any:
        cell = numbers[CELL]
        inverse = ONE / cell
        x, y = near[0, i] - space[CORNER, 0], near[1, i] - space[CORNER, 1]
        row = min(max(int(y * inverse), 1), shape[1] - 2)
        y -= np.float32(row) * cell
        layer, z = 0, cell
        if three:
            z = near[2, i] - space[CORNER, 2]
            layer = min(max(int(z * inverse), 1), shape[2] - 2)
            z -= np.float32(layer) * cell
        a, b, c = ZERO, ZERO, ZERO
        for up in range(first, last):
            height = z if up < 0 else (cell - z if up > 0 else ZERO)
            for aside in range(-1, 2):
                width = y if aside < 0 else (cell - y if aside > 0 else ZERO)
                left = cell * cell - height * height - width * width
                if left > ZERO:
                    reach = np.sqrt(left)
                    low = max(int((x - reach) * FINE * inverse), 0)
                    high = min(int((x + reach) * FINE * inverse), shape[0] - 1)
                    base = shape[0] * (row + aside + shape[1] * (layer + up))
                    begin, end = np.uint64(starts[base + low]), np.uint64(starts[base + high + 1])
                    da, db, dc = law(i, begin, end, near, numbers)
                    a += da
                    b += db
                    c += dc
        return a, b, c

    return around


def _squeeze(three: bool) -> Any:
    """Continuity, and diffusion."""

    @jit(fastmath=True)
    def law(i: int, begin: Any, end: Any, near: Any, numbers: Any) -> Any:
        x, y, z, u, v, w = near[0, i], near[1, i], near[2, i], near[3, i], near[4, i], near[5, i]
        inverse, content, fall = ONE / numbers[SUPPORT], near[7, i], numbers[FALL]
        squeeze, diffusion = ZERO, ZERO
        # Whole vectors; what is behind the end weighs nothing.
        for group in range(np.uint64(0), ((end - begin + MORE) >> SHIFT) << SHIFT):
            j = begin + group
            dx, dy = x - near[0, j], y - near[1, j]
            square, approach = dx * dx + dy * dy, (u - near[3, j]) * dx + (v - near[4, j]) * dy
            depth = dy
            if three:
                dz = z - near[2, j]
                square += dz * dz
                approach += (w - near[5, j]) * dz
                depth = dz
            rest = ONE - min(np.sqrt(square) * inverse, ONE)
            weight = (near[6, j] if j < end else ZERO) * (rest * rest * rest)
            squeeze += approach * weight
            diffusion += (near[7, j] - content + fall * depth) * weight
        return squeeze, diffusion, ZERO

    around = _around(three, law)

    @jit(fastmath=True, parallel=True)
    def sweep(
        near: Any,
        order: Any,
        parent: Any,
        code: Any,
        starts: Any,
        shape: Any,
        numbers: Any,
        space: Any,
        h: Any,
        state: Any,
    ) -> None:
        for block in prange((order.size + BLOCK - 1) // BLOCK):
            for k in range(block * BLOCK, min((block + 1) * BLOCK, order.size)):
                if code[order[k]] == 0:
                    squeeze, diffusion, _ = around(k, near, starts, shape, numbers, space)
                    i = parent[order[k]]
                    change = state[6, i] * squeeze - numbers[DIFFUSION] * diffusion
                    state[6, i] += h * numbers[STEEPNESS] * change

    return sweep


def _push(three: bool) -> Any:
    """Pressure and viscosity."""

    @jit(fastmath=True)
    def law(i: int, begin: Any, end: Any, near: Any, numbers: Any) -> Any:
        x, y, z, u, v, w = near[0, i], near[1, i], near[2, i], near[3, i], near[4, i], near[5, i]
        inverse, pressure = ONE / numbers[SUPPORT], near[7, i]
        artificial, laminar, softening = numbers[ARTIFICIAL], numbers[LAMINAR], numbers[SOFTENING]
        fx, fy, fz = ZERO, ZERO, ZERO
        # Whole vectors; what is behind the end weighs nothing.
        for group in range(np.uint64(0), ((end - begin + MORE) >> SHIFT) << SHIFT):
            j = begin + group
            dx, dy, du, dv = x - near[0, j], y - near[1, j], u - near[3, j], v - near[4, j]
            square, approach = dx * dx + dy * dy, du * dx + dv * dy
            dz, dw = ZERO, ZERO
            if three:
                dz, dw = z - near[2, j], w - near[5, j]
                square += dz * dz
                approach += dw * dz
            rest = ONE - min(np.sqrt(square) * inverse, ONE)
            weight = (near[6, j] if j < end else ZERO) * (rest * rest * rest)
            share = ONE / (square + softening)
            along = (artificial * approach * share - (pressure + near[7, j])) * weight
            shear = laminar * square * share * weight
            fx += along * dx + shear * du
            fy += along * dy + shear * dv
            if three:
                fz += along * dz + shear * dw
        return fx, fy, fz

    around = _around(three, law)

    @jit(fastmath=True, parallel=True)
    def sweep(
        near: Any, order: Any, rank: Any, code: Any, starts: Any, shape: Any, numbers: Any, space: Any, kick: Any
    ) -> None:
        for block in prange((order.size + BLOCK - 1) // BLOCK):
            for k in range(block * BLOCK, min((block + 1) * BLOCK, order.size)):
                if code[order[k]] == 0:
                    fx, fy, fz = around(k, near, starts, shape, numbers, space)
                    scale = numbers[STEEPNESS] * near[6, k] / numbers[MASS]
                    kick[0, rank[k]] = scale * fx + space[GRAVITY, 0]
                    kick[1, rank[k]] = scale * fy + space[GRAVITY, 1]
                    kick[2, rank[k]] = scale * fz + space[GRAVITY, 2]

    return sweep


def _finish() -> Any:
    """The other half of the way and of the kick, into the order of this step."""

    @jit(fastmath=True, parallel=True)
    def finish(
        state: Any, identity: Any, place: Any, kick: Any, space: Any, walls: bool, new: Any, new_identity: Any, h: Any
    ) -> None:
        half = HALF * h
        for k in prange(place.size):
            i = place[k]
            for axis in range(3):
                x, u = state[axis, i] + half * state[3 + axis, i], state[3 + axis, i] + half * kick[axis, k]
                beyond = max(space[LOWER, axis] - x, ZERO) + min(space[UPPER, axis] - x, ZERO)
                if walls and beyond != ZERO:
                    x, u = x + TWO * beyond, -u
                new[axis, k], new[3 + axis, k] = x, u
            new[6, k] = state[6, i]
            new_identity[k] = identity[i]

    return finish
