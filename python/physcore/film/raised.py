"""Scenes in the plane that are shown in space: what a relief raises."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from physcore.film.derived import Derived
from physcore.scene.scene import Scene
from physcore.simulation.sources import Source, SourceFrame


class RaisedScene(Scene):
    """The bodies and systems of a scene in 2D, as a film in 3D has them; boundaries and domains stay in the plane."""

    def __init__(self, flat: Scene) -> None:
        values = {
            "bodies": flat.bodies,
            "systems": flat.systems,
            "forces": (),
            "boundaries": (),
            "constraints": (),
            "periodic": None,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @property
    def dimension(self) -> int:
        """That of the space in which it is shown."""
        return 3


class Raised(Derived):
    """A source in 2D whose particles have a height, zero until a painter raises them."""

    def __init__(self, flat: Source) -> None:
        super().__init__(flat)
        self.scene = RaisedScene(flat.scene)

    def frames(self) -> Iterator[SourceFrame]:
        """All frames from the start, with positions (N, 3)."""
        for frame in super().frames():
            positions = np.pad(frame.positions, ((0, 0), (0, 1)))
            yield replace(frame, fields={**frame.fields, "positions": positions})
