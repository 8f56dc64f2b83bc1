"""Capsule obstacle."""

from __future__ import annotations

from dataclasses import dataclass

from physcore.checks import Vector, number, vector
from physcore.errors import SceneError
from physcore.scene.items import Boundary


@dataclass(frozen=True)
class Capsule(Boundary):
    """Capsule: all points within `radius` of a segment. Particles stay outside.

        grains = pc.Particles(rng.uniform((-0.4, 0.4), (0.4, 1.0), (50, 2)), radius=0.01)
        bar = pc.Capsule((-0.5, 0.3), (0.5, 0.0), radius=0.05, friction=0.4)
        scene = pc.Scene(grains, bar, pc.Gravity((0.0, -9.81)))

    Args:
        start, end: the ends of the segment [m], one number for each dimension of the scene.
        radius: radius of the capsule [m], above zero.
        restitution, friction, no_slip, on: as in Boundary.

    Raises:
        SceneError: the radius is not above zero, the ends differ in size, or a value is not finite.
    """

    start: Vector
    end: Vector
    radius: float

    def __post_init__(self) -> None:
        super().__post_init__()
        start, end = vector(self.start, "Capsule.start"), vector(self.end, "Capsule.end")
        if len(start) != len(end):
            raise SceneError(f"Capsule.end: must have {len(start)} components like the start, got {len(end)}")
        self._set(start=start, end=end, radius=number(self.radius, "Capsule.radius", above=0.0))
