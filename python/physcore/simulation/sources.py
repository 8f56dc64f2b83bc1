"""Sources of frames, for films and exports: a recording, or a simulation that runs meanwhile."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from physcore import memory
from physcore.checks import FloatArray, shown, span
from physcore.errors import InternalError, SceneError
from physcore.numerics.choices import FRAMES_PER_SECOND, Options, check
from physcore.scene.channels import field_names
from physcore.scene.records import Record
from physcore.scene.scene import Scene
from physcore.simulation.energy import Drift, Energy
from physcore.simulation.frames import frame_count
from physcore.simulation.provenance_record import ProvenanceRecord, provenance_record, record_of
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation
from physcore.spelling import KeywordError


@dataclass(frozen=True, eq=False)
class SourceFrame:
    """Positions, fields and energy at one time, as far as a source has them."""

    time: float
    """[s]"""
    fields: Mapping[str, FloatArray]
    """The fields by name, as far as they were recorded; positions [m] always."""
    energy: Energy | None = None
    """The energy budget, where it is known."""
    dt: float | None = None
    """The time step [s], likewise."""

    @property
    def positions(self) -> FloatArray:
        """[m], shape (N, D)."""
        return self.fields["positions"]


class Source(Protocol):
    """Something that can be looked at from the start as often as needed."""

    @property
    def scene(self) -> Scene:
        """The scene."""

    @property
    def fps(self) -> float:
        """Frames per second of simulated time."""

    @property
    def times(self) -> FloatArray:
        """When the frames are [s], shape (F,)."""

    @property
    def count(self) -> int:
        """How many frames there are."""

    @property
    def integrator(self) -> str | None:
        """The integrator's name, where it is known."""

    @property
    def audited(self) -> bool:
        """Whether frames have energies and time steps."""

    @property
    def simulated(self) -> bool:
        """Whether its frames are simulated each time that they are looked at."""

    def has(self, field: str) -> bool:
        """Whether frames have a field of that name."""

    @property
    def provenance(self) -> ProvenanceRecord:
        """The provenance of what is shown, as far as it is known."""

    def frames(self) -> Iterator[SourceFrame]:
        """All frames from the start."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """The frames of a recording."""

    recording: Recording

    simulated: ClassVar[bool] = False

    @property
    def scene(self) -> Scene:
        """The scene that was recorded."""
        return self.recording.scene

    @property
    def fps(self) -> float:
        """Frames per second of simulated time."""
        return self.recording.fps

    @property
    def times(self) -> FloatArray:
        """When the frames are [s]."""
        return self.recording.times

    @property
    def count(self) -> int:
        """How many frames there are."""
        return len(self.recording.times)

    @property
    def provenance(self) -> ProvenanceRecord:
        """The provenance of the recording."""
        return provenance_record(self.recording)

    @property
    def integrator(self) -> str | None:
        """The integrator's name."""
        return self.recording.plan.integrator if self.audited else None

    @property
    def audited(self) -> bool:
        """Whether it is a whole recording, and not only positions."""
        return hasattr(self.recording, "energy") and hasattr(self.recording, "plan")

    def has(self, field: str) -> bool:
        """Whether it was recorded."""
        return field in self.recording.channels

    def frames(self) -> Iterator[SourceFrame]:
        """The frames in order."""
        nothing = np.empty((self.count, 0, getattr(self.recording.scene, "dimension", 2)))
        positions = self.recording.positions if getattr(self.recording.scene, "bodies", True) else nothing
        channels = {**self.recording.channels, "positions": positions}
        dt = self.recording.plan.dt if self.audited else None
        for index, time in enumerate(self.recording.times):
            fields: dict[str, FloatArray] = {name: values[index] for name, values in channels.items()}
            energy = self.recording.energy.at(index) if self.audited else None
            yield SourceFrame(float(time), fields, energy, dt)


