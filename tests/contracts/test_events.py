"""Events of every system, with every method: the run does not change, and goes on from an event."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import physcore as pc
from contracts.rigid import material
from contracts.scenes import SCENES, STEPS
from contracts.transforms import Array
from physcore.scene.points import PointSystem


def values(state: pc.Simulation | pc.Snapshot) -> Array:
    """All positions; without bodies, those of all tracers, or the first field of the system. One number each."""
    scene = state.scene
    if scene.has_rigid_bodies:
        return material(state)[0].ravel()
    if scene.bodies:
        return state.positions.ravel()
    if isinstance(scene.systems[0], PointSystem):
        return np.concatenate([state[system].positions.ravel() for system in scene.systems])
    (system,) = scene.systems
    if isinstance(system, pc.Schrodinger):
        return state[system].wave_function.real.ravel()
    return state[system][next(iter(system.shapes()))].ravel()


@cache
def plain(name: str) -> tuple[pc.Simulation, int, float]:
    """A run to its end, the entry of the state that changes most, and the mean of its first and its last value."""
    run = SCENES[name].simulation()
    before = values(run)
    run.run(STEPS * SCENES[name].dt)
    after = values(run)
    entry = int(np.argmax(np.abs(after - before)))
    return run, entry, float(0.5 * (before[entry] + after[entry]))


@pytest.mark.parametrize("name", SCENES)
def test_watching_changes_no_bit_and_finds_what_passes(name):
    """A value with opposite signs at the start and at the end of a run changes its sign an odd number of times."""
    case, (expected, entry, level) = SCENES[name], plain(name)
    event = pc.Event(lambda state: values(state)[entry] - level)
    watched = case.simulation()
    watched.run(STEPS * case.dt, events=[event])
    assert watched.state_hash() == expected.state_hash()
    assert watched.provenance == expected.provenance
    found = watched.events[event]
    assert len(found) % 2 == 1
    assert ((found.times > 0.0) & (found.times <= watched.time)).all()
    assert (np.diff(found.times) > 0.0).all()


@pytest.mark.parametrize("name", SCENES)
def test_a_run_ends_at_a_terminal_event_and_goes_on_from_there(name):
    case, (_, entry, level) = SCENES[name], plain(name)
    event = pc.Event(lambda state: values(state)[entry] - level, terminal=True)
    run = case.simulation()
    before = values(run)[entry] - level
    run.run(STEPS * case.dt, events=[event])
    (time,) = run.events[event].times
    interpolated = bool(run.scene.constraints) or not run.integrator.continuous
    assert time < run.time if interpolated else time == run.time
    assert before * (values(run)[entry] - level) <= 0.0
    run.run(case.dt, events=[event])
    assert not any(run.events[event].times <= time)
