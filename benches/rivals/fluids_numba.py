"""A weakly compressible fluid in a box, by the equations and the steps of physcore: Numba.

Lists of neighbors serve until somebody has moved by half of their skin. Then the particles are sorted by cells, by
counting, and with them their images behind the walls, which follow them until the next time. The sums run over the
lists, and read one record of each neighbor.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from math import ceil, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physcore as pc
from rivals.jit import jit, prange

Array = NDArray[Any]

BLOCK = 512
"""Particles that a thread takes at a time."""
FINER = 4
"""Cells in the length of a row's width, along x."""
SKIN = 0.3
"""How much further than the support lists reach, in spacings."""
MOST = 128
"""The longest list."""

STATE, ROWS = 7, 8
"""Rows of the state: x, y, z, u, v, w and density; the sums read volume and pressure, or enthalpy, in its place."""

DT, SUPPORT, STEEPNESS, MASS, REST, SOUND, ARTIFICIAL, LAMINAR, DIFFUSION, SOFTENING, CELL, FALL, SLACK = range(13)
LOWER, UPPER, GRAVITY, CORNER = range(4)
ZERO, HALF, ONE, TWO, SIX, SEVEN, FINE = (np.float32(number) for number in (0, 0.5, 1, 2, 6, 7, FINER))


@dataclass(frozen=True)
class Tank:
    """A fluid in a box."""

    fluid: pc.Fluid
    method: pc.WeaklyCompressible
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
        fluid, method = tank.fluid, tank.method
        self.dimension = fluid.dimension
        self.state = np.zeros((STATE, len(fluid)), dtype)
        self.state[: self.dimension] = fluid.positions.T
        self.state[3 : 3 + self.dimension] = fluid.velocities.T
        self.state[6] = tank.density
        self.identity = np.arange(len(fluid), dtype=np.int32)
        self.acceleration = np.zeros((3, len(fluid)), dtype)

        length = method.kernel.smoothing * fluid.spacing
        support = 2.0 * length
        slope = -5.0 * _height(self.dimension) / length ** (self.dimension + 2) / _moment(method.kernel, self.dimension)
        down = np.zeros(3)
        down[self.dimension - 1] = -tank.gravity
        c, rest = tank.sound_speed, fluid.density
        cell = support + SKIN * fluid.spacing
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
            float(method.artificial_viscosity) * length * c * rest,
            2.0 * fluid.viscosity,
            2.0 * method.density_diffusion * length * c,
            0.01 * length**2,
            cell,
            -rest * tank.gravity / c**2,
            (0.5 * SKIN * fluid.spacing) ** 2,
        )
        self.numbers = np.array(numbers, dtype)
        self.space = np.array([lower, upper, down, corner], dtype)
        self.walls = tank.walls
        self.anchors = np.full((3, len(fluid)), np.inf, dtype)
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


def _moment(kernel: pc.Kernel, dimension: int) -> float:
    """What the gradient of a linear field comes out as on a lattice: physcore divides by it."""
    spacing = 1.0 / kernel.smoothing
    points = spacing * np.array(list(product(range(-4, 5), repeat=dimension)))
    distance = np.minimum(np.linalg.norm(points, axis=1), 2.0)
    slope = -5.0 * _height(dimension) * (1.0 - 0.5 * distance) ** 3
    return float(-(slope * points[:, 0] ** 2).sum() * spacing**dimension)


_COMPILED: dict[bool, Any] = {}


def _compile(three: bool) -> Any:
    """The whole step in two or three dimensions, compiled once."""
    if three not in _COMPILED:
        _COMPILED[three] = _build(three)
    return _COMPILED[three]


