"""Accuracy that was asked for is kept, proved and told; what cannot be had is refused with what can."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import ALL, LONG, name, network

E = 0.6
ORBIT = pc.Scene(
    pc.Particles([[1.0 - E, 0.0]], velocities=[[0.0, math.sqrt((1.0 + E) / (1.0 - E))]]),
    pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0),
)
"""An ellipse around a unit mass, from perihelion; its period is 2π."""


def kepler(times: np.ndarray) -> np.ndarray:
    """Where the planet is, by Kepler's equation M = u − e sin u, solved by Newton's method."""
    u = times.copy()
    for _ in range(50):
        u -= (u - E * np.sin(u) - times) / (1.0 - E * np.cos(u))
    return np.stack([np.cos(u) - E, math.sqrt(1.0 - E * E) * np.sin(u)], axis=1)


@pytest.mark.parametrize("accuracy", [1e-2, 1e-5, 1e-9])
def test_an_orbit_is_as_accurate_as_was_asked_for(accuracy, capsys):
    recording = pc.simulate(ORBIT, 20.0, fps=8.0, accuracy=accuracy)
    off = np.linalg.norm(recording.positions[:, 0] - kepler(recording.times), axis=1).max()
    assert off <= accuracy
    said = capsys.readouterr().out
    assert "keeps within" in said
    assert recording.plan.notes[-1] == said.strip()
    assert len(recording.times) == 161
    run = pc.Simulation(ORBIT, getattr(pc, recording.plan.integrator)(), recording.plan.dt)
    assert np.array_equal(run.record(20.0, 8.0).positions, recording.positions)


@pytest.mark.parametrize("seed", range(30 if LONG else 5))
def test_random_networks_are_as_accurate_as_was_asked_for(seed, record_property):
    """Against steps of a hundredth of the limit, of another family where there is one of high order: 0.03⁴ = 1e-6 of
    the fastest oscillations' 5 % at most.
    """
    generator = np.random.default_rng(seed)
    damping = float(generator.choice([0.0, 0.3]))
    scene = network(seed, dimension=3, count=int(generator.integers(2, 12)), damping=damping).scene()
    wish = 10.0 ** generator.uniform(-7.0, -2.0)
    recording = pc.simulate(scene, 3.0, fps=10.0, accuracy=wish)
    chosen = recording.plan.integrator
    other = pc.BlanesMoan6() if chosen == "RungeKutta4" and damping == 0.0 else pc.RungeKutta4()
    limit = pc.stability_limit(scene, other)
    truth = pc.simulate(scene, 3.0, fps=10.0, integrator=other, dt=0.1 / math.ceil(0.1 / (0.01 * limit)))
    off = float(np.linalg.norm(recording.positions - truth.positions, axis=2).max())
    record_property("error over what was asked for", off / wish)
    assert off <= wish


@pytest.mark.parametrize("drift", [1e-2, 1e-5, 1e-8])
def test_an_energy_budget_is_kept(drift):
    recording = pc.simulate(ORBIT, 20.0, fps=8.0, energy_drift=drift)
    assert np.abs(recording.energy.drift).max() <= drift


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_an_integrator_that_is_given_is_the_one_that_is_used(integrator):
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
    recording = pc.simulate(scene, 2.0, fps=8.0, accuracy=1e-3, integrator=integrator)
    assert recording.plan.integrator == name(integrator)
    assert np.abs(recording.positions[:, 0, 0] - np.cos(recording.times)).max() <= 1e-3


def test_what_no_number_holds_is_refused_with_the_best_there_is():
    with pytest.raises(pc.AccuracyError, match="no method gets there") as caught:
        pc.simulate(ORBIT, 6.0, fps=4.0, accuracy=1e-18)
    assert 1e-17 < caught.value.error < 1e-11
    copy = pickle.loads(pickle.dumps(caught.value))
    assert (str(copy), copy.error) == (str(caught.value), caught.value.error)


def test_chaos_is_refused():
    step = np.array([math.sin(3.0), -math.cos(3.0)])
    rods = pc.SpringNetwork(np.arange(3.0)[:, None] * step, [[0, 1], [1, 2]], 200.0, fixed=[0])
    with pytest.raises(pc.AccuracyError, match="chaotic"):
        pc.simulate(pc.Scene(rods, pc.Gravity((0.0, -9.81))), 60.0, fps=2.0, accuracy=1e-6)


def test_it_can_be_had_in_single_precision_as_far_as_that_goes():
    assert pc.simulate(ORBIT, 3.0, fps=4.0, accuracy=1e-3, precision="f32").plan.precision == "f32"
    with pytest.raises(pc.AccuracyError):
        pc.simulate(ORBIT, 3.0, fps=4.0, accuracy=1e-10, precision="f32")


def test_a_fluid_keeps_its_energy_budget():
    water = pc.Fluid(pc.block((0.0, 0.0), (0.2, 0.4), 0.05), 0.05, sound_speed=30.0)
    scene = pc.Scene(water, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (0.8, 0.8)))
    recording = pc.simulate(scene, 0.2, fps=20.0, energy_drift=1e-3, channels=("densities",))
    assert recording.plan.integrator in ("VelocityVerlet", "McLachlan2")  # the others do not carry densities
    assert recording.densities.shape == (5, 32)
    assert np.abs(recording.energy.drift).max() <= 1e-3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"accuracy": 0.0}, "accuracy: must be > 0"),
        ({"energy_drift": -1.0}, "energy_drift: must be > 0"),
        ({"accuracy": 1e-3, "dt": 0.1}, "dt: is what accuracy= and energy_drift= choose"),
        ({"accuracy": 1e-3, "fps": 0.1}, "fps: there is no frame but the first"),
        ({"accuracy": 1e-3, "integrator": "best"}, "integrator: must be one of"),
        ({"accuracy": 1e-3, "channels": ("colors",)}, "channels: must be"),
    ],
)
def test_bad_input_is_named(arguments, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.simulate(**{"scene": ORBIT, "duration": 1.0, **arguments})


@pytest.mark.parametrize(
    ("options", "advised", "spared"),
    [
        ({"precision": "f32"}, ['precision="f64"'], ["leave integrator out"]),
        ({"integrator": pc.VelocityVerlet()}, ["leave integrator out"], ["precision="]),
        ({"precision": "f64"}, ["chaotic"], ["precision=", "leave integrator out"]),
    ],
    ids=str,
)
def test_the_hint_of_an_accuracy_that_is_out_of_reach_names_what_is_not_in_use(options, advised, spared):
    well = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
    with pytest.raises(pc.AccuracyError, match="accuracy: no method gets there") as caught:
        pc.simulate(well, 0.5, accuracy=1e-30, **options)
    assert all(hint in str(caught.value) for hint in advised)
    assert not any(hint in str(caught.value) for hint in spared)
    with pytest.raises(pc.AccuracyError, match="energy_drift: no method gets there"):
        pc.simulate(well, 0.5, energy_drift=1e-30, **options)
