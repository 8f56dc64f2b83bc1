"""The source of pictures that are drawn one by one: it has one frame, the present one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physcore.checks import FloatArray
from physcore.scene.scene import Scene
from physcore.simulation.provenance_record import ProvenanceRecord, record_of
from physcore.simulation.sources import SourceFrame


class Present:
    """A source whose only frame is replaced from picture to picture.

    Args:
        scene: the scene.
        fps: nominal frames per second of simulated time.
        count: nominal number of frames, from which painters choose the lengths of trails.
    """

    audited = True
    """True; the renderer refuses a frame without the energies and time steps that its labels need."""
    simulated = False

    def __init__(self, scene: Scene, fps: float, count: int) -> None:
        self.scene, self.fps, self.count = scene, fps, count
        self.integrator: str | None = None
        self.frame: SourceFrame | None = None

    @property
    def times(self) -> FloatArray:
        """The nominal times of the frames [s]."""
        times: FloatArray = np.arange(self.count) / self.fps
        return times

    def has(self, field: str) -> bool:
        """Whether the scene has a field of this name."""
        return field in self.scene.fields

    @property
    def provenance(self) -> ProvenanceRecord:
        """The provenance, as far as the scene tells it."""
        return record_of(self.scene, None, None)

    def frames(self) -> Iterator[SourceFrame]:
        """The present frame."""
        assert self.frame is not None  # the renderer has set it
        yield self.frame
