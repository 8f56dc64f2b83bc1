"""Regular lattices of particles, and the springs and faces between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from physcore.checks import BoolArray, FloatArray, IntArray
from physcore.scene.bodies import SpringNetwork

Offset: TypeAlias = tuple[int, ...]


@dataclass(frozen=True)
class LatticeSprings:
    """Kind of springs in a lattice: connects every particle with those at the given offsets."""

    offsets: tuple[Offset, ...]
    rest_length: float
    stiffness: float
    damping: float
    halved: bool = False
    """Whether springs along a border of a sheet carry half the width of the others, and have half their stiffness."""


def lattice(
    shape: tuple[int, ...],
    positions: FloatArray,
    kinds: Sequence[LatticeSprings],
    *,
    faces: IntArray | None = None,
    mass: ArrayLike,
    fixed: BoolArray,
    velocities: ArrayLike,
    radius: ArrayLike,
    name: str | None,
    breaking_strain: float,
    strain_limit: float,
) -> SpringNetwork:
    """A network of the particles of a lattice, with every kind of spring that has stiffness or damping."""
    present = [kind for kind in kinds if kind.stiffness > 0 or kind.damping > 0]
    links = [np.concatenate([lattice_links(shape, offset) for offset in kind.offsets]) for kind in present]
    sizes = [len(pairs) for pairs in links]
    stiffness = np.repeat([kind.stiffness for kind in present], sizes)
    for kind, part in zip(present, np.split(stiffness, np.cumsum(sizes)[:-1]), strict=False):
        if kind.halved:
            part *= lattice_shares(shape, kind.offsets[0])
    return SpringNetwork(
        positions,
        np.concatenate([np.empty((0, 2), dtype=np.int64), *links]),
        stiffness=stiffness,
        damping=np.repeat([kind.damping for kind in present], sizes),
        rest_length=np.repeat([kind.rest_length for kind in present], sizes),
        mass=mass,
        fixed=fixed,
        velocities=velocities,
        radius=radius,
        name=name,
        faces=faces,
        breaking_strain=breaking_strain,
        strain_limit=strain_limit,
    )


def lattice_faces(grid: IntArray) -> IntArray:
    """Two counterclockwise triangles (T, 3) for each cell of a grid of particles (rows, columns).

    The diagonals of neighboring cells alternate, so that the surface bends alike along both diagonals.
    """
    first, second, third, fourth = (
        part.ravel() for part in (grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1])
    )
    even = (np.indices((len(grid) - 1, len(grid[0]) - 1)).sum(axis=0) % 2 == 0).ravel()
    one = np.where(even[:, None], np.stack([first, second, third], axis=1), np.stack([first, second, fourth], axis=1))
    other = np.where(even[:, None], np.stack([first, third, fourth], axis=1), np.stack([second, third, fourth], axis=1))
    return np.concatenate([one, other])


def lattice_links(shape: tuple[int, ...], offset: Offset) -> IntArray:
    """Index pairs (M, 2) of all lattice particles with a neighbor at `offset`, row by row."""
    grid = np.arange(math.prod(shape), dtype=np.int64).reshape(shape[::-1])
    first = tuple(slice(max(0, -o), size - max(0, o)) for o, size in zip(offset, shape, strict=True))
    second = tuple(slice(max(0, o), size + min(0, o)) for o, size in zip(offset, shape, strict=True))
    return np.stack([grid[first[::-1]].ravel(), grid[second[::-1]].ravel()], axis=1)


def lattice_shares(shape: tuple[int, ...], offset: Offset) -> FloatArray:
    """The width that every spring of `lattice_links` carries, in spacings: ½ along a border. Without an offset, the
    area of every particle.
    """
    shares = np.ones((1,))
    for size, step in zip(shape[::-1], offset[::-1], strict=True):
        along = np.ones(size - abs(step))
        if step == 0:
            along[[0, -1]] = 0.5
        shares = np.outer(shares, along).ravel()
    return shares


def lattice_points(shape: tuple[int, ...], spacing: float) -> FloatArray:
    """Lattice coordinates (N, len(shape)) [m], the first axis fastest."""
    indices = np.indices(shape[::-1], dtype=np.float64).reshape(len(shape), -1)[::-1].T
    return np.ascontiguousarray(indices * spacing)
