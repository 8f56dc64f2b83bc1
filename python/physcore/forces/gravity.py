"""Uniform gravity."""

from __future__ import annotations

from dataclasses import dataclass

from physcore.checks import Vector, vector
from physcore.scene.items import Force


@dataclass(frozen=True)
class Gravity(Force):
    """The same acceleration for every particle: F = m g, with the potential −m g·x.

    Args:
        acceleration: g [m/s²], as many numbers as the scene has dimensions.
        on: the body or bodies that it acts on; all by default.

    Raises:
        SceneError: `acceleration` is not two or three finite numbers.
    """

    acceleration: Vector

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(acceleration=vector(self.acceleration, "Gravity.acceleration"))
