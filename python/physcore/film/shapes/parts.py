"""Convex parts of shapes, and rotations of bodies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from physcore.checks import FloatArray
from physcore.scene.polytopes import Compound
from physcore.scene.solids import Shape


@dataclass(frozen=True, eq=False)
class ShapePart:
    """A part of a shape that is no compound, with its place in the coordinates about the center of mass."""

    shape: Shape
    rotation: FloatArray
    """Rotation from the coordinates of the part, shape (D, D)."""
    origin: FloatArray
    """Place of the origin of the part's coordinates [m], shape (D,)."""

    def placed(self, points: FloatArray) -> FloatArray:
        """Points (K, D) of the part in the coordinates about the center of mass."""
        result: FloatArray = points @ self.rotation.T + self.origin
        return result


def parts_of(shape: Shape, dimension: int) -> Iterator[ShapePart]:
    """The parts of a shape in 2D or 3D; of most shapes the shape itself."""
    center = shape.properties(dimension).center
    if not isinstance(shape, Compound):
        yield ShapePart(shape, np.eye(dimension), -center)
        return
    turns = planar_rotations(shape.angles) if shape.angles is not None else spatial_rotations(shape.orientations)
    for part, turn, place in zip(shape.shapes, turns, shape.positions, strict=True):
        yield ShapePart(part, turn, place - center)


def planar_rotations(angles: FloatArray) -> FloatArray:
    """Rotation matrices (N, 2, 2) of angles (N,) [rad]."""
    cosine, sine = np.cos(angles), np.sin(angles)
    return np.stack([np.stack([cosine, -sine], axis=-1), np.stack([sine, cosine], axis=-1)], axis=-2)


def spatial_rotations(quaternions: FloatArray | None) -> FloatArray:
    """Rotation matrices (N, 3, 3) of unit quaternions (w, x, y, z), shape (N, 4)."""
    assert quaternions is not None  # of bodies in 3D
    w, x, y, z = quaternions.T
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)
