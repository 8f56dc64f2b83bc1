"""Rigid bodies to pile up: the scene for every engine, and the measures of what an engine made of it.

Penetrations and energies are computed here, from positions, orientations and velocities, for all engines alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
GRAVITY = 9.81
FRICTION = 0.5
"""Coefficient of every contact."""


@dataclass(frozen=True)
class State:
    """Positions (B, D), angles (B,) or quaternions (B, 4) in the order w, x, y, z, and both velocities."""

    positions: Array
    turns: Array
    velocities: Array
    spins: Array


@dataclass(frozen=True)
class Pile:
    """Discs, rectangles or cuboids on the ground, at rest at first.

    The ground is at height zero, along y in 2D and along z in 3D. With `width` there are walls at x = 0 and x = width.
    """

    positions: Array
    """Positions of the centers [m], shape (B, D)."""
    sizes: Array
    """Radii of discs, shape (B, 1), or half the lengths of the sides, shape (B, D) [m]."""
    turns: Array
    """Angles in 2D, shape (B,), or quaternions (w, x, y, z) in 3D, shape (B, 4)."""
    density: float = 1.0
    width: float | None = None

    def scaled(self, scale: float) -> Pile:
        """In another unit of length."""
        width = None if self.width is None else scale * self.width
        return Pile(scale * self.positions, scale * self.sizes, self.turns, self.density, width)

    @property
    def dimension(self) -> int:
        """Of space."""
        return self.positions.shape[1]

    @property
    def round(self) -> bool:
        """Whether the bodies are discs."""
        return self.sizes.shape[1] == 1

    @cached_property
    def mass(self) -> Array:
        """Masses [kg], in 2D per meter of depth."""
        sizes = np.pi * self.sizes[:, 0] ** 2 if self.round else (2.0 * self.sizes).prod(axis=1)
        return self.density * sizes

    @cached_property
    def moments(self) -> Array:
        """Moments of inertia: about z in 2D, shape (B, 1); about the axes of the cuboid in 3D, shape (B, 3)."""
        squares = self.sizes**2
        if self.round:
            return self.mass[:, None] * squares / 2.0
        about = squares.sum(axis=1, keepdims=True)
        return self.mass[:, None] * (about if self.dimension == 2 else about - squares) / 3.0

    def energy(self, state: State) -> float:
        """Kinetic and potential energy [J]."""
        return self.kinetic(state) + GRAVITY * float(self.mass @ state.positions[:, -1])

    def kinetic(self, state: State) -> float:
        """Kinetic energy [J]."""
        spins = state.spins.reshape(len(self.mass), -1)
        if self.dimension == 3:
            spins = np.einsum("bij,bi->bj", rotations(state.turns), spins)
        return 0.5 * float(self.mass @ (state.velocities**2).sum(axis=1) + (self.moments * spins**2).sum())

    def height(self) -> float:
        """Potential energy at the start [J], of which energies are fractions."""
        return GRAVITY * float(self.mass @ self.positions[:, -1])

    def penetration(self, state: State) -> float:
        """The largest depth [m] by which bodies overlap one another, the ground or a wall."""
        axes = None if self.round else rotations(state.turns)
        reach = self.sizes if axes is None else np.einsum("bij,bj->bi", np.abs(axes), self.boxes)
        up = self.dimension - 1
        depths = [reach[:, up if reach.shape[1] > 1 else 0] - state.positions[:, up]]
        if self.width is not None:
            depths += [reach[:, 0] - state.positions[:, 0], reach[:, 0] + state.positions[:, 0] - self.width]
        radii = np.linalg.norm(self.sizes, axis=1)
        pairs = cKDTree(state.positions).query_pairs(2.0 * radii.max(), output_type="ndarray")
        i, j = pairs.T
        apart = state.positions[j] - state.positions[i]
        if axes is None:
            depths.append(self.sizes[i, 0] + self.sizes[j, 0] - np.linalg.norm(apart, axis=1))
        else:
            flat = np.zeros((len(apart), 3 - self.dimension))
            depths.append(overlaps(np.hstack([apart, flat]), axes[i], axes[j], self.boxes[i], self.boxes[j]))
        return max(float(each.max(initial=0.0)) for each in depths)

    @cached_property
    def boxes(self) -> Array:
        """Half the sides in 3D, in which a rectangle is as deep as it is wide."""
        return self.sizes if self.dimension == 3 else np.column_stack([self.sizes, self.sizes.max(axis=1)])


def rotations(turns: Array) -> Array:
    """Rotation matrices of angles or quaternions, shape (B, 3, 3)."""
    if turns.ndim == 1:
        turns = np.column_stack([np.cos(turns / 2.0), 0.0 * turns, 0.0 * turns, np.sin(turns / 2.0)])
    w, x, y, z = (turns / np.linalg.norm(turns, axis=1, keepdims=True)).T
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def overlaps(apart: Array, one: Array, other: Array, half: Array, others: Array) -> Array:
    """By how much pairs of boxes overlap along the axis along which they do least, or are apart if negative.

    Source: S. Gottschalk, M. C. Lin and D. Manocha, OBBTree, SIGGRAPH (1996): 15 axes separate two boxes.
    """
    crossed = np.cross(one[:, :, :, None], other[:, :, None, :], axis=1).reshape(len(apart), 3, 9)
    axes = np.concatenate([one, other, crossed], axis=2)
    length = np.linalg.norm(axes, axis=1)
    reach = sum(
        np.einsum("pk,pka->pa", each, np.abs(np.einsum("pik,pia->pka", turned, axes)))
        for turned, each in ((one, half), (other, others))
    )
    along = np.abs(np.einsum("pi,pia->pa", apart, axes))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(length > 1e-6, (reach - along) / length, np.inf).min(axis=1)


def grid(counts: tuple[int, ...], spacing: float) -> Array:
    """Points of a grid, those of the lowest row first, shape (N, D)."""
    axes = np.meshgrid(*(np.arange(count) for count in reversed(counts)), indexing="ij")
    return spacing * np.column_stack([axis.ravel() for axis in reversed(axes)]).astype(float)


def discs_in_a_box(count: int) -> Pile:
    """Discs of two sizes that fall into a box."""
    side = int(np.sqrt(count))
    rows = -(-count // side)
    places = grid((side, rows), 1.1)[:count] + np.random.default_rng(0).uniform(0.0, 0.05, (count, 2)) + 1.0
    radii = np.where(np.arange(count) % 2, 0.5, 0.4)[:, None]
    return Pile(places, radii, np.zeros(count), width=1.1 * side + 2.0)


def pyramid(rows: int, at: float = 0.0, side: float = 1.0) -> Pile:
    """Squares in rows, each with one less than the row below, that touch one another."""
    places = [(at + k - 0.5 * (rows - row - 1), row + 0.5) for row in range(rows) for k in range(rows - row)]
    count = len(places)
    return Pile(side * np.array(places), np.full((count, 2), 0.5 * side), np.zeros(count))


def heap(counts: tuple[int, int, int], at: tuple[float, float] = (0.0, 0.0), seed: int = 1) -> Pile:
    """Cuboids in any orientation that fall onto the ground."""
    half = np.array([0.5, 0.4, 0.3])
    places = grid(counts, 1.5) + np.array([*at, 1.0])
    generator = np.random.default_rng(seed)
    turns = generator.normal(size=(len(places), 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    return Pile(places, np.tile(half, (len(places), 1)), turns)


def together(piles: list[Pile]) -> Pile:
    """Several piles in one scene."""
    parts: dict[str, Any] = {
        name: np.concatenate([getattr(pile, name) for pile in piles]) for name in ("positions", "sizes", "turns")
    }
    return Pile(**parts)