def _build(three: bool) -> Any:
    mirror, sort, find = _mirror(three), _sort(), _find(three)
    drift, has_moved, finish = _drift(), _has_moved(), _finish()
    show, squeeze, push = _show(three), _squeeze(three), _push(three)

    def look(fluid: Any) -> None:
        """Make the lists anew if they have served."""
        numbers, space, shape = fluid.numbers, fluid.space, fluid.shape
        if not has_moved(fluid.state, fluid.anchors, numbers[SLACK]):
            return
        parent, code, cells = mirror(fluid.state, numbers, space, shape, fluid.walls)
        order, starts, place = sort(parent, code, cells, np.prod(shape))
        fluid.state, fluid.acceleration = (np.take(rows, place, axis=1) for rows in (fluid.state, fluid.acceleration))
        fluid.identity, fluid.anchors = fluid.identity[place], fluid.state[:3].copy()
        at = np.empty(len(place), np.int32)
        at[place] = np.arange(len(place), dtype=np.int32)
        fluid.parent, fluid.code = at[parent[order]], code[order]
        fluid.itself = np.flatnonzero(fluid.code == 0).astype(np.int32)
        spots = np.zeros((3, len(order)), np.float32)
        fluid.near = np.empty((len(order), ROWS), np.float32)
        show(fluid.near, fluid.state, fluid.parent, fluid.code, numbers, space, False)
        spots[:] = fluid.near[:, :3].T
        fluid.lists, fluid.lengths = np.empty((len(place), MOST), np.uint32), np.empty(len(place), np.uint32)
        find(spots, fluid.itself, starts, shape, numbers, space, fluid.lists, fluid.lengths)
        if fluid.lengths.max() >= MOST:
            raise ValueError("a list is too short")

    def advance(fluid: Any, first: bool) -> None:
        numbers, space = fluid.numbers, fluid.space
        h = np.float32(0.0) if first else numbers[DT]
        drift(fluid.state, fluid.acceleration, h, space, False, False)
        look(fluid)
        show(fluid.near, fluid.state, fluid.parent, fluid.code, numbers, space, False)
        squeeze(fluid.near, fluid.itself, fluid.lists, fluid.lengths, numbers, h, fluid.state)
        drift(fluid.state, fluid.acceleration, h, space, True, fluid.walls)
        look(fluid)
        show(fluid.near, fluid.state, fluid.parent, fluid.code, numbers, space, True)
        kick = np.empty_like(fluid.acceleration)
        push(fluid.near, fluid.itself, fluid.lists, fluid.lengths, numbers, space, kick)
        finish(fluid.state, fluid.acceleration, kick, h)

    return advance


def _has_moved() -> Any:
    """Whether anybody has moved too far."""

    @jit(fastmath=False, parallel=True)
    def has_moved(state: Any, anchors: Any, limit: Any) -> bool:
        far = 0
        for i in prange(state.shape[1]):
            x, y, z = state[0, i] - anchors[0, i], state[1, i] - anchors[1, i], state[2, i] - anchors[2, i]
            far += x * x + y * y + z * z > limit
        return far > 0

    return has_moved


def _drift() -> Any:
    """Half a kick and half the way; at the end of a step the way comes first, and walls throw back."""

    @jit(fastmath=True, parallel=True)
    def drift(state: Any, acceleration: Any, h: Any, space: Any, at_end: bool, walls: bool) -> None:
        half = h * HALF
        for i in prange(state.shape[1]):
            for axis in range(3):
                x, u, kick = state[axis, i], state[3 + axis, i], half * acceleration[axis, i]
                if at_end:
                    x += half * u
                    beyond = max(space[LOWER, axis] - x, ZERO) + min(space[UPPER, axis] - x, ZERO)
                    if walls and beyond != ZERO:
                        x, u = x + TWO * beyond, -u
                    u += kick
                else:
                    u += kick
                    x += half * u
                state[axis, i], state[3 + axis, i] = x, u

    return drift


