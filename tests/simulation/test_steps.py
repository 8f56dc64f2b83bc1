"""Steps: how many there are, how long they are, and what is said about steps that are too long."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import physcore as pc
from physcore.integrators import INTEGRATORS
from physcore.numerics.choices import Limit, largest_step
from physcore.simulation import engine

FALLING = pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Gravity((0.0, -9.81)))


def spring(stiffness: float = 100.0) -> pc.Scene:
    """Two unit masses on a spring: ω² = 2k/m, so Verlet's limit is 2/ω = √(2m/k)."""
    return pc.Scene(pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], stiffness))


def test_step_takes_equal_steps():
    simulation = pc.Simulation(FALLING, dt=1e-3)
    simulation.step()
    simulation.step(499)
    assert simulation.steps == 500
    assert simulation.time == 500 * 1e-3  # start + n · dt, one product: no sum of roundings
    assert simulation.dt == 1e-3


@pytest.mark.parametrize(("duration", "steps"), [(1.0, 10), (0.95, 10), (0.3, 3), (0.1 + 1e-9, 1), (0.0, 0)])
def test_run_takes_the_steps_that_reach_the_duration_and_keeps_dt(duration, steps):
    simulation = pc.Simulation(FALLING, dt=0.1)
    simulation.run(duration)
    assert (simulation.steps, simulation.dt) == (steps, 0.1)


def test_auto_ends_a_run_exactly_at_the_duration():
    scene = spring()
    limit = pc.stability_limit(scene, pc.VelocityVerlet())
    simulation = pc.Simulation(scene, dt=pc.AutoStep())
    simulation.run(1.0)
    assert simulation.time == pytest.approx(1.0, rel=1e-15)
    assert simulation.steps == math.ceil(1.0 / (pc.AutoStep().safety * limit))
    assert simulation.dt == 1.0 / simulation.steps


def test_the_limit_of_one_spring_is_that_of_the_oscillator():
    # Gram bound: d_i = k at both ends, ω² ≤ k/m + k/m, which is exact for one spring.
    assert pc.stability_limit(spring(100.0), pc.VelocityVerlet()) == pytest.approx(math.sqrt(2.0 / 100.0), rel=1e-12)


def test_safety_scales_the_automatic_step():
    scene = spring()
    whole, half = (pc.Simulation(scene, dt=pc.AutoStep(safety=s)).dt for s in (1.0, 0.5))
    assert half == whole / 2


def test_where_nothing_limits_the_step_there_are_four_to_a_frame():
    assert pc.stability_limit(FALLING, pc.VelocityVerlet()) == math.inf
    assert pc.Simulation(FALLING).dt == 1.0 / 120.0
    recording = pc.simulate(FALLING, duration=1.0, fps=10.0)
    assert recording.plan.dt == pytest.approx(1.0 / 40.0, rel=1e-15)


def test_the_plan_names_the_step_its_limit_and_the_term():
    plan = pc.Simulation(spring(), dt=pc.AutoStep()).plan
    assert 0 < plan.dt < plan.dt_limit
    assert plan.margin == plan.dt / plan.dt_limit
    assert "springs" in plan.limit_term
    assert plan.limit_kind == "stability"
    text = str(plan)
    assert "springs" in text
    assert "50% of the stability limit" in text


def test_a_step_above_the_limit_warns_where_the_user_wrote_it():
    scene = spring()
    limit = pc.stability_limit(scene, pc.VelocityVerlet())
    pc.Simulation(scene, dt=0.99 * limit)
    with pytest.warns(pc.StabilityWarning, match="above the limit of stability of VelocityVerlet") as caught:
        pc.Simulation(scene, dt=1.01 * limit)
    assert caught[0].filename == __file__
    with pytest.warns(pc.StabilityWarning) as caught:
        pc.simulate(scene, duration=0.0, dt=1.01 * limit)
    assert caught[0].filename == __file__


