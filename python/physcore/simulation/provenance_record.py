"""Provenance records, which films contain, so that the result can be verified and reproduced."""

from __future__ import annotations

import math
from dataclasses import asdict

import numpy as np

from physcore.errors import FileError
from physcore.scene.scene import Scene
from physcore.simulation.plan import Plan
from physcore.simulation.provenance import Provenance
from physcore.simulation.recording import Recording
from physcore.storage.archive import Tree

ProvenanceRecord = dict[str, Tree]
"""Provenance as plain values by name; unknown values are None.

    physcore        the version of physcore
    scene           `Scene.hash()`; None with a CustomForce, whose code has no hash
    units           units of the scene with their values [SI]; not there with the SI
    numerics        integrator, dt, precision, max_energy_growth, on_divergence, with their parameters
    segments        the history of steps: start [s], steps, dt [s] (for adaptive steps the smallest and the largest)
    substeps        steps that failed and were repeated in parts
    duration, fps   duration shown [s], and frames per second of it
    energy_drift    the largest |drift| of the energy balance
    momentum        total momentum at the first and at the last frame [kg·m/s]
    state           `Simulation.state_hash()` at the end
    seed            None: physcore uses no random numbers, and those of the user are in the scene
    machine         threads and vector instructions, on which the bits do not depend
"""


def provenance_record(recording: Recording) -> ProvenanceRecord:
    """The provenance of a recording, or of a similar object as far as it has the data."""
    energy, momentum = getattr(recording, "energy", None), getattr(recording, "momentum", None)
    return record_of(
        recording.scene,
        getattr(recording, "plan", None),
        getattr(recording, "provenance", None),
        duration=float(recording.times[-1] - recording.times[0]),
        fps=float(recording.fps),
        energy_drift=None if energy is None else float(np.abs(energy.drift).max()),
        momentum=None if momentum is None else [momentum[0].tolist(), momentum[-1].tolist()],
    )


def record_of(scene: Scene, plan: Plan | None, provenance: Provenance | None, **measured: Tree) -> ProvenanceRecord:
    """The provenance of a run, with the quantities measured from it."""
    numerics = {} if provenance is None else provenance.numerics
    segments = None if provenance is None else provenance.segments
    return {
        "physcore": None if provenance is None else provenance.version,
        "scene": _scene_hash(scene),
        **({} if scene.units.is_si else {"units": asdict(scene.units)}),
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
    """A value with None in place of numbers that JSON cannot represent."""
    if isinstance(value, list):
        return [_known(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
