"""Convex parts of shapes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from physcore.checks import FloatArray
from physcore.scene.polytopes import Compound
from physcore.scene.rotations import planar_rotations, spatial_rotations
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
    if shape.angles is not None:
        turns = planar_rotations(shape.angles)
    else:
        assert shape.orientations is not None  # compounds have one of both
        turns = spatial_rotations(shape.orientations)
    for part, turn, place in zip(shape.shapes, turns, shape.positions, strict=True):
        yield ShapePart(part, turn, place - center)