def _finish() -> Any:
    """The other half of the kick, in place of the predicted one."""

    @jit(fastmath=True, parallel=True)
    def finish(state: Any, acceleration: Any, kick: Any, h: Any) -> None:
        for i in prange(state.shape[1]):
            for axis in range(3):
                state[3 + axis, i] += HALF * h * (kick[axis, i] - acceleration[axis, i])
                acceleration[axis, i] = kick[axis, i]

    return finish


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
    """By counting: the entries in the order of cells, where each cell starts, and the particles among them."""

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
        place = np.empty(cells.size, np.int32)
        count = 0
        for i in range(order.size):
            if code[order[i]] == 0:
                place[count] = order[i]
                count += 1
        return order, starts, place[:count]

    return sort


def _show(three: bool) -> Any:
    """What the sums read, of particles and images: in the middle of a step, or at its end."""
    axes = 3 if three else 2

    @jit(fastmath=True)
    def show_one(k: int, near: Any, state: Any, parent: Any, code: Any, numbers: Any, space: Any, at_end: bool) -> None:
        rest, sound = numbers[REST], numbers[SOUND]
        i, digits = parent[k], code[k]
        density = state[6, i]
        ratio = density / rest
        cube = ratio * ratio * ratio
        content = rest / SIX * (cube * cube - ONE)
        gravity = rest / (sound * sound)
        if at_end:
            content = sound * sound * rest / SEVEN * (cube * cube * ratio - ONE)
            gravity = rest
        near[k, 2], near[k, 5] = ZERO, ZERO
        for axis in range(axes):
            x, u, digit = state[axis, i], state[3 + axis, i], digits % 3
            if digit > 0:
                image = TWO * space[LOWER if digit == 1 else UPPER, axis] - x
                content += gravity * space[GRAVITY, axis] * (image - x)
                x, u = image, -u
            near[k, axis], near[k, 3 + axis] = x, u
            digits //= 3
        near[k, 6], near[k, 7] = numbers[MASS] / density, content

    @jit(fastmath=True, parallel=True)
    def show(near: Any, state: Any, parent: Any, code: Any, numbers: Any, space: Any, at_end: bool) -> None:
        for k in prange(parent.size):
            show_one(k, near, state, parent, code, numbers, space, at_end)

    return show


