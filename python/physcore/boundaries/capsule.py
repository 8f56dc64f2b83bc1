"""Capsule, as an obstacle; the name is also that of a shape of rigid bodies."""

from __future__ import annotations

from dataclasses import dataclass
from inspect import Signature, signature
from numbers import Real
from typing import Any

from physcore.checks import Vector, number, vector
from physcore.entrance import entrance
from physcore.errors import SceneError
from physcore.scene import solids
from physcore.scene.items import Boundary


@dataclass(frozen=True)
class Capsule(Boundary):
    """Capsule: all points within `radius` of a segment. Particles stay outside.

        grains = pc.Particles(rng.uniform((-0.4, 0.4), (0.4, 1.0), (50, 2)), radius=0.01)
        bar = pc.Capsule((-0.5, 0.3), (0.5, 0.0), radius=0.05, friction=0.4)
        scene = pc.Scene(grains, bar, pc.Gravity((0.0, -9.81)))
        pill = pc.RigidBody(pc.Capsule(0.2, 0.05), (0.0, 1.0))

    A capsule between two points is an obstacle. `Capsule(length, radius)` is the shape of a rigid body about its center
    of mass: the segment, of this length between the centers of its round ends, is along x in 2D and along z in 3D. Its
    `area` is that in 2D, its `volume` that in 3D, and `properties(2)` and `properties(3)` have its other properties.

    Args:
        start, end: the ends of the segment [m], one number for each dimension of the scene.
        radius: radius of the capsule [m], above zero.
        restitution, friction, no_slip, on: as in Boundary.

    Raises:
        SceneError: the radius or the length is not above zero, the ends differ in size, or a value is not finite.
    """

    start: Vector
    end: Vector
    radius: float

    @entrance
    def __new__(cls, *arguments: Any, **keywords: Any) -> Any:
        """An obstacle, or from a length and a radius the shape of a rigid body."""
        if "length" in keywords or (arguments and isinstance(arguments[0], Real)):
            return solids.Capsule(*arguments, **keywords)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        super().__post_init__()
        start, end = vector(self.start, "Capsule.start"), vector(self.end, "Capsule.end")
        if len(start) != len(end):
            raise SceneError(f"Capsule.end: must have {len(start)} components like the start, got {len(end)}")
        self._set(start=start, end=end, radius=number(self.radius, "Capsule.radius", above=0.0))


_OWN, *_PARAMETERS = signature(Capsule.__init__).parameters.values()
Capsule.__signature__ = Signature(_PARAMETERS)  # type: ignore[attr-defined]  # that of an obstacle
