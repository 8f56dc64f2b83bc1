"""Uniform gravity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self, cast

import numpy as np

from physcore.checks import FloatArray, TimedVector, timed
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.items import Force
from physcore.scene.selection import Selection
from physcore.units.systems import Default, UnitSystem

G = Default(9.81, "m/s²")
"""Standard acceleration of gravity on Earth [m/s²]: 9.78 at the equator, 9.83 at the poles."""


@dataclass(frozen=True)
class Gravity(Force):
    """Uniform gravity: F = m g, with the potential −m g·x.

        scene = pc.Scene(pc.Particles([[0.0, 1.0]]), pc.Gravity())
        on_the_moon = pc.Gravity((0.0, -1.62))
        in_a_lift = pc.Gravity(lambda t: (0.0, -9.81 - 2.0 * math.sin(t)))

    Args:
        acceleration: g [m/s²], one number for each dimension of the scene; or a function of the time [s] that returns
            it, called in every evaluation, whose power counts as work. None: 9.81 m/s², in the units of the scene,
            downward, against the last axis, y in 2D and z in 3D.
        on: the body or bodies that the force acts on, or their names; all by default.

    Raises:
        SceneError: `acceleration` is not two or three finite numbers, or a function fails.
    """

    timed: ClassVar[tuple[str, ...]] = ("acceleration",)

    acceleration: TimedVector | None = None

    @property
    def dissipates(self) -> bool:
        """Whether the acceleration is a function of time."""
        return callable(self.acceleration)

    def fall(self, dimension: int) -> FloatArray | None:
        """The acceleration, if it is constant."""
        return None if callable(self.acceleration) else np.array(self.resolved(dimension).acceleration, dtype=float)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.acceleration is not None:
            self._set(acceleration=timed(self.acceleration, "Gravity.acceleration"))

    def check(self, bodies: Sequence[Body], path: str) -> None:
        """Check that no fluid is named in part, because fluids start in balance with gravity."""
        for target in self.targets() or ():
            if isinstance(target, Selection) and cast("Body", target.body).is_fluid:
                raise SceneError(
                    f"{path}.on: must be the whole fluid, which starts in balance with gravity, got {target!r}"
                )

    def resolved(self, dimension: int) -> Gravity:
        """The gravity with its acceleration in a scene of `dimension` dimensions."""
        return self if self.acceleration is not None else self._downward(G, dimension)

    def in_units(self, units: UnitSystem, dimension: int, path: str) -> Self:
        """The gravity with the default acceleration in units of a scene."""
        given = self.acceleration is not None
        return self if given else self._downward(G.converted(units, f"{path}.acceleration"), dimension)

    def _downward(self, size: float, dimension: int) -> Self:
        """Gravity against the last axis."""
        return replace(self, acceleration=(0.0,) * (dimension - 1) + (-size,))
