"""Sources of frames for films and exports: a recording, or a running simulation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from physcore import memory
from physcore.checks import FloatArray, shown, span
from physcore.errors import InternalError, SceneError
from physcore.numerics.choices import FRAMES_PER_SECOND, Options, check, require_options
from physcore.scene.records import Record
from physcore.scene.scene import Scene
from physcore.simulation.energy import Drift, Energy
from physcore.simulation.frames import frame_count
from physcore.simulation.provenance_record import ProvenanceRecord, provenance_record, record_of
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation


@dataclass(frozen=True, eq=False)
class SourceFrame:
    """Fields and energy at one time, as far as a source has them."""

    time: float
    """Time [s]."""
    fields: Mapping[str, FloatArray]
    """Fields by name, as far as they were recorded; always with positions [m]."""
    energy: Energy | None = None
    """Energy budget, or None."""
    dt: float | None = None
    """Time step [s], or None."""

    @property
    def positions(self) -> FloatArray:
        """Positions [m], shape (N, D)."""
        return self.fields["positions"]


class Source(Protocol):
    """A source of frames, which can be iterated from the start repeatedly."""

    @property
    def scene(self) -> Scene:
        """The scene."""

    @property
    def fps(self) -> float:
        """Frames per second of simulated time."""

    @property
    def times(self) -> FloatArray:
        """The times of the frames [s], shape (F,)."""

    @property
    def count(self) -> int:
        """The number of frames."""

    @property
    def integrator(self) -> str | None:
        """The integrator's name, or None."""

    @property
    def audited(self) -> bool:
        """Whether frames have energies and time steps."""

    @property
    def simulated(self) -> bool:
        """Whether each iteration over the frames runs the simulation again."""

    def has(self, field: str) -> bool:
        """Whether frames have a field of this name."""

    @property
    def provenance(self) -> ProvenanceRecord:
        """The provenance of the frames, as far as it is known."""

    def frames(self) -> Iterator[SourceFrame]:
        """All frames from the start."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """The frames of a recording."""

    recording: Recording

    simulated: ClassVar[bool] = False

    @property
    def scene(self) -> Scene:
        """The recorded scene."""
        return self.recording.scene

    @property
    def fps(self) -> float:
        """Frames per second of simulated time."""
        return self.recording.fps

    @property
    def times(self) -> FloatArray:
        """The times of the frames [s]."""
        return self.recording.times

    @property
    def count(self) -> int:
        """The number of frames."""
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
        """Whether this is a whole recording, not only positions."""
        return hasattr(self.recording, "energy") and hasattr(self.recording, "plan")

    def has(self, field: str) -> bool:
        """Whether a field was recorded."""
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
    """A scene that is simulated from its start at each iteration, one frame at a time, with the same bits each time."""

    audited = True
    """True: frames of a simulation have energies."""
    simulated = True

    def __init__(self, scene: Scene, duration: float, fps: float, numerics: Options) -> None:
        self.scene = scene
        self.duration = duration
        self.fps = fps
        self.numerics = numerics
        self._provenance: ProvenanceRecord | None = None

    @property
    def count(self) -> int:
        """The number of frames."""
        return frame_count(self.duration, self.fps, self.scene.units)

    @property
    def times(self) -> FloatArray:
        """The times of the frames [s]."""
        times: FloatArray = np.arange(self.count) / self.fps
        return times

    @property
    def integrator(self) -> str:
        """The integrator's name."""
        return type(check(self.numerics, self.scene).integrator).__name__

    def has(self, field: str) -> bool:
        """Whether the scene has a field of this name."""
        return field in self.scene.fields

    def frames(self) -> Iterator[SourceFrame]:
        """Simulate from the start.

        Raises:
            InternalError: the bits differ from those of the previous simulation.
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
            code = next((type(item).__name__ for item in items if Record.of(item).code), None)
            cause = "please report it" if code is None else f"its {code} gives other values for the same arguments"
            raise InternalError(f"the scene did not repeat itself when it was simulated again: {cause}")
        self._provenance = found

    @property
    def provenance(self) -> ProvenanceRecord:
        """The provenance; this runs the simulation to its end if necessary."""
        if self._provenance is None:
            for _ in self.frames():
                pass
        assert self._provenance is not None
        return self._provenance


def sources(source: object, duration: float | None, fps: float | None, numerics: Options) -> list[Source]:
    """One source for each panel.

    Raises:
        SceneError: a value is neither a recording nor a scene, an argument is out of range, or the rates differ.
        TypeError: a keyword is not a numerical option.
    """
    require_options(numerics, "film")
    items = list(source) if isinstance(source, (list, tuple)) else [source]
    if not items:
        raise SceneError("recording: there must be at least one")
    found = [_source(item, duration, fps, numerics) for item in items]
    rates = sorted({each.fps for each in found})
    if len({each.scene.units for each in found}) > 1:
        raise SceneError("recording: panels must have the same units; give their scenes the same units=")
    if len(rates) > 1:
        raise SceneError(f"recording: panels must have the same frames per second, got {rates}")
    return found


def _source(item: object, duration: float | None, fps: float | None, numerics: Options) -> Source:
    if isinstance(item, Scene):
        if duration is None:
            asked = item.units.label("duration=…", "s")
            raise SceneError(f"duration: a scene is shown while it is simulated, so say how long: {asked}")
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
