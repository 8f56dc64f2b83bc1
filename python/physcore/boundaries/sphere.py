"""Sphere, as an obstacle or as a bowl."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physcore.arithmetic import dots
from physcore.checks import FloatArray, Vector, flag, number, vector
from physcore.scene.items import Boundary


@dataclass(frozen=True)
class Sphere(Boundary):
    """Sphere, a circle in 2D. Particles stay outside, or inside if `inside` is True.

        ball = pc.Particles([[0.1, 1.5]], radius=0.1)
        scene = pc.Scene(ball, pc.Gravity(), pc.Sphere((0.0, 0.0), radius=1.0, inside=False))

    Args:
        center: center of the sphere [m], one number for each dimension of the scene.
        radius: radius of the sphere [m], above zero.
        inside: whether particles are kept inside the sphere.
        restitution, friction, no_slip, on: as in Boundary.

    Raises:
        SceneError: the radius is not above zero, or a value is not finite.
    """

    center: Vector
    radius: float
    inside: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(
            center=vector(self.center, "Sphere.center"),
            radius=number(self.radius, "Sphere.radius", above=0.0),
            inside=flag(self.inside, "Sphere.inside"),
        )

    @property
    def ball(self) -> tuple[Vector, float] | None:
        """The sphere, if it is an obstacle."""
        return None if self.inside else (self.center, self.radius)

    def is_symmetric(self, middle: FloatArray, normal: FloatArray, tolerance: float) -> bool:
        """Whether its center lies in the plane."""
        return bool(abs(dots(np.array(self.center) - middle, normal)) < tolerance * self.radius)
