"""2D scenes shown in 3D as a relief."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from physcore.film.derived import Derived
from physcore.scene.scene import Scene
from physcore.simulation.sources import Source, SourceFrame


class RaisedScene(Scene):
    """The bodies and systems of a 2D scene for a film in 3D, without boundaries and domains."""

    def __init__(self, flat: Scene) -> None:
        values = {
            "bodies": flat.bodies,
            "systems": flat.systems,
            "forces": (),
            "boundaries": (),
            "constraints": (),
            "periodic": None,
            "units": flat.units,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @property
    def dimension(self) -> int:
        """The dimension of the space in which the scene is shown."""
        return 3


class Raised(Derived):
    """A 2D source whose particles have a height, which is zero until a painter sets it."""

    def __init__(self, flat: Source) -> None:
        super().__init__(flat)
        self.scene = RaisedScene(flat.scene)

    def frames(self) -> Iterator[SourceFrame]:
        """All frames from the start, with positions (N, 3)."""
        for frame in super().frames():
            positions = np.pad(frame.positions, ((0, 0), (0, 1)))
            yield replace(frame, fields={**frame.fields, "positions": positions})
