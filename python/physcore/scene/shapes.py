"""Shapes filled with particles: the cell centers of a square or cubic lattice inside the shape."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from physcore import memory
from physcore.arithmetic import dots
from physcore.checks import MOST, FloatArray, Vector, span, vector
from physcore.entrance import entrance
from physcore.errors import SceneError

COPIES = 3
"""Peak memory in arrays of coordinates while a shape is filled."""


@entrance
def block(lower: Vector, upper: Vector, spacing: float) -> FloatArray:
    """Block of particles: a rectangle in 2D, a cuboid in 3D.

        water = pc.Fluid(pc.block((0.0, 0.0), (0.5, 1.0), spacing=0.05), spacing=0.05)

    Args:
        lower: the corner with the smallest coordinates [m].
        upper: the corner with the largest coordinates [m].
        spacing: the edge of a cell [m]. There are round(extent / spacing) cells along each axis, starting at the lower
            corner.

    Returns:
        The centers of all cells [m], shape (N, D), ordered along x first.

    Raises:
        SceneError: the extent along an axis is less than one cell, or a value is not finite.
    """
    step = span(spacing, "block.spacing")
    low, high = vector(lower, "block.lower"), vector(upper, "block.upper")
    if len(low) != len(high):
        raise SceneError(f"block.upper: must have {len(low)} components like the lower corner, got {len(high)}")
    counts = []
    for axis, (start, end) in enumerate(zip(low, high, strict=True)):
        cells = _cells(end - start, step)
        if cells < 1:
            raise SceneError(
                f"block.upper[{axis}]: must be at least one spacing, {step:g} m, above the lower corner at "
                f"{start:g} m, got {end:g} m"
            )
        counts.append(cells)
    _require_memory(math.prod(counts), len(counts), "block.spacing")
    return np.array(low) + step * _centers(counts)


@entrance
def ball(center: Vector, radius: float, spacing: float) -> FloatArray:
    """Ball of particles, a disc in 2D.

        drop = pc.Fluid(pc.ball((0.0, 0.5), radius=0.2, spacing=0.02), spacing=0.02)

    Args:
        center: center of the ball [m].
        radius: radius of the ball [m], above zero.
        spacing: the edge of a cell [m].

    Returns:
        The centers of the cells inside [m], shape (N, D), ordered along x first.

    Raises:
        SceneError: the shape has no room for a cell, or a value is not finite.
    """
    middle = vector(center, "ball.center")
    return np.array(middle) + _round(span(radius, "ball.radius"), spacing, len(middle), "ball")


@entrance
def cylinder(center: Vector, radius: float, height: float, spacing: float) -> FloatArray:
    """Cylinder of particles in 3D, along z.

        water = pc.Fluid(pc.cylinder((0.0, 0.0, 0.0), radius=0.2, height=0.4, spacing=0.05), spacing=0.05)

    Args:
        center: center of the base [m].
        radius: radius of the cylinder [m], above zero.
        height: height along z [m], at least one spacing; there are round(height / spacing) layers from the base on.
        spacing: the edge of a cell [m].

    Returns:
        The centers of the cells inside [m], shape (N, 3), ordered along x first.

    Raises:
        SceneError: the shape has no room for a cell, or a value is not finite.
    """
    base = vector(center, "cylinder.center")
    if len(base) != 3:
        raise SceneError(f"cylinder.center: must have 3 components, got {len(base)}; in 2D take a block")
    step, tall = span(spacing, "cylinder.spacing"), span(height, "cylinder.height")
    disc = _round(span(radius, "cylinder.radius"), step, 2, "cylinder")
    layers = _cells(tall, step)
    if layers < 1:
        raise SceneError(f"cylinder.height: must be at least one spacing of {step:g} m, got {tall:g} m")
    _require_memory(layers * len(disc), 3, "cylinder.spacing")
    heights = step * (np.arange(layers) + 0.5)
    points: FloatArray = np.column_stack([np.tile(disc, (layers, 1)), np.repeat(heights, len(disc))])
    points += np.array(base)
    return points


def _cells(extent: float, step: float, whole: Callable[[float], int] = round) -> int:
    """The number of cells along an extent [m], limited to MOST + 1."""
    return whole(min(max(extent / step, -1.0), MOST + 1.0))


def _require_memory(cells: int, dimension: int, path: str) -> None:
    """Check that the cells fit into memory.

    Raises:
        SceneError: they do not fit.
    """
    memory.require(COPIES * 8.0 * dimension * cells, f"{cells:.4g} cells", path, "make it larger")


def _centers(counts: list[int]) -> FloatArray:
    """The centers of cells of size 1, starting at the origin, shape (N, D), the first axis fastest."""
    indices = np.indices(counts[::-1], dtype=np.float64).reshape(len(counts), -1)[::-1].T
    return np.ascontiguousarray(indices + 0.5)


def _round(radius: float, spacing: float, dimension: int, path: str) -> FloatArray:
    """The cell centers of a lattice around the origin that are within a radius."""
    step = span(spacing, f"{path}.spacing")
    half = _cells(radius, step, math.floor) + 1
    _require_memory(math.prod([2 * half] * dimension), dimension, f"{path}.spacing")
    points: FloatArray = step * (_centers([2 * half] * dimension) - half)
    inside: FloatArray = points[dots(points, points) <= radius * radius]
    if len(inside) == 0:
        raise SceneError(f"{path}.radius: a radius of {radius:g} m has no room for a cell of {step:g} m")
    return inside
