"""Looking at a run does not change it: the bits are the same however it is asked for, audited, recorded or filmed."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from contracts.comparison import plain, state
from contracts.rigid import centers, material
from contracts.scenes import SCENES, STEPS, Case
from physcore.film import provenance
from physcore.scene.points import PointSystem

FIXED = {name: case for name, case in SCENES.items() if not case.adaptive}
FRAMES = 7
"""Frames of a recording: with `rate` most fall between two steps, and those at a third and two thirds on one."""


def rate(case: Case) -> float:
    """Frames per second, so that the last of `FRAMES` is the last step's."""
    return (FRAMES - 1) / case.duration


def recorded_state(recording: pc.Recording) -> tuple[np.ndarray, np.ndarray]:
    """What `state` gives, over time."""
    if recording.scene.systems and isinstance(recording.scene.systems[0], pc.Schrodinger):
        waves = recording[recording.scene.systems[0]].wave_function
        return waves.real, waves.imag
    if recording.scene.has_rigid_bodies:
        return material(recording)
    if recording.scene.bodies:
        return recording.positions, recording.velocities
    if isinstance(recording.scene.systems[0], PointSystem):
        parts = [recording[system] for system in recording.scene.systems]
        return tuple(np.concatenate([part[name] for part in parts], axis=1) for name in ("positions", "velocities"))
    (system,) = recording.scene.systems
    first, second = (recording[system][name] for name in system.shapes())
    return first, second


def budget(run: pc.Simulation) -> dict[str, object]:
    return vars(run.energy())


@pytest.mark.parametrize("name", FIXED)
def test_steps_may_be_asked_for_one_by_one_with_an_audit_after_each(name):
    case, whole = FIXED[name], plain(name)
    single = case.simulation()
    for _ in range(STEPS):
        single.step()
        single.energy()
        single.momentum()
    _ = single.plan, single.positions
    assert single.state_hash() == whole.state_hash()
    assert budget(single) == budget(whole)
    assert single.provenance == whole.provenance


@pytest.mark.parametrize("name", SCENES)
def test_a_recording_changes_no_bit_and_its_frames_fall_at_their_times(name):
    """Where steps follow the motion, a recording is a run to each of its frames."""
    case = SCENES[name]
    recorded = case.simulation()
    recording = recorded.record(case.duration, rate(case))
    run = case.simulation() if case.adaptive else plain(name)
    if case.adaptive:
        for _ in range(FRAMES - 1):
            run.run(1.0 / rate(case))
    assert recorded.state_hash() == run.state_hash() == recording.provenance.state_hash
    assert budget(recorded) == budget(run)
    assert len(recording) == FRAMES
    np.testing.assert_array_equal(recording.times, np.arange(FRAMES) / rate(case))
    for values, present in zip(recorded_state(recording), state(run), strict=True):
        np.testing.assert_array_equal(values[-1], present)
    assert recording.energy.total[-1] == run.energy().total


@pytest.mark.parametrize("name", FIXED)
def test_a_frame_between_two_steps_lies_on_the_cubic_through_them(name):
    """At the middle of a step: x = (x₀ + x₁)/2 + dt (v₀ − v₁)/8; in a periodic domain up to whole periods. Of rigid
    bodies the centers do; what turns with them is on a circle.
    """
    case = FIXED[name]
    run = case.simulation()
    run.step(STEPS // 2)
    other = case.simulation()
    other.step(STEPS // 2)
    frames = run.record(1.5 * case.dt, 2.0 / case.dt)
    before = state(other)
    other.step()
    after = state(other)
    if run.scene.periodic is not None:
        after = (before[0] + run.scene.periodic.nearest(after[0] - before[0]), after[1])
    # Without a rate, on the line.
    has_rate = bool(run.scene.bodies) or not {"rate", "velocities"}.isdisjoint(run[run.scene.systems[0]].fields)
    middle = (before[0] + after[0]) / 2.0 + has_rate * case.dt * (before[1] - after[1]) / 8.0
    if run.scene.periodic is not None:
        middle = run.scene.periodic.wrap(middle)
    scale = np.abs(middle).max() + np.abs(before[1]).max() * case.dt
    found = recorded_state(frames)[0][1]
    if run.scene.has_rigid_bodies:
        found, middle = found[centers(run.scene)], middle[centers(run.scene)]
    np.testing.assert_allclose(found, middle, rtol=0.0, atol=8.0 * np.finfo(float).eps * scale)


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@pytest.mark.filterwarnings("ignore:each frame of this film lasts:physcore.SceneWarning")
@pytest.mark.parametrize("name", SCENES)
def test_a_film_shows_the_same_run(name, tmp_path):
    """It says in which state it ended: that of a run, or where steps follow the motion, of a run to its frames."""
    case = SCENES[name]
    numerics = {"dt": case.dt, **case.numerics}
    scene = case.shared
    path = tmp_path / "film.gif"
    pc.film(scene, path, duration=case.duration, fps=2.0 / case.duration, size=(48, 32), **numerics)
    run = case.simulation(scene) if case.adaptive else plain(name)
    if case.adaptive:
        run.record(case.duration, 2.0 / case.duration)
    (panel,) = provenance(path)
    assert panel["state"] == run.state_hash()
