"""Where the frames of a film come from: a recording, or a simulation that runs while it is filmed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from physcore import memory
from physcore.checks import FloatArray, shown, span
from physcore.errors import SceneError
from physcore.numerics.choices import FRAMES_PER_SECOND, Options, check
from physcore.scene.scene import Scene
from physcore.simulation.energy import Energy, EnergySeries
from physcore.simulation.evidence import Evidence, Run, evidence
from physcore.simulation.recording import Recording


@dataclass(frozen=True, eq=False)
class Moment:
    """What there is to draw at one time."""

    time: float
    """[s]"""
    positions: FloatArray
    """[m], shape (N, D)."""
    more: Mapping[str, FloatArray]
    """Velocities [m/s], densities [kg/m³] and pressures [Pa] by name, as far as they were recorded."""
    energy: Energy | None = None
    """The energy budget, where it is known."""
    dt: float | None = None
    """The time step [s], likewise."""

    def channel(self, name: str) -> FloatArray:
        """One of them, or the positions."""
        return self.positions if name == "positions" else self.more[name]


class Source(Protocol):
    """Something that can be looked at from the start as often as needed."""

    @property
    def scene(self) -> Scene:
        """What is shown."""

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
        """Whether moments have energies and time steps."""

    def has(self, channel: str) -> bool:
        """Whether moments have velocities, densities or pressures."""

    @property
    def evidence(self) -> Evidence:
        """What is known of how it came about."""

    def moments(self) -> Iterator[Moment]:
        """All moments from the start."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """The frames of a recording."""

    recording: Recording

    @property
    def scene(self) -> Scene:
        """What was recorded."""
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
    def evidence(self) -> Evidence:
        """What the recording says of how it came about."""
        return evidence(self.recording)

    @property
    def integrator(self) -> str | None:
        """The integrator's name."""
        return self.recording.plan.integrator if self.audited else None

    @property
    def audited(self) -> bool:
        """Whether it is a whole recording, and not only positions."""
        return hasattr(self.recording, "energy") and hasattr(self.recording, "plan")

    def has(self, channel: str) -> bool:
        """Whether something was recorded."""
        return channel in self.recording.channels

    def moments(self) -> Iterator[Moment]:
        """The frames in order."""
        positions, channels = self.recording.positions, self.recording.channels
        dt = self.recording.plan.dt if self.audited else None
        for index, time in enumerate(self.recording.times):
            more: dict[str, FloatArray] = {
                name: values[index] for name, values in channels.items() if name != "positions"
            }
            energy = _budget(self.recording.energy, index) if self.audited else None
            yield Moment(float(time), positions[index], more, energy, dt)


class Running(Run):
    """A simulation that is run anew for each pass."""

    @property
    def times(self) -> FloatArray:
        """When the frames are [s]."""
        times: FloatArray = np.arange(self.count) / self.fps
        return times

    @property
    def integrator(self) -> str:
        """The integrator's name."""
        return type(check(self.numerics, self.scene).integrator).__name__

    @property
    def audited(self) -> bool:
        """A simulation knows its energy."""
        return True

    def has(self, channel: str) -> bool:
        """A simulation has all that there is."""
        return channel in ("positions", "velocities") or bool(self.scene.fluids)

    def moments(self) -> Iterator[Moment]:
        """Simulate from the start."""
        for frame in self.frames():
            more = {"velocities": frame.velocities, **frame.fields}
            yield Moment(frame.time, frame.positions, more, frame.energy, frame.dt)


def _budget(series: EnergySeries, index: int) -> Energy:
    """The energy budget at one frame of a recording."""
    return Energy(
        kinetic=float(series.kinetic[index]),
        by_term={name: float(values[index]) for name, values in series.by_term.items()},
        internal=float(series.internal[index]),
        dissipated=float(series.dissipated[index]),
        dissipated_by={name: float(values[index]) for name, values in series.dissipated_by.items()},
        work=float(series.work[index]),
        time=float(series.times[index]),
    )


def sources(source: object, duration: float | None, fps: float | None, numerics: Options) -> list[Source]:
    """One source for each panel.

    Raises:
        SceneError: something is neither a recording nor a scene, an argument is out of range, or the rates differ.
        TypeError: a keyword is no numerical choice.
    """
    for name in numerics:
        if name not in Options.__annotations__:
            raise TypeError(f"got an unexpected keyword argument {name!r}")
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