def test_the_warning_says_will_where_the_limit_is_known_and_may_where_it_is_not():
    """RungeKutta4 at ξ = 1 bears ω dt = 2.785. In a well with drag that is known; a damped rope has modes of all
    damping ratios up to that of the fastest, and the limit is that of the worst that could be among them.
    """
    well = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0), pc.Drag(2.0))
    assert pc.stability_limit(well, pc.RungeKutta4()) == pytest.approx(2.785293563405282, rel=1e-6)
    pc.Simulation(well, pc.RungeKutta4(), dt=2.78)
    with pytest.warns(pc.StabilityWarning, match=r"above the limit of stability of RungeKutta4 .*: .* will blow up"):
        pc.Simulation(well, pc.RungeKutta4(), dt=2.79)
    rope = pc.Scene(pc.rope(5, 1.0, 100.0, damping=10.0))
    limit = pc.stability_limit(rope, pc.RungeKutta4())
    may = r"is certain for RungeKutta4 .*may blow up; .*up to (\S+) times as large.*measured=True"
    with pytest.warns(pc.StabilityWarning, match=may) as caught:
        pc.Simulation(rope, pc.RungeKutta4(), dt=1.01 * limit)
    factor = float(re.search(may, str(caught[0].message))[1])
    measured = pc.stability_limit(rope, pc.RungeKutta4(), measured=True)
    assert 0.0 < measured.margin < factor - 1.0
    with pytest.warns(pc.StabilityWarning, match="will blow up"):
        pc.Simulation(rope, pc.RungeKutta4(), dt=1.01 * factor * limit)


def test_the_limit_is_looked_for_where_it_is_needed_and_once(monkeypatch, tmp_path):
    """The sharp one, which takes as long as many steps: not where a step is certified, and not for what goes on."""
    looks = []
    find = engine.limit
    monkeypatch.setattr(engine, "limit", lambda world: looks.append(world) or find(world))

    def looked(make):
        looks.clear()
        made = make()
        return made, len(looks)

    scene = pc.Scene(pc.cloth((6, 6), 0.1, 100.0, bend_stiffness=0.0))
    limit = pc.stability_limit(scene, pc.VelocityVerlet())
    with pytest.warns(pc.StabilityWarning):
        above, found = looked(lambda: pc.Simulation(scene, dt=1.1 * limit))
    assert found == 1
    auto, found = looked(lambda: pc.Simulation(scene))
    assert found == 1
    given, found = looked(lambda: pc.Simulation(scene, dt=0.2 * limit))
    assert found == 0
    for simulation in (above, auto, given):
        simulation.save(tmp_path / "half")
        assert looked(lambda: pc.load(tmp_path / "half"))[1] == 0
        assert looked(simulation.__copy__)[1] == 0
    assert given.plan.dt_limit == above.plan.dt_limit == limit


def test_the_certified_limit_is_remembered_while_no_spring_is_shorter_than_half():
    """Where one is, it is that of a simulation that starts there; and when it is gone, what it was."""
    scene = pc.Scene(pc.rope(4, 1.0, 100.0))
    run = pc.Simulation(scene)
    start, world = run.positions, run._world
    first = world.certified()
    pressed = start * np.array([0.2, 1.0])
    run.set(positions=pressed)
    found = world.certified()
    fresh = pc.Simulation(scene)
    fresh.set(positions=pressed)
    assert found == fresh._world.certified() < 0.9 * first
    run.set(positions=1.3 * start)
    assert world.certified() == first