class Running:
    """A scene that is simulated from its start as often as it is looked at, one frame at a time, with the same bits."""

    audited = True
    """A simulation knows its energy."""
    simulated = True

    def __init__(self, scene: Scene, duration: float, fps: float, numerics: Options) -> None:
        self.scene = scene
        self.duration = duration
        self.fps = fps
        self.numerics = numerics
        self._provenance: ProvenanceRecord | None = None

    @property
    def count(self) -> int:
        """How many frames there are."""
        return frame_count(self.duration, self.fps)

    @property
    def times(self) -> FloatArray:
        """When the frames are [s]."""
        times: FloatArray = np.arange(self.count) / self.fps
        return times

    @property
    def integrator(self) -> str:
        """The integrator's name."""
        return type(check(self.numerics, self.scene).integrator).__name__

    def has(self, field: str) -> bool:
        """A simulation has all that there is."""
        return field in field_names(self.scene)

    def frames(self) -> Iterator[SourceFrame]:
        """Simulate from the start.

        Raises:
            InternalError: the bits were not those of the last time.
        """
        simulation, drift, first = Simulation(self.scene, **self.numerics), Drift(), None
        for frame in simulation.frames(self.duration, self.fps):
            first, last = first or frame, frame
            drift.add(frame.energy)
            yield SourceFrame(frame.time, frame.fields, frame.energy, frame.dt)
        assert first is not None
        found = record_of(
            self.scene,
            simulation.plan,
            simulation.provenance,
            duration=last.time - first.time,
            fps=self.fps,
            energy_drift=drift.largest,
            momentum=[first.momentum.tolist(), last.momentum.tolist()],
        )
        if self._provenance not in (None, found):
            items = (*self.scene.forces, *self.scene.systems)
            code = next((type(item).__name__ for item in items if Record.of(item).is_code), None)
            cause = "please report it" if code is None else f"its {code} gives other values for the same arguments"
            raise InternalError(f"the scene did not repeat itself when it was simulated again: {cause}")
        self._provenance = found

    @property
    def provenance(self) -> ProvenanceRecord:
        """Its provenance; it is run to its end if it was not."""
        if self._provenance is None:
            for _ in self.frames():
                pass
        assert self._provenance is not None
        return self._provenance


def sources(source: object, duration: float | None, fps: float | None, numerics: Options) -> list[Source]:
    """One source for each panel.

    Raises:
        SceneError: something is neither a recording nor a scene, an argument is out of range, or the rates differ.
        TypeError: a keyword is no numerical choice.
    """
    for name in numerics:
        if name not in Options.__annotations__:
            raise KeywordError("film", name, Options.__annotations__)
    items = list(source) if isinstance(source, (list, tuple)) else [source]
    if not items:
        raise SceneError("recording: there must be at least one")
    found = [_source(item, duration, fps, numerics) for item in items]
    rates = sorted({each.fps for each in found})
    if len(rates) > 1:
        raise SceneError(f"recording: panels must have the same frames per second, got {rates}")
    return found


def _source(item: object, duration: float | None, fps: float | None, numerics: Options) -> Source:
    if isinstance(item, Scene):
        if duration is None:
            raise SceneError("duration: a scene is shown while it is simulated, so say how long: duration=… [s]")
        rate = FRAMES_PER_SECOND if fps is None else span(fps, "fps")
        running = Running(item, span(duration, "duration", empty=True), rate, numerics)
        memory.require(8.0 * running.count, f"the times of {running.count} frames", "duration", "lower fps")
        check(numerics, item)
        return running
    if not all(hasattr(item, name) for name in ("scene", "times", "positions", "fps")):
        raise SceneError(f"recording: must be a Recording, a Scene or a list of them, got {shown(item)}")
    given = {"duration": duration, "fps": fps, **numerics}
    for name, value in given.items():
        if value is not None:
            raise SceneError(f"{name}: is for a scene, and this is a recording; pass it to simulate(…) instead")
    return Recorded(item)  # type: ignore[arg-type]