def _find(three: bool) -> Any:
    """The lists: all who are near a particle, row of cells by row of cells."""
    first, last = (-1, 2) if three else (0, 1)

    @jit(fastmath=True)
    def neighbors(i: int, spots: Any, starts: Any, shape: Any, numbers: Any, space: Any, found: Any) -> int:
        cell = numbers[CELL]
        inverse = ONE / cell
        x, y = spots[0, i] - space[CORNER, 0], spots[1, i] - space[CORNER, 1]
        row = min(max(int(y * inverse), 1), shape[1] - 2)
        y -= np.float32(row) * cell
        layer, z = 0, cell
        if three:
            z = spots[2, i] - space[CORNER, 2]
            layer = min(max(int(z * inverse), 1), shape[2] - 2)
            z -= np.float32(layer) * cell
        count, most = np.uint64(0), np.uint64(found.size - 1)
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
                    for j in range(np.uint64(starts[base + low]), np.uint64(starts[base + high + 1])):
                        dx, dy, dz = spots[0, i] - spots[0, j], spots[1, i] - spots[1, j], spots[2, i] - spots[2, j]
                        # Without a branch: the next one overwrites who is too far away.
                        found[count] = j
                        near = dx * dx + dy * dy + dz * dz < cell * cell
                        count = min(count + np.uint64(near), most)
        return count

    @jit(fastmath=True, parallel=True)
    def find(
        spots: Any, itself: Any, starts: Any, shape: Any, numbers: Any, space: Any, lists: Any, lengths: Any
    ) -> None:
        for block in prange((itself.size + BLOCK - 1) // BLOCK):
            for i in range(block * BLOCK, min((block + 1) * BLOCK, itself.size)):
                lengths[i] = neighbors(itself[i], spots, starts, shape, numbers, space, lists[i])

    return find


def _squeeze(three: bool) -> Any:
    """Continuity, and diffusion."""

    @jit(fastmath=True)
    def law(i: int, found: Any, near: Any, numbers: Any) -> Any:
        x, y, z, u, v, w = near[i, 0], near[i, 1], near[i, 2], near[i, 3], near[i, 4], near[i, 5]
        inverse, content, fall = ONE / numbers[SUPPORT], near[i, 7], numbers[FALL]
        squeeze, diffusion = ZERO, ZERO
        for n in range(found.size):
            j = np.uint64(found[n])
            dx, dy = x - near[j, 0], y - near[j, 1]
            square, approach = dx * dx + dy * dy, (u - near[j, 3]) * dx + (v - near[j, 4]) * dy
            depth = dy
            if three:
                dz = z - near[j, 2]
                square += dz * dz
                approach += (w - near[j, 5]) * dz
                depth = dz
            rest = ONE - min(np.sqrt(square) * inverse, ONE)
            weight = near[j, 6] * (rest * rest * rest)
            squeeze += approach * weight
            diffusion += (near[j, 7] - content + fall * depth) * weight
        return squeeze, diffusion

    @jit(fastmath=True, parallel=True)
    def sweep(near: Any, itself: Any, lists: Any, lengths: Any, numbers: Any, h: Any, state: Any) -> None:
        for block in prange((itself.size + BLOCK - 1) // BLOCK):
            for i in range(block * BLOCK, min((block + 1) * BLOCK, itself.size)):
                squeeze, diffusion = law(itself[i], lists[i, : lengths[i]], near, numbers)
                change = state[6, i] * squeeze - numbers[DIFFUSION] * diffusion
                state[6, i] += h * numbers[STEEPNESS] * change

    return sweep


def _push(three: bool) -> Any:
    """Pressure and viscosity."""

    @jit(fastmath=True)
    def law(i: int, found: Any, near: Any, numbers: Any) -> Any:
        x, y, z, u, v, w = near[i, 0], near[i, 1], near[i, 2], near[i, 3], near[i, 4], near[i, 5]
        inverse, pressure = ONE / numbers[SUPPORT], near[i, 7]
        artificial, laminar, softening = numbers[ARTIFICIAL], numbers[LAMINAR], numbers[SOFTENING]
        fx, fy, fz = ZERO, ZERO, ZERO
        for n in range(found.size):
            j = np.uint64(found[n])
            dx, dy, du, dv = x - near[j, 0], y - near[j, 1], u - near[j, 3], v - near[j, 4]
            square, approach = dx * dx + dy * dy, du * dx + dv * dy
            dz, dw = ZERO, ZERO
            if three:
                dz, dw = z - near[j, 2], w - near[j, 5]
                square += dz * dz
                approach += dw * dz
            rest = ONE - min(np.sqrt(square) * inverse, ONE)
            weight = near[j, 6] * (rest * rest * rest)
            share = ONE / (square + softening)
            along = (artificial * approach * share - (pressure + near[j, 7])) * weight
            shear = laminar * square * share * weight
            fx += along * dx + shear * du
            fy += along * dy + shear * dv
            if three:
                fz += along * dz + shear * dw
        return fx, fy, fz

    @jit(fastmath=True, parallel=True)
    def sweep(near: Any, itself: Any, lists: Any, lengths: Any, numbers: Any, space: Any, kick: Any) -> None:
        for block in prange((itself.size + BLOCK - 1) // BLOCK):
            for i in range(block * BLOCK, min((block + 1) * BLOCK, itself.size)):
                fx, fy, fz = law(itself[i], lists[i, : lengths[i]], near, numbers)
                scale = numbers[STEEPNESS] * near[itself[i], 6] / numbers[MASS]
                kick[0, i] = scale * fx + space[GRAVITY, 0]
                kick[1, i] = scale * fy + space[GRAVITY, 1]
                kick[2, i] = scale * fz + space[GRAVITY, 2]

    return sweep
