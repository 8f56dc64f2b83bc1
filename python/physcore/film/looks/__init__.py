"""Drawing of boundaries and wires, one module each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from physcore.boundaries.box import Box
from physcore.boundaries.capsule import Capsule
from physcore.boundaries.convex_hull import ConvexHull
from physcore.boundaries.height_field import HeightField
from physcore.boundaries.plane import Plane
from physcore.boundaries.sphere import Sphere
from physcore.constraints.wire import Wire
from physcore.film.looks.base import Look
from physcore.film.looks.box import BoxLook
from physcore.film.looks.height_field import HeightFieldLook
from physcore.film.looks.plane import PlaneLook
from physcore.film.looks.solid import SolidLook
from physcore.film.looks.sphere import SphereLook
from physcore.film.looks.wire import WireLook
from physcore.film.shapes.box import corners
from physcore.scene.items import SceneItem

LOOKS: dict[type[SceneItem], Callable[[Any], Look]] = {
    Plane: PlaneLook,
    Box: lambda box: BoxLook(box) if box.inside else SolidLook(corners(np.array(box.lower), np.array(box.upper))),
    Sphere: SphereLook,
    Capsule: SolidLook.capsule,
    ConvexHull: SolidLook.hull,
    HeightField: HeightFieldLook,
    Wire: WireLook,
}
"""Factory of the look of each class of boundaries and constraints."""


def look_of(item: SceneItem) -> Look:
    """The look of an item as resolved in its scene. An item without a look is not drawn."""
    looks = (LOOKS[kind](item) for kind in type(item).__mro__ if kind in LOOKS)
    return next(looks, Look())
