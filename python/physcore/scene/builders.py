"""Builders of common spring networks: a rope, a cloth and a soft body.

All are regular lattices. Springs are ordered by kind and row, and each kind has one stiffness, one damping and one
exact rest length. The engine detects this regularity and evaluates the springs as a stencil.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from types import NoneType
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from physcore import memory
from physcore.arithmetic import combined, lengths
from physcore.checks import (
    LONGEST,
    SHORTEST,
    BoolArray,
    FloatArray,
    IntArray,
    Vector,
    count,
    items,
    mask,
    number,
    shown,
    span,
    vector,
)
from physcore.entrance import entrance
from physcore.errors import SceneError
from physcore.scene.bodies import SpringNetwork
from physcore.scene.lattices import LatticeSprings, lattice, lattice_faces, lattice_points, lattice_shares
from physcore.scene.materials import Material
from physcore.spelling import did_you_mean

Pinned: TypeAlias = str | tuple[str, ...] | ArrayLike | None

ROPE_BYTES, CLOTH_BYTES, SOFT_BODY_BYTES = 225, 900, 1130
"""Peak memory per particle with its springs while a network is built [bytes]."""


@entrance
def rope(
    particles: int,
    length: float,
    stiffness: float,
    damping: float = 0.0,
    mass: ArrayLike = 1.0,
    start: Vector | None = None,
    direction: Vector | None = None,
    pinned: Pinned = None,
    *,
    fixed: Pinned = None,
    velocities: ArrayLike = 0.0,
    radius: ArrayLike = 0.0,
    name: str | None = None,
    breaking_strain: float = math.inf,
    strain_limit: float = math.inf,
) -> SpringNetwork:
    """Rope: a straight chain of particles, each connected with the next by a spring.

        rope = pc.rope(20, length=1.0, stiffness=500.0, damping=0.05, mass=0.01, pinned="start")

    Args:
        particles: number of particles, at least 2; there are particles − 1 springs.
        length: distance from the first to the last particle [m]; every spring is at rest.
        stiffness: stiffness of each spring [N/m]; a rope of n springs is n times softer.
        damping: damping along each spring [N·s/m].
        mass: mass per particle [kg], one or (particles,).
        start: position of the first particle [m]; the origin by default. Three numbers give a rope in 3D.
        direction: direction of the rope, a vector of any length; +x by default.
        pinned: the fixed particles: "start", "end", "both", a bool mask, or integer indices.
        fixed: synonym of `pinned`, as in Particles; the particles of both are fixed.
        velocities, radius, name: as in Particles.
        breaking_strain, strain_limit: values of each spring, as in SpringNetwork.

    Raises:
        SceneError: a parameter is out of range or of the wrong shape.
    """
    nodes = count(particles, "rope.particles", least=2)
    memory.require(float(ROPE_BYTES * nodes), f"{nodes} particles", "rope.particles")
    whole = span(length, "rope.length")
    spacing = whole / (nodes - 1)
    origin, (axis,) = _frame(start, None if direction is None else [direction], 1, "rope.start", "rope.direction")
    along = whole * np.arange(nodes) / (nodes - 1)
    edges = {"start": np.array([0]), "end": np.array([nodes - 1]), "both": np.array([0, nodes - 1])}
    kind = LatticeSprings(((1,),), spacing, *_strength(stiffness, damping, "rope."))
    return lattice(
        (nodes,),
        origin + along[:, None] * axis,
        [kind],
        mass=mass,
        fixed=_pins(pinned, edges, nodes, "rope.pinned") | _pins(fixed, edges, nodes, "rope.fixed"),
        velocities=velocities,
        radius=radius,
        name=name,
        breaking_strain=breaking_strain,
        strain_limit=strain_limit,
    )


@entrance
def cloth(
    shape: tuple[int, int],
    spacing: float,
    stiffness: float | None = None,
    damping: float = 0.0,
    mass: ArrayLike | None = None,
    origin: Vector | None = None,
    axes: tuple[Vector, Vector] | None = None,
    shear_stiffness: float | None = None,
    bend_stiffness: float | None = None,
    pinned: Pinned = None,
    *,
    fixed: Pinned = None,
    shear_damping: float | None = None,
    bend_damping: float | None = None,
    material: Material | None = None,
    velocities: ArrayLike = 0.0,
    radius: ArrayLike = 0.0,
    name: str | None = None,
    breaking_strain: float = math.inf,
    strain_limit: float = math.inf,
) -> SpringNetwork:
    """Cloth: a rectangle of structural, shear and bend springs (Provot 1995), at rest.

    Structural springs connect neighbors in a row and in a column. Shear springs are the diagonals of each cell, and
    bend springs connect every second particle of a row and of a column. Particles are ordered row by row from the lower
    left.

        flag = pc.cloth((40, 30), 0.025, 400.0, damping=0.02, mass=0.002, pinned="left")
        scarf = pc.cloth((40, 30), 0.025, damping=0.02, origin=(0.0, 0.0, 0.0), material=pc.materials.silk)

    With a `material`, the springs reproduce the sheet at any spacing a, for small strains. A shear γ changes the length
    of both diagonals of a cell by a γ/√2, with the energy ½ k γ² a² together. Hence k is the shear stiffness of the
    material. At a strain ε along a row and constant width, the diagonals have the energy ½ k ε² a². The springs of a
    row, which carries the width a, therefore have the material's stiffness along the warp, minus k. At the border a row
    carries a/2, and has half of this. Columns have the stiffness along the weft, likewise. Poisson's ratio follows as k
    over the stiffness along warp or weft. There are no bend springs; use `Dihedral(cloth, material.bending)` for the
    resistance to bending. A particle has the mass of the area a², half of it at the border and a quarter at a corner.

    Args:
        shape: (columns, rows), each at least 2.
        spacing: distance between neighbors [m].
        stiffness: stiffness of each structural spring [N/m]; None: from the material.
        damping: damping along each structural spring [N·s/m].
        mass: mass per particle [kg], one or (columns · rows,); None: from the material, or 1.
        origin: position of the lower left particle [m]; zero by default. Three numbers give a cloth in 3D.
        axes: directions of a row and of a column, perpendicular; +x and +y by default.
        shear_stiffness, bend_stiffness: stiffness of each shear and bend spring [N/m]; None: from the material, or as
            `stiffness`. 0 omits these springs, unless their damping is given.
        pinned: the fixed particles: "top", "bottom", "left", "right", "corners", "top corners", "bottom corners", a
            tuple
            of these, a bool mask, or integer indices.
        fixed: synonym of `pinned`, as in Particles; the particles of both are fixed.
        shear_damping, bend_damping: damping along each shear and bend spring [N·s/m]; None: as `damping`.
        material: one of `physcore.materials`, or another Material; other arguments take precedence over its values.
        velocities, radius, name: as in Particles.
        breaking_strain, strain_limit: values of each spring, as in SpringNetwork.

    Raises:
        SceneError: a parameter is out of range or of the wrong shape, there is neither a stiffness nor a material, or
            the shear stiffness is above the material's stiffness along warp or weft.

    Source: X. Provot, "Deformation constraints in a mass-spring model to describe rigid cloth behavior", Graphics
    Interface 1995.
    """
    columns, rows = _shape(shape, (2,), "cloth.shape", CLOTH_BYTES)
    step = span(spacing, "cloth.spacing")
    corner, directions = _frame(origin, axes, 2, "cloth.origin", "cloth.axes")
    if not isinstance(material, (Material, NoneType)):
        raise SceneError(f"cloth.material: must be one of physcore.materials, or a Material, got {shown(material)}")
    if stiffness is None and material is None:
        raise SceneError("cloth.stiffness: must be a number where there is no material=, got None")
    if material is not None and shear_stiffness is None:
        shear_stiffness = material.shear
    if material is not None and bend_stiffness is None:
        bend_stiffness = 0.0
    structural = _strength(0.0 if stiffness is None else stiffness, damping, "cloth.")
    shear = _strength(shear_stiffness, shear_damping, "cloth.shear_", structural)
    bend = _strength(bend_stiffness, bend_damping, "cloth.bend_", structural)
    if material is None or stiffness is not None:
        along = [LatticeSprings(((1, 0), (0, 1)), step, *structural)]
    else:
        along = [
            LatticeSprings((offset,), step, _along_threads(whole, shear[0], thread), structural[1], halved=True)
            for offset, whole, thread in (((1, 0), material.warp, "warp"), ((0, 1), material.weft, "weft"))
        ]
    kinds = [
        *along,
        LatticeSprings(((1, 1), (-1, 1)), step * math.sqrt(2.0), *shear),
        LatticeSprings(((2, 0), (0, 2)), 2.0 * step, *bend),
    ]
    if mass is None:
        mass = (
            1.0 if material is None else material.areal_density * step * step * lattice_shares((columns, rows), (0, 0))
        )
    grid = np.arange(columns * rows).reshape(rows, columns)
    edges = {
        "bottom": grid[0],
        "top": grid[-1],
        "left": grid[:, 0],
        "right": grid[:, -1],
        "corners": grid[[0, 0, -1, -1], [0, -1, 0, -1]],
        "top corners": grid[-1, [0, -1]],
        "bottom corners": grid[0, [0, -1]],
    }
    return lattice(
        (columns, rows),
        corner + combined(lattice_points((columns, rows), step), directions),
        kinds,
        faces=lattice_faces(grid),
        mass=mass,
        fixed=_pins(pinned, edges, columns * rows, "cloth.pinned") | _pins(fixed, edges, columns * rows, "cloth.fixed"),
        velocities=velocities,
        radius=radius,
        name=name,
        breaking_strain=breaking_strain,
        strain_limit=strain_limit,
    )


@entrance
def soft_body(
    shape: tuple[int, int] | tuple[int, int, int],
    spacing: float,
    stiffness: float,
    damping: float = 0.0,
    mass: ArrayLike = 1.0,
    origin: Vector | None = None,
    shear_stiffness: float | None = None,
    pinned: Pinned = None,
    *,
    fixed: Pinned = None,
    shear_damping: float | None = None,
    velocities: ArrayLike = 0.0,
    radius: ArrayLike = 0.0,
    name: str | None = None,
    breaking_strain: float = math.inf,
    strain_limit: float = math.inf,
) -> SpringNetwork:
    """Soft body: a rectangular lattice with springs along its axes and along the diagonals of its faces, at rest.

        jelly = pc.soft_body((8, 6), spacing=0.1, stiffness=200.0, damping=0.2, mass=0.05, origin=(0.0, 1.0))
        scene = pc.Scene(jelly, pc.Gravity(), pc.Floor())

    Particles are ordered along x first, then along y, then along z.

    Args:
        shape: (columns, rows) in 2D, (columns, rows, layers) in 3D; each at least 2.
        spacing: distance between neighbors along an axis [m].
        stiffness: stiffness of each spring along an axis [N/m].
        damping: damping along each spring along an axis [N·s/m].
        mass: mass per particle [kg], one or (N,).
        origin: position of the particle with the smallest coordinates [m]; zero by default.
        shear_stiffness: stiffness of each diagonal [N/m]; None: as `stiffness`; 0 omits the diagonals, unless their
            damping is given.
        pinned: the fixed particles: "left" and "right" (along x), "bottom" and "top" (along the last axis), in 3D also
            "front" and "back" (along y), a tuple of these, a bool mask, or integer indices.
        fixed: synonym of `pinned`, as in Particles; the particles of both are fixed.
        shear_damping: damping along each diagonal [N·s/m]; None: as `damping`.
        velocities, radius, name: as in Particles.
        breaking_strain, strain_limit: values of each spring, as in SpringNetwork.

    Raises:
        SceneError: a parameter is out of range or of the wrong shape.
    """
    nodes = _shape(shape, (2, 3), "soft_body.shape", SOFT_BODY_BYTES)
    dimension = len(nodes)
    step = span(spacing, "soft_body.spacing")
    corner, directions = _frame(
        (0.0,) * dimension if origin is None else origin, None, dimension, "soft_body.origin", "soft_body.shape"
    )
    axial = _strength(stiffness, damping, "soft_body.")
    shear = _strength(shear_stiffness, shear_damping, "soft_body.shear_", axial)
    # One of each pair of opposite offsets, so that no pair of particles is listed twice.
    offsets = [
        offset[::-1]
        for offset in product((-1, 0, 1), repeat=dimension)
        if next((component for component in offset if component), -1) > 0
    ]
    kinds = [
        LatticeSprings(tuple(o for o in offsets if np.abs(o).sum() == 1), step, *axial),
        LatticeSprings(tuple(o for o in offsets if np.abs(o).sum() == 2), step * math.sqrt(2.0), *shear),
    ]
    grid = np.arange(math.prod(nodes)).reshape(nodes[::-1])
    edges = {"left": grid[..., 0], "right": grid[..., -1], "bottom": grid[0], "top": grid[-1]}
    if dimension == 2:
        faces = lattice_faces(grid)
    else:
        edges |= {"front": grid[:, 0], "back": grid[:, -1]}
        # The cross product of columns and rows points outward on three sides; the opposite sides are transposed.
        outward = ("right", "front", "top")
        faces = np.concatenate([lattice_faces(side if name in outward else side.T) for name, side in edges.items()])
    return lattice(
        nodes,
        corner + combined(lattice_points(nodes, step), directions),
        kinds,
        faces=faces,
        mass=mass,
        fixed=_pins(pinned, edges, grid.size, "soft_body.pinned") | _pins(fixed, edges, grid.size, "soft_body.fixed"),
        velocities=velocities,
        radius=radius,
        name=name,
        breaking_strain=breaking_strain,
        strain_limit=strain_limit,
    )


def _frame(
    origin: Vector | None, axes: Sequence[Vector] | None, rank: int, origin_path: str, axes_path: str
) -> tuple[FloatArray, FloatArray]:
    """The origin (D,) and `rank` unit directions (rank, D); by default zero, and +x, +y, +z."""
    start = None if origin is None else vector(origin, origin_path)
    if axes is not None:
        axes = items(axes, axes_path, f"{rank} directions")
    paths = [axes_path] if rank == 1 else [f"{axes_path}[{index}]" for index in range(len(axes or ()))]
    directions = None if axes is None else [vector(axis, path) for axis, path in zip(axes, paths, strict=True)]
    dimension = len(start) if start is not None else len(directions[0]) if directions else max(rank, 2)
    if dimension < rank:
        raise SceneError(f"{origin_path}: must have {rank} components, got {dimension}")
    if directions is None:
        directions = [tuple(row) for row in np.eye(dimension)[:rank].tolist()]
    if len(directions) != rank or any(len(direction) != dimension for direction in directions):
        raise SceneError(
            f"{axes_path}: must be {rank} × {dimension} numbers, got {shown(axes)} with the origin {shown(origin)}"
        )
    matrix = np.array(directions)
    largest = np.abs(matrix).max(axis=1, keepdims=True)
    if (largest == 0.0).any():
        raise SceneError(f"{axes_path}: a direction must not be zero")
    if not ((largest >= SHORTEST) & (largest <= LONGEST)).all():
        matrix /= largest  # Avoids overflow of squares.
    matrix /= lengths(matrix)[:, None]
    if np.abs(combined(matrix, matrix.T) - np.eye(rank)).max() > 1e-9:
        raise SceneError(f"{axes_path}: must be perpendicular, got {shown(axes)}")
    return np.zeros(dimension) if start is None else np.array(start), matrix


def _shape(shape: object, ranks: tuple[int, ...], path: str, size: int) -> tuple[int, ...]:
    """Validated numbers of particles along each axis, for `size` bytes per particle."""
    given = shape.tolist() if isinstance(shape, np.ndarray) and shape.ndim == 1 else shape
    if not isinstance(given, (tuple, list)) or len(given) not in ranks:
        names = " or ".join(f"({', '.join(('columns', 'rows', 'layers')[:rank])})" for rank in ranks)
        numbers = " or ".join(str(rank) for rank in ranks)
        raise SceneError(f"{path}: must be {numbers} whole numbers, got {shown(shape)}; write {names}")
    numbers_of = tuple(count(each, f"{path}[{axis}]", least=2) for axis, each in enumerate(given))
    particles = math.prod(numbers_of)
    memory.require(float(size * particles), f"{particles} particles with their springs", path)
    return numbers_of


def _strength(
    stiffness: float | None, damping: float | None, prefix: str, default: tuple[float, float] = (0.0, 0.0)
) -> tuple[float, float]:
    """Validated (stiffness, damping) of one kind of spring. If the stiffness is set to 0, the default damping is 0."""
    k = default[0] if stiffness is None else number(stiffness, f"{prefix}stiffness", least=0.0)
    if damping is None:
        return k, (0.0 if stiffness is not None and k == 0.0 else default[1])
    return k, number(damping, f"{prefix}damping", least=0.0)


def _along_threads(whole: float, shear: float, thread: str) -> float:
    """The stiffness of springs along warp or weft: that of the sheet minus the share of the diagonals."""
    if shear > whole:
        raise SceneError(
            f"cloth.shear_stiffness: must be at most the material's stiffness along the {thread}, {whole:g} N/m, "
            f"got {shear:g}; diagonals resist a stretch too"
        )
    return whole - shear


def _pins(pinned: Pinned, edges: Mapping[str, IntArray], nodes: int, path: str) -> BoolArray:
    """A bool mask from the name of an edge, several names, a mask, or indices."""
    names = (pinned,) if isinstance(pinned, str) else pinned
    if not isinstance(names, (tuple, list)) or not any(isinstance(name, str) for name in names):
        return mask(pinned, nodes, path)
    chosen = np.zeros(nodes, dtype=np.bool_)
    for name in names:
        if not isinstance(name, str) or name not in edges:
            known = ", ".join(map(repr, edges))
            raise SceneError(
                f"{path}: must be one of {known}, a mask or indices, got {shown(name)}{did_you_mean(name, edges)}"
            )
        chosen[edges[name]] = True
    return chosen