def test_explicit_euler_warns_once_and_has_no_automatic_step():
    scene = spring()
    assert pc.stability_limit(scene, pc.ExplicitEuler()) == 0.0
    with pytest.raises(pc.SceneError, match=r"dt: no time step is stable with ExplicitEuler .* SemiImplicitEuler"):
        pc.Simulation(scene, pc.ExplicitEuler())
    with pytest.warns(pc.StabilityWarning, match="not stable at any time step") as caught:
        pc.Simulation(scene, pc.ExplicitEuler(), dt=1e-3).step(10)
    assert len(caught) == 1


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ({"dt": 0.0}, "dt: must be > 0, got 0"),
        ({"dt": -1e-3}, "dt: must be > 0"),
        ({"dt": math.nan}, "dt: must be finite"),
        ({"dt": math.inf}, "dt: must be finite"),
        ({"dt": "fast"}, "dt: must be a number of seconds, 'auto', AutoStep"),
        ({"dt": None}, "dt: must be a number"),
        ({"integrator": pc.PEFRL}, r"integrator: .*write PEFRL\(\)"),
        ({"integrator": "rk4"}, "integrator: must be one of ExplicitEuler"),
        ({"precision": "f16"}, "precision: must be 'f32', 'f64' or 'auto', got 'f16'"),
        ({"threads": 0}, "threads: must be ≥ 1, got 0"),
        ({"threads": 1.5}, "threads: must be a whole number"),
        ({"threads": 10**6}, "threads: must be ≤ 1024"),
        ({"max_energy_growth": 0.0}, "max_energy_growth: must be > 0"),
        ({"on_divergence": "stop"}, "on_divergence: must be 'raise', 'substep' or 'ignore'"),
    ],
)
def test_bad_numerics_are_refused_by_name(choice, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.Simulation(FALLING, **choice)


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (lambda simulation: simulation.step(-1), "step.n: must be ≥ 0, got -1"),
        (lambda simulation: simulation.step(1.0), "step.n: must be a whole number"),
        (lambda simulation: simulation.run(-1.0), "run.duration: must be ≥ 0"),
        (lambda simulation: simulation.step(10**30), "step.n: must be ≤ "),
        (lambda simulation: simulation.run(math.inf), "run.duration: must be finite"),
        (lambda simulation: simulation.run(1e99), "duration: 1e.99 s are .* steps of .* more than can be counted"),
        (lambda simulation: simulation.record(1e99, fps=1e99), "duration: .* more frames than can be counted"),
        (lambda simulation: simulation.record(1.0, fps=0.0), "fps: must be > 0"),
        (lambda simulation: simulation.record(-1.0), "duration: must be ≥ 0"),
        (lambda simulation: simulation.record(1.0, channels="positions"), r'channels: .*write \("positions",\)'),
        (lambda simulation: simulation.record(1.0, channels=("forces",)), "channels: must be a tuple"),
        (lambda simulation: simulation.set(positions=[1.0, 2.0, 3.0]), "set.positions: must broadcast"),
        (lambda simulation: simulation.set(velocities=math.nan), "set.velocities: must be finite"),
    ],
)
def test_bad_arguments_are_refused_by_name(act, message):
    with pytest.raises(pc.SceneError, match=message):
        act(pc.Simulation(FALLING))


@pytest.mark.parametrize("act", [pc.Simulation, lambda scene: pc.stability_limit(scene, pc.VelocityVerlet())])
def test_a_scene_is_asked_for(act):
    with pytest.raises(pc.SceneError, match=r"scene: must be a Scene, .*write Scene\(Particles\(…\), …\)"):
        act(FALLING.bodies[0])


def test_safety_is_a_fraction():
    for safety in (0.0, 1.1, -1.0):
        with pytest.raises(pc.SceneError, match=r"AutoStep\.safety: must be"):
            pc.AutoStep(safety)


@pytest.mark.parametrize("kind", [kind for kind in INTEGRATORS if kind.advances("Wave")])
def test_no_hint_advises_the_integrator_that_is_used(kind):
    nowhere = Limit(0.0, "stability", "springs", 0.0, math.inf, 0.0)
    with pytest.raises(pc.SceneError, match=r"no time step is .*stable") as caught:
        largest_step(nowhere, pc.AutoStep(), kind(), 30.0)
    assert f"use {kind.__name__}()" not in str(caught.value)
    assert f"or {kind.__name__}()" not in str(caught.value)


def test_a_plan_looks_at_the_limit_once(monkeypatch):
    """The limit of a network takes as long as some hundred steps."""
    simulation = pc.Simulation(pc.Scene(pc.rope(5, 1.0, 100.0, pinned="start"), pc.Gravity()), dt=1e-3)
    looked, limit = [], engine.limit

    def counted(world: object) -> object:
        looked.append(world)
        return limit(world)

    monkeypatch.setattr(engine, "limit", counted)
    assert simulation.plan.notes
    assert len(looked) == 1
