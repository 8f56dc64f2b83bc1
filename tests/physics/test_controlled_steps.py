"""Steps that follow the estimate of their error: it follows the tolerance, and what is rejected leaves no trace."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array

PAIR = pc.BogackiShampine3()


def pendulum() -> pc.Scene:
    """A swing on a spring through air, which comes to rest."""
    swing = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 50.0, damping=0.5, fixed=[0])
    return pc.Scene(swing, pc.Gravity((0.0, -9.81)), pc.Drag(linear=0.2, quadratic=0.1))


def comet() -> pc.Scene:
    """A fall past a center, through air."""
    body = pc.Particles([[1.9, 0.0]], [[0.0, 0.25]])
    return pc.Scene(body, pc.CentralForce((0.0, 0.0), 1.0), pc.Drag(linear=0.05))


def folded() -> pc.Scene:
    well = pc.CentralForce((0.1, 0.0), 4.0, exponent=1.0)
    return pc.Scene(pc.Particles([[1.0, 0.0], [0.0, 1.3]], [[0.1, 0.9], [-0.8, 0.2]]), well, pc.Drag(0.4))


SCENES = {"pendulum": pendulum, "comet": comet, "folded": folded}


def state(run: pc.Simulation) -> Array:
    return np.stack([run.positions, run.velocities])


def controlled(scene: str, tolerance: float, **numerics) -> pc.Simulation:
    return pc.Simulation(SCENES[scene](), PAIR, pc.AdaptiveStep(tolerance=tolerance), **numerics)


@pytest.mark.parametrize("scene", SCENES)
def test_the_error_is_proportional_to_the_tolerance(scene, record_property):
    """The estimate shrinks like h³, so the tolerance sets h³. The result is of order 3: its error, after a given time,
    shrinks like h³ as well. Over four decades a line through the logarithms has the slope 1; single points scatter,
    since the steps end where the interval ends and errors of either sign may cancel: 0.1 is 0.4 of four decades.
    """
    exact = pc.Simulation(SCENES[scene](), pc.RungeKutta4(), dt=2e-5, threads=1)
    exact.run(3.0)
    tolerances = 10.0 ** -np.arange(4.0, 8.5, 0.5)
    errors = []
    for tolerance in tolerances:
        run = controlled(scene, tolerance, threads=1)
        run.run(3.0)
        errors.append(np.abs(run.positions - exact.positions).max())
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    record_property("slope", f"{slope:.3f}")
    record_property("error over tolerance", f"{np.exp(np.log(np.array(errors) / tolerances).mean()):.2g}")
    assert slope == pytest.approx(1.0, abs=0.1)


def test_the_steps_are_small_where_the_motion_is_fast():
    recording = pc.simulate(comet(), duration=3.0, fps=10.0, integrator=PAIR, dt=pc.AdaptiveStep(tolerance=1e-8))
    (note,) = (note for note in recording.plan.notes if note.startswith("adaptive steps"))
    assert "keep their error within 1e-08 m" in note
    smallest, largest = (float(word) for word in note.split(" from ")[1].replace(",", "").split()[0:4:3])
    assert 5.0 * smallest < largest


@pytest.mark.parametrize("scene", SCENES)
def test_a_rejected_step_leaves_no_trace(scene):
    """An interval that is too long for one step is tried and rejected; what follows are steps like any others."""
    free = controlled(scene, 1e3, threads=1)
    free.run(1.0 / 120.0)
    assert free.steps == 1  # at such a tolerance every step is good enough
    run = controlled(scene, 1e-10, threads=1)
    run.run(1e-2)
    assert "0 tried and taken back" not in run.plan.notes[-1]
    exact = pc.Simulation(SCENES[scene](), pc.RungeKutta4(), dt=1e-5, threads=1)
    exact.run(1e-2)
    # Each step errs by less than the tolerance.
    assert np.abs(run.positions - exact.positions).max() < run.steps * 1e-10
    budget = abs(run.energy().balance - exact.energy().balance)
    assert budget < 1e-6 * abs(exact.energy().kinetic + 1.0)


@pytest.mark.parametrize("scene", SCENES)
def test_the_bits_do_not_depend_on_threads_frames_or_checkpoints(scene, tmp_path: Path):
    runs = [controlled(scene, 1e-6, threads=threads) for threads in (1, 2, 3)]
    for run in runs:
        for _ in range(20):
            run.run(0.05)
    recorded = controlled(scene, 1e-6)
    recorded.record(1.0, fps=20.0)
    resumed = controlled(scene, 1e-6)
    for _ in range(7):
        resumed.run(0.05)
    resumed.save(tmp_path / "half.npz")
    loaded = pc.load(tmp_path / "half.npz")
    assert isinstance(loaded, pc.Simulation)
    for _ in range(13):
        loaded.run(0.05)
    assert len({run.state_hash() for run in (*runs, recorded, loaded)}) == 1
    assert loaded.time == pytest.approx(1.0, rel=1e-14)


def test_the_budget_closes():
    """What drag takes is integrated with the same stages: to the accuracy of the steps."""
    recording = pc.simulate(pendulum(), duration=3.0, fps=20.0, integrator=PAIR, dt=pc.AdaptiveStep(tolerance=1e-9))
    assert np.abs(recording.energy.drift).max() < 1e-5
    assert recording.energy.dissipated[-1] > 0.1


def test_a_pair_runs_with_steps_of_a_given_length_too():
    run = pc.Simulation(pendulum(), PAIR, dt=1e-3)
    run.step(100)
    assert (run.steps, run.dt) == (100, 1e-3)
    run = pc.Simulation(pendulum(), PAIR, dt=pc.AdaptiveStep())
    run.run(0.1)
    assert run.time == pytest.approx(0.1, rel=1e-14)
