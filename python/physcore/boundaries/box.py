"""Axis-aligned box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physcore.checks import FloatArray, Vector, flag, vector, written
from physcore.errors import SceneError
from physcore.scene.items import Boundary


@dataclass(frozen=True)
class Box(Boundary):
    """Axis-aligned box, a rectangle in 2D. Particles stay inside, or outside if `inside` is False.

        gas = pc.Particles(rng.uniform(0.1, 0.9, (50, 2)), velocities=rng.normal(size=(50, 2)), radius=0.01)
        scene = pc.Scene(gas, pc.Box((0.0, 0.0), (1.0, 1.0)), pc.Box((0.4, -0.1), (0.6, 0.05), inside=False))

    Args:
        lower: the corner with the smallest coordinates [m].
        upper: the corner with the largest coordinates [m].
        inside: whether particles are kept inside the box.
        restitution, friction, no_slip, on: as in Boundary.

    Raises:
        SceneError: `lower` is not below `upper` in every component, or a value is not finite.
    """

    lower: Vector
    upper: Vector
    inside: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        lower, upper = vector(self.lower, "Box.lower"), vector(self.upper, "Box.upper")
        if len(lower) != len(upper):
            raise SceneError(f"Box.upper: must have {len(lower)} components like the lower corner, got {len(upper)}")
        if not all(low < high for low, high in zip(lower, upper, strict=True)):
            raise SceneError(
                f"Box.upper: must be above the lower corner {written(lower)} in every component, got {written(upper)}"
            )
        self._set(lower=lower, upper=upper, inside=flag(self.inside, "Box.inside"))

    @property
    def room(self) -> tuple[Vector, Vector] | None:
        """The corners, if particles are kept inside."""
        return (self.lower, self.upper) if self.inside else None

    def is_symmetric(self, middle: FloatArray, normal: FloatArray, tolerance: float) -> bool:
        """Whether particles are kept inside, and the plane is normal to an axis."""
        del middle
        return self.inside and bool(np.abs(normal).max() > 1.0 - tolerance)
