"""Scenes in the plane that are shown in space: what a relief raises."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from physcore.checks import FloatArray
from physcore.scene.scene import Scene
from physcore.simulation.provenance_record import ProvenanceRecord
from physcore.simulation.sources import Source, SourceFrame


class RaisedScene(Scene):
    """The bodies and systems of a scene in 2D, as a film in 3D has them; boundaries and domains stay in the plane."""

    def __init__(self, flat: Scene) -> None:
        values = {"bodies": flat.bodies, "systems": flat.systems, "forces": (), "boundaries": (), "periodic": None}
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @property
    def dimension(self) -> int:
        """That of the space in which it is shown."""
        return 3


class Raised:
    """A source in 2D whose particles have a height, zero until a painter raises them."""

    def __init__(self, flat: Source) -> None:
        self._flat = flat
        self.scene: Scene = RaisedScene(flat.scene)

    @property
    def fps(self) -> float:
        """Frames per second of simulated time."""
        return self._flat.fps

    @property
    def times(self) -> FloatArray:
        """When the frames are [s]."""
        return self._flat.times

    @property
    def count(self) -> int:
        """How many frames there are."""
        return self._flat.count

    @property
    def integrator(self) -> str | None:
        """The integrator's name."""
        return self._flat.integrator

    @property
    def audited(self) -> bool:
        """Whether frames have energies and time steps."""
        return self._flat.audited

    @property
    def simulated(self) -> bool:
        """Whether its frames are simulated each time that they are looked at."""
        return self._flat.simulated

    @property
    def provenance(self) -> ProvenanceRecord:
        """The provenance of what is shown."""
        return self._flat.provenance

    def has(self, field: str) -> bool:
        """Whether frames have a field of that name."""
        return self._flat.has(field)

    def frames(self) -> Iterator[SourceFrame]:
        """All frames from the start, with positions (N, 3)."""
        for frame in self._flat.frames():
            positions = np.pad(frame.positions, ((0, 0), (0, 1)))
            yield replace(frame, fields={**frame.fields, "positions": positions})
