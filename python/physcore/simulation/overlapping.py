"""Overlaps of rigid bodies in given states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from physcore._core import rigid_overlaps
from physcore.checks import FloatArray
from physcore.numerics.choices import check
from physcore.scene.marks import TURNS
from physcore.scene.scene import Scene
from physcore.simulation import engine


class RigidOverlap(NamedTuple):
    """Overlap of two rigid bodies, or of one with a boundary."""

    depth: float
    """Depth [m]."""
    size: float
    """Largest distance of a surface point of the smaller body from its center [m]."""
    one: str
    other: str
    """Paths of both in the scene."""


def overlaps(scene: Scene, fields: Mapping[str, FloatArray]) -> list[list[RigidOverlap]]:
    """The overlaps of rigid bodies in each of several frames. Joined bodies are left out, because they may overlap.

    Args:
        scene: scene with rigid bodies.
        fields: "rigid_positions" (F, B, D) [m], and "angles" (F, B) [rad] or "orientations" (F, B, 4).
    """
    places, turns = fields["rigid_positions"], fields[TURNS[scene.dimension]]
    described = engine.describe(scene, check({}, scene))
    flat = [np.ascontiguousarray(values, dtype=np.float64).ravel() for values in (places, turns)]
    found = rigid_overlaps(described, places.shape[1], *flat)
    return [
        [RigidOverlap(depth, size, *(engine.named(path, scene) for path in paths)) for depth, size, *paths in frame]
        for frame in found
    ]
