"""Boundaries, one module each."""

from __future__ import annotations

from physcore.boundaries.box import Box
from physcore.boundaries.capsule import Capsule
from physcore.boundaries.convex_hull import ConvexHull
from physcore.boundaries.height_field import HeightField
from physcore.boundaries.plane import Floor, Plane
from physcore.boundaries.sphere import Sphere
from physcore.scene.items import Boundary

BOUNDARIES: tuple[type[Boundary], ...] = (
    Floor,
    Plane,
    Box,
    Sphere,
    Capsule,
    ConvexHull,
    HeightField,
)
"""All boundary classes. Those registered here can be saved and are tested."""

__all__ = ["BOUNDARIES", "Boundary", "Box", "Capsule", "ConvexHull", "Floor", "HeightField", "Plane", "Sphere"]
