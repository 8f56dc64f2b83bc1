"""The evidence of a run: what a film or a file says of what it shows, so that anybody can check it or do it again."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict

import numpy as np

from physcore.checks import FloatArray
from physcore.errors import FileError, InternalError
from physcore.forces import CustomForce
from physcore.numerics.choices import Options
from physcore.scene.scene import Scene
from physcore.simulation.energy import Energy
from physcore.simulation.frames import frame_count
from physcore.simulation.plan import Plan
from physcore.simulation.provenance import Provenance
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation
from physcore.simulation.state import Frame
from physcore.storage.archive import Tree

Evidence = dict[str, Tree]
"""Plain values by name; what is not known is None.

    physcore        the version that computed it
    scene           `Scene.hash()`; None with a CustomForce, whose code has none
    numerics        integrator, dt, precision, runaway, on_divergence, with their parameters
    segments        the clock's history: start [s], steps, dt [s] (of adaptive steps the smallest and the largest)
    substeps        steps that failed and were taken again in parts
    duration, fps   seconds that are shown, and frames in a second of them
    energy_drift    the largest |drift| of the energy balance
    momentum        total momentum at the first and at the last frame [kg·m/s]
    state           `Simulation.state_hash()` at the end
    seed            None: physcore draws no random numbers, and those of the user are in the scene
    machine         threads and vector instructions, on which no bit depends
"""


class Run:
    """A scene that is simulated from its start as often as it is looked at, one frame at a time, with the same bits."""

    def __init__(self, scene: Scene, duration: float, fps: float, numerics: Options) -> None:
        self.scene = scene
        self.duration = duration
        self.fps = fps
        self.numerics = numerics
        self._evidence: Evidence | None = None

    @property
    def count(self) -> int:
        """How many frames there are."""
        return frame_count(self.duration, self.fps)

    def frames(self) -> Iterator[Frame]:
        """Simulate from the start.

        Raises:
            InternalError: the bits were not those of the last time.
        """
        simulation, drift, first = Simulation(self.scene, **self.numerics), Drift(), None
        for frame in simulation.frames(self.duration, self.fps):
            first, last = first or frame, frame
            drift.add(frame.energy)
            yield frame
        assert first is not None
        found = _evidence(
            self.scene,
            simulation.plan,
            simulation.provenance,
            duration=last.time - first.time,
            fps=self.fps,
            energy_drift=drift.largest,
            momentum=[first.momentum.tolist(), last.momentum.tolist()],
        )
        if self._evidence not in (None, found):
            custom = any(isinstance(force, CustomForce) for force in self.scene.forces)
            cause = "its CustomForce gives other values for the same arguments" if custom else "please report it"
            raise InternalError(f"the scene did not repeat itself when it was simulated again: {cause}")
        self._evidence = found

    @property
    def evidence(self) -> Evidence:
        """What it did; it is run to its end if it was not."""
        if self._evidence is None:
            for _ in self.frames():
                pass
        assert self._evidence is not None
        return self._evidence


class Drift:
    """The drift of an energy balance, as `EnergySeries.drift` counts it, from one budget at a time."""

    def __init__(self) -> None:
        self._seen: list[FloatArray] = []
        """Of balance, kinetic, potential and internal energy [J]: the first, the smallest and the largest values."""

    def add(self, energy: Energy) -> float:
        """Look at one budget, and give its drift by all that was seen so far."""
        values = np.array([energy.balance, energy.kinetic, energy.potential, energy.internal])
        first, lower, upper = self._seen or [values] * 3
        self._seen = [first, np.minimum(lower, values), np.maximum(upper, values)]
        return self._relative(abs(energy.balance - first[0]))

    @property
    def largest(self) -> float:
        """The largest one of all."""
        first, lower, upper = self._seen
        return self._relative(max(upper[0] - first[0], first[0] - lower[0]))

    def _relative(self, change: float) -> float:
        """A change in units of the energy that has been in motion."""
        _, lower, upper = self._seen
        _, _, potential, internal = upper - lower
        scale = upper[1] + potential + internal
        return float(change / scale if scale > 0 else change)


def evidence(recording: Recording) -> Evidence:
    """What a recording has to say; also of what only looks like one, as far as that goes."""
    energy, momentum = getattr(recording, "energy", None), getattr(recording, "momentum", None)
    return _evidence(
        recording.scene,
        getattr(recording, "plan", None),
        getattr(recording, "provenance", None),
        duration=float(recording.times[-1] - recording.times[0]),
        fps=float(recording.fps),
        energy_drift=None if energy is None else float(np.abs(energy.drift).max()),
        momentum=None if momentum is None else [momentum[0].tolist(), momentum[-1].tolist()],
    )


def _evidence(scene: Scene, plan: Plan | None, provenance: Provenance | None, **measured: Tree) -> Evidence:
    """All of it together."""
    numerics = {} if provenance is None else provenance.numerics
    segments = None if provenance is None else provenance.segments
    return {
        "physcore": None if provenance is None else provenance.version,
        "scene": _scene_hash(scene),
        "numerics": {name: value for name, value in numerics.items() if name != "threads"} or None,
        "segments": None if segments is None else [asdict(segment) for segment in segments],
        "substeps": None if plan is None else plan.substeps,
        **{name: _known(value) for name, value in measured.items()},
        "state": None if provenance is None else provenance.state_hash,
        "seed": None,
        "machine": None if plan is None else {"threads": plan.threads, "simd": plan.simd},
    }


def _scene_hash(scene: Scene) -> str | None:
    try:
        return scene.hash()
    except FileError:
        return None


def _known(value: Tree) -> Tree:
    """The same, with None for numbers that JSON does not have."""
    if isinstance(value, list):
        return [_known(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
