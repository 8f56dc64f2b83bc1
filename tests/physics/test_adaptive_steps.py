"""Steps in blocks that suit both of their ends: no drift of the energy, no trace of what was tried, the same bits."""

from __future__ import annotations

import math
import os
import signal

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import EPSILON, LONG, Array, name

ECCENTRICITY = 0.9
PERIOD = 2.0 * math.pi
ADAPTIVE = pc.AdaptiveStep()


def kepler(softening: float = 0.0) -> pc.Scene:
    """A revolution in 2π s around 1 N·m², from the farthest point, 1.9 m away."""
    far, slow = 1.0 + ECCENTRICITY, math.sqrt((1.0 - ECCENTRICITY) / (1.0 + ECCENTRICITY))
    return pc.Scene(pc.Particles([[far, 0.0]], [[0.0, slow]]), pc.CentralForce((0.0, 0.0), 1.0, softening=softening))


def collision() -> pc.Scene:
    """Two atoms that fly at each other, between others: so fast that they halve their limit twice when they meet."""
    positions = [[-3.0, 0.0], [3.0, 0.1], [0.0, 2.5], [0.0, -2.5], [3.0, 2.5]]
    velocities = [[30.0, 0.0], [-30.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.1, 0.2]]
    return pc.Scene(pc.Particles(positions, velocities), pc.LennardJones(epsilon=1.0, sigma=1.0))


