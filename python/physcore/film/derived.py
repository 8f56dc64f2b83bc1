"""Sources derived from another source by changing its frames."""

from __future__ import annotations

from collections.abc import Iterator

from physcore.checks import FloatArray
from physcore.scene.scene import Scene
from physcore.simulation.provenance_record import ProvenanceRecord
from physcore.simulation.sources import Source, SourceFrame


class Derived:
    """A source with the frames of another source; subclasses change these."""

    def __init__(self, origin: Source) -> None:
        self._origin = origin
        self.scene: Scene = origin.scene

    @property
    def fps(self) -> float:
        """Frames per second of simulated time."""
        return self._origin.fps

    @property
    def times(self) -> FloatArray:
        """The times of the frames [s]."""
        return self._origin.times

    @property
    def count(self) -> int:
        """The number of frames."""
        return self._origin.count

    @property
    def integrator(self) -> str | None:
        """The integrator's name."""
        return self._origin.integrator

    @property
    def audited(self) -> bool:
        """Whether frames have energies and time steps."""
        return self._origin.audited

    @property
    def simulated(self) -> bool:
        """Whether each iteration over the frames runs the simulation again."""
        return self._origin.simulated

    @property
    def provenance(self) -> ProvenanceRecord:
        """The provenance of the recording or simulation."""
        return self._origin.provenance

    def has(self, field: str) -> bool:
        """Whether frames have a field of this name."""
        return self._origin.has(field)

    def frames(self) -> Iterator[SourceFrame]:
        """All frames from the start."""
        return self._origin.frames()