def squeeze() -> pc.Scene:
    """Springs of which one is pressed to nothing, where its limit is half of what it was."""
    ends = [[0.0, 0.0], [1.0, 0.01], [2.0, 0.0]]
    chain = pc.SpringNetwork(ends, [[0, 1], [1, 2]], 100.0, velocities=[[12.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    return pc.Scene(chain, pc.Drag(linear=0.1))


SCENES = {"orbit": kepler, "collision": collision, "squeeze": squeeze}


def state(run: pc.Simulation) -> Array:
    return np.stack([run.positions, run.velocities])


def wander(integrator: pc.Integrator, interval: float, revolutions: int) -> Array:
    """The relative error of the energy after each of eight parts of a run."""
    run = pc.Simulation(kepler(), integrator, ADAPTIVE, threads=1)
    first = run.energy().total
    errors = []
    for _ in range(8):
        for _ in range(round(revolutions * PERIOD / interval / 8)):
            run.run(interval)
        errors.append(run.energy().total / first - 1.0)
    return np.array(errors)


@pytest.mark.parametrize("integrator", [pc.VelocityVerlet(), pc.PEFRL()], ids=name)
def test_the_energy_of_an_eccentric_orbit_has_no_drift(integrator, record_property):
    """Sixteen runs whose blocks meet the close approaches at different phases. Each approach kicks the energy at
    random, because it is nowhere quite in the middle of its blocks; a drift would have the same sign in all. The mean
    of their slopes is zero within five standard errors: for t with 15 degrees of freedom, but for 2 in 10,000.
    """
    revolutions = 1000 if LONG else 250
    intervals = PERIOD * (0.5 + np.arange(16) / 16 + math.sqrt(2.0) / 100)
    errors = np.array([wander(integrator, interval, revolutions) for interval in intervals])
    parts = np.arange(1, 9) * revolutions / 8
    slopes = errors @ parts / (parts @ parts)
    mean, noise = slopes.mean(), slopes.std(ddof=1) / math.sqrt(len(slopes))
    record_property("slope", f"{mean:.1e} ± {noise:.1e} per revolution")
    record_property("largest error", f"{np.abs(errors).max():.1e}")
    assert abs(mean) < 5.0 * noise


def test_the_way_back_leads_to_the_start(record_property):
    """The blocks of an interval are the same backwards in time where no step that was tried and taken back stood
    between two sizes: in most of forty runs through a close approach. Those come back to rounding, which grows on the
    way: an orbit's neighbors part like t, steepest at the approach, so a thousand steps of EPSILON make 1e6 EPSILON.
    """
    misses = []
    for phase in np.arange(40) / 40:
        run = pc.Simulation(kepler(), pc.VelocityVerlet(), ADAPTIVE, threads=1)
        run.run(phase)
        start = state(run)
        run.run(PERIOD)
        run.set(velocities=-run.velocities)
        run.run(PERIOD)
        back = state(run) * np.array([1.0, -1.0])[:, None, None]
        misses.append(np.abs(back - start).max())
    back = np.array(misses) < 1e6 * EPSILON
    record_property("came back", f"{back.sum()} of 40, at worst {max(misses):.1e}")
    assert back.sum() > 20


def test_it_beats_equal_steps_at_equal_cost(record_property):
    """At the closest approach, at a tenth of the mean distance, a turn takes 0.1^1.5 = 1/32 of the period. Equal steps
    are as many times too long there, and Verlet's error is of second order.
    """
    adaptive = pc.Simulation(kepler(), dt=ADAPTIVE, threads=1)
    first = adaptive.energy().total
    tried = 0.0
    for _ in range(2000):
        adaptive.run(0.1)
        tried = max(tried, abs(adaptive.energy().total / first - 1.0))
    equal = pc.Simulation(kepler(), dt=adaptive.time / adaptive.steps, threads=1)
    worst = 0.0
    while equal.time < adaptive.time:
        equal.step(20)
        worst = max(worst, abs(equal.energy().total / first - 1.0))
    record_property(
        "largest error of the energy", f"{tried:.1e} with adaptive steps, {worst:.1e} with as many equal ones"
    )
    assert worst > 30.0 * tried


@pytest.mark.parametrize("integrator", [pc.VelocityVerlet(), pc.PEFRL(), pc.RungeKutta4()], ids=name)
@pytest.mark.parametrize("scene", SCENES)
def test_a_step_that_was_taken_back_leaves_no_trace(scene, integrator):
    """Where an interval is tried in one step and then taken in two, it is as if the two had been asked for."""
    found = 0
    for start in np.linspace(0.05, 0.2, 40) if scene == "collision" else np.linspace(0.05, 4.0, 16):
        before = pc.Simulation(SCENES[scene](), integrator, ADAPTIVE, threads=1)
        before.run(float(start))
        limit = before.plan.dt_limit
        for interval in (0.5 * limit, 0.45 * limit):
            run = pc.Simulation(SCENES[scene](), integrator, ADAPTIVE, threads=1)
            run.run(float(start))
            steps = run.steps
            taken_back = int(run.plan.notes[-1].split(", ")[-1].split()[0])
            run.run(interval)
            tried = int(run.plan.notes[-1].split(", ")[-1].split()[0]) - taken_back
            if tried != 1 or run.steps - steps != 2:
                continue
            found += 1
            other = pc.Simulation(SCENES[scene](), integrator, ADAPTIVE, threads=1)
            other.run(float(start))
            for _ in range(2):
                other.run(interval / 2)
            assert other.steps == run.steps
            assert np.array_equal(state(other), state(run))
            assert other.energy().balance == run.energy().balance
    assert found > 0


def test_blocks_are_the_same_in_one_run_and_in_frames_of_half_its_length():
    """Halves of an interval are blocks of it, so a run that stops there takes the same steps, if none is longer."""
    whole, parts = (pc.Simulation(kepler(), dt=ADAPTIVE, threads=1) for _ in range(2))
    whole.run(8.0)
    for _ in range(64):
        parts.run(0.125)
    assert whole.plan.dt < 0.125
    assert whole.steps == parts.steps
    assert np.array_equal(state(whole), state(parts))


@pytest.mark.parametrize("scene", SCENES)
def test_every_step_keeps_to_the_limit_and_ends_on_time(scene):
    run = pc.Simulation(SCENES[scene](), dt=pc.AdaptiveStep(safety=0.25), threads=1)
    for frame in range(1, 101):
        run.run(0.02)
        assert run.dt <= 0.25 * run.plan.dt_limit
        assert run.time == pytest.approx(0.02 * frame, rel=1e-14)
        # Halved as often as need be, and no more: powers of two are exact.
        assert math.frexp(run.dt / 0.02)[0] == 0.5


def test_where_nothing_limits_the_step_there_are_four_to_a_frame():
    falling = pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Gravity((0.0, -9.81)))
    run = pc.Simulation(falling, dt=ADAPTIVE)
    recording = run.record(1.0, fps=10.0)
    assert run.steps == 40
    assert recording.plan.dt == pytest.approx(1.0 / 40.0, rel=1e-15)
    assert recording.positions[-1, 0, 1] == pytest.approx(-0.5 * 9.81, rel=1e-12)


def test_the_plan_says_how_steps_are_chosen():
    recording = pc.simulate(kepler(), duration=4.0, fps=10.0, dt=ADAPTIVE)
    (note,) = (note for note in recording.plan.notes if note.startswith("adaptive steps"))
    assert "keep to 50% of the limit at both of their ends" in note
    assert "tried and taken back" in note
    smallest, largest = (float(word) for word in note.split(" from ")[1].replace(",", "").split()[0:4:3])
    assert 10.0 * smallest < largest <= 0.1


def test_single_steps_are_refused():
    with pytest.raises(pc.SceneError, match=r"dt: adaptive steps are not equal.*use run\(duration\)"):
        pc.Simulation(kepler(), dt=ADAPTIVE).step()


def test_a_scene_without_a_stable_step_is_refused():
    with pytest.raises(pc.SceneError, match="no time step is certain to be stable with ExplicitEuler"):
        pc.Simulation(pc.Scene(pc.rope(3, 1.0, 100.0)), pc.ExplicitEuler(), ADAPTIVE)


def test_values_out_of_range_are_refused():
    for safety in (0.0, 1.1, -1.0):
        with pytest.raises(pc.SceneError, match=r"AdaptiveStep\.safety: must be"):
            pc.AdaptiveStep(safety)
    for tolerance in (0.0, -1.0, math.nan):
        with pytest.raises(pc.SceneError, match=r"AdaptiveStep\.tolerance: must be"):
            pc.AdaptiveStep(tolerance=tolerance)
    with pytest.raises(
        pc.SceneError,
        match=r"dt: AdaptiveStep\(tolerance=…\) needs .* BogackiShampine3\(\) or DormandPrince5\(\), got Vel",
    ):
        pc.Simulation(kepler(), dt=pc.AdaptiveStep(tolerance=1e-3))


def test_a_divergence_is_named_and_leaves_the_last_good_state():
    """A force so strong from some place on that no energy can hold what it does in the smallest step."""

    def wall(time: float, positions: Array, velocities: Array) -> Array:
        return np.where(positions > 0.5, 1e308, 0.0)

    scene = pc.Scene(pc.Particles([[0.0, 0.0]], [[1.0, 0.0]]), pc.CustomForce(wall))
    run = pc.Simulation(scene, dt=ADAPTIVE)
    with pytest.raises(pc.SimulationDiverged) as caught:
        run.run(1.0)
    error = caught.value
    assert error.step == run.steps + 1
    assert error.last_good is not None
    assert error.time > run.time == error.last_good.time
    assert np.isfinite(state(run)).all()
    # Steps of 1/128 s were tried, and halved ten times.
    assert 0.5 - 1.0 / 128.0 / 1024.0 <= run.positions[0, 0] <= 0.5


@pytest.mark.filterwarnings("ignore:duration. 1e.07 s are")
@pytest.mark.skipif(os.name != "posix", reason="needs interval timers")
def test_an_interrupt_leaves_a_whole_step_from_which_it_goes_on():
    """An interval without end in sight: it stops soon, and at a time that is a block's end."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    run = pc.Simulation(kepler(), dt=ADAPTIVE, threads=1)
    energy = run.energy().total
    before = signal.signal(signal.SIGPROF, interrupt)
    try:
        signal.setitimer(signal.ITIMER_PROF, 0.05)
        with pytest.raises(KeyboardInterrupt):
            run.run(1e7)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    assert run.steps > 0
    assert (run.time / run.dt).is_integer()
    run.run(1.0)
    assert run.energy().total == pytest.approx(energy, rel=0.01)


@pytest.mark.skipif(not LONG, reason="takes a minute")
def test_the_energy_wanders_like_the_root_of_the_time():
    """Random kicks add up like √t, a drift like t: from 500 revolutions to 8000 it is a factor of 4, and not of 16."""
    spreads = []
    for revolutions in (500, 8000):
        intervals = PERIOD * (0.5 + np.arange(16) / 16 + math.sqrt(2.0) / 100)
        last = [wander(pc.VelocityVerlet(), interval, revolutions)[-1] for interval in intervals]
        spreads.append(float(np.std(last)))
    assert spreads[1] < 8.0 * spreads[0]
