"""Events are found to the accuracy of the run, once each, and without a change of the run."""

from __future__ import annotations

import copy
import math
import pickle
import warnings
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import physcore as pc
from physcore.simulation.event import Approach
from physcore.simulation.roots import crossed
from physcore.simulation.within import between
from physcore.spelling import UnknownKey

EPSILON = float(np.finfo(np.float64).eps)
STILL = pc.Scene(pc.Particles([[0.0, 0.0]], name="dot"))
FALL = pc.Scene(pc.Particles([[0.0, 2.0]], name="ball"), pc.Gravity((0.0, -10.0)))
ROD = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], math.inf, velocities=[[0.0, -1.0], [0.0, 1.0]], name="pair")
HEIGHT = pc.Event.crossing("ball", "y", 0.0, terminal=True)


def well(frequency: float = 1.0) -> pc.Scene:
    """x = cos ωt."""
    ball = pc.Particles([[1.0, 0.0]], name="ball")
    return pc.Scene(ball, pc.CentralForce((0.0, 0.0), frequency * frequency, exponent=1))


def orbit(eccentricity: float) -> pc.Scene:
    """A Kepler orbit of the semi-major axis 1 and the period 2π, from its pericenter, and the sun at rest."""
    speed = math.sqrt((1.0 + eccentricity) / (1.0 - eccentricity))
    planet = pc.Particles([[1.0 - eccentricity, 0.0]], velocities=[[0.0, speed]], name="planet")
    sun = pc.Particles([[0.0, 0.0]], fixed=[0], name="sun")
    return pc.Scene(planet, sun, pc.CentralForce((0.0, 0.0), 1.0, on="planet"))


@pytest.mark.parametrize(
    ("integrator", "order", "steps"),
    [(pc.VelocityVerlet(), 2, 400), (pc.BlanesMoan4(), 4, 200), (pc.BlanesMoan6(), 6, 50)],
)
def test_pericenters_follow_at_the_period_to_the_order_of_the_method(integrator, order, steps):
    """A doubled number of steps divides the error by 2^order, but for the next term: a factor of √2 is allowed."""
    passage = pc.Event.closest_approach("planet", "sun")
    errors = []
    for number in (steps, 2 * steps):
        # 0.3 steps more than a whole number in a turn, so that passages fall between two steps.
        run = pc.Simulation(orbit(0.3), integrator, dt=2.0 * math.pi / (number + 0.3))
        run.run(2.1 * 2.0 * math.pi, events=[passage])
        times = run.events[passage].times
        assert len(times) == 2
        errors.append(np.abs(times - 2.0 * math.pi * np.array([1.0, 2.0])))
    coarse, fine = errors
    assert (fine > 100.0 * EPSILON).all()  # Above rounding.
    assert (np.abs(np.log2(coarse / fine) - order) < 0.5).all()


def test_adaptive_steps_find_each_limit_once():
    """The limit at the end of a step is that at the start of the next one: events cost no call of a force."""

    def run(*events: pc.Event) -> tuple[int, int, str]:
        calls = []

        def spring(time: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
            calls.append(time)
            return -x * (1.0 + 50.0 * x[:, :1] ** 2)

        scene = pc.Scene(pc.Particles([[1.0, 0.5]]), pc.CustomForce(spring))
        simulation = pc.Simulation(scene, integrator="VelocityVerlet", dt=pc.AdaptiveStep())
        calls.clear()
        simulation.run(2.0, events=events)
        return simulation.steps, len(calls), simulation.state_hash()

    plain = run()
    assert plain[0] > 20
    assert run(pc.Event(lambda state: 1.0)) == plain


@pytest.mark.parametrize("numerics", [{"dt": pc.AdaptiveStep(tolerance=1e-9), "integrator": "DormandPrince5"}, {}])
def test_pericenters_are_found_between_adaptive_steps_too(numerics):
    """The steps of the run, of GaussRadau15 by rounding alone, are as accurate as this."""
    passage = pc.Event.closest_approach("planet", "sun")
    numerics = numerics or {"integrator": "GaussRadau15"}
    recording = pc.simulate(orbit(0.6), 4.1 * math.pi, fps=3.0, events=[passage], **numerics)
    assert_allclose(recording.events[passage].times, [2.0 * math.pi, 4.0 * math.pi], rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("direction", [-1, 0, 1])
def test_an_oscillator_crosses_zero_in_both_directions(direction):
    """x = cos t falls through 0 at π/2 + 2πk and rises at 3π/2 + 2πk. RungeKutta4 delays the phase by t dt⁴/120."""
    crossing = pc.Event.crossing("ball", (1.0, 0.0), direction=direction)
    dt = 0.01
    recording = pc.simulate(well(), 20.0, integrator="RungeKutta4", dt=dt, events=[crossing])
    every = math.pi * (np.arange(6) + 0.5)
    expected = {-1: every[::2], 0: every, 1: every[1::2]}[direction]
    found = recording.events[crossing]
    assert_allclose(found.times, expected, rtol=0.0, atol=1.1 * 20.0 * dt**4 / 120.0)
    assert_allclose(found["ball"].positions[:, 0, 0], 0.0, atol=1e-14)
    signs = np.where(np.arange(6) % 2, 1.0, -1.0)[
        {-1: slice(0, None, 2), 0: slice(None), 1: slice(1, None, 2)}[direction]
    ]
    assert_allclose(found["ball"].velocities[:, 0, 0], signs, atol=1e-9)


@pytest.mark.parametrize("dt", [0.03, "auto", pc.AdaptiveStep()])
def test_a_ball_falls_past_heights(dt):
    """y = 2 − 5t²: VelocityVerlet has no error, so that times are off by rounding: of y, some ε·2, over the speed."""
    heights = np.array([1.75, 1.2, 0.2])
    events = [pc.Event.crossing("ball", "y", float(height)) for height in heights]
    recording = pc.simulate(FALL, 0.7, dt=dt, integrator="VelocityVerlet", events=events)
    times = np.concatenate([recording.events[event].times for event in events])
    assert_allclose(times, np.sqrt((2.0 - heights) / 5.0), rtol=0.0, atol=50.0 * EPSILON)
    speeds = np.concatenate([recording.events[event].velocities[:, 0, 1] for event in events])
    assert_allclose(speeds, -10.0 * times, rtol=1e-14)


def test_free_particles_are_closest_where_their_distance_is_perpendicular_to_their_velocity():
    """|r₀ + v t| is smallest at t = −r₀·v/v²; of 20 pairs those approach for which that is positive."""
    rng = np.random.default_rng(8)
    some = pc.Particles(rng.normal(size=(20, 3)), velocities=rng.normal(size=(20, 3)), name="some")
    one = pc.Particles(rng.normal(size=(1, 3)), velocities=rng.normal(size=(1, 3)), name="one")
    apart, speed = some.positions - one.positions, some.velocities - one.velocities
    expected = -(apart * speed).sum(axis=1) / (speed * speed).sum(axis=1)
    near, single = pc.Event.closest_approach("some", "one"), pc.Event.closest_approach(("some", 3), one)
    run = pc.Simulation(pc.Scene(some, one), dt=0.07)
    run.run(2.0, events=[near, single])
    found = run.events[near]
    within = np.flatnonzero((expected > 0.0) & (expected < run.time))
    assert len(within) > 5
    assert_array_equal(np.sort(found.indices), within)
    assert_allclose(found.times, expected[found.indices], rtol=0.0, atol=1e-12)
    assert (np.diff(found.times) >= 0.0).all()
    assert_array_equal(run.events[single].times, found.times[found.indices == 3])


@pytest.mark.parametrize(
    ("scene", "pair", "duration", "numerics"),
    [
        (pc.Scene(pc.PointVortices([[0.0, 0.0], [1.0, 0.0]], [1.0, 1.0], name="pair")), 0, 20.0, {}),
        (pc.Scene(pc.PointVortices([[1e6, 0.0], [1e6 + 1.0, 0.0]], [1.0, 1.0], name="pair")), 0, 20.0, {}),
        (pc.Scene(ROD), 0, 10.0, {}),
        (pc.Scene(ROD, pc.Gravity()), 0, 10.0, {"dt": 0.01}),
        (orbit(0.0), 1, 60.0, {"integrator": "GaussRadau15"}),
    ],
    ids=["vortices", "vortices far from the origin", "rod", "falling rod", "circular orbit"],
)
def test_a_constant_distance_has_no_closest_approaches(scene, pair, duration, numerics):
    one, other = [(("pair", 0), ("pair", 1)), ("planet", "sun")][pair]
    event = pc.Event.closest_approach(one, other, terminal=True)
    run = pc.Simulation(scene, **numerics)
    run.run(duration, events=[event])
    assert not len(run.events[event])
    assert run.time >= duration * (1.0 - EPSILON)


@pytest.mark.parametrize("eccentricity", [1e-8, 1e-4, 0.01, 0.1, 0.5, 0.9])
def test_every_pericenter_is_found(eccentricity):
    """GaussRadau15 is exact but for rounding: r·v has the error 10 ε and the slope e at the pericenter, for e ≪ 1. If a
    step ends where r·v has no sign, the time is late by up to 1e-9 / e, which happens with the probability 1e-9 / e.
    """
    passage = pc.Event.closest_approach("planet", "sun")
    run = pc.Simulation(orbit(eccentricity), "GaussRadau15")
    run.run(20.0, events=[passage])
    late = 1.1e-9 / eccentricity if eccentricity < 1e-6 else 0.0
    error = 1e-12 + 100.0 * EPSILON / eccentricity + late
    assert_allclose(run.events[passage].times, 2.0 * math.pi * np.arange(1, 4), rtol=0.0, atol=error)


class Prescribed(Approach):
    """r·v of a pair that approaches until 0.3 s, turns at a constant distance, and from 0.6 s on has a given speed."""

    later = 0.0

    def __call__(self, state: pc.Snapshot) -> np.ndarray:
        return super().__call__(self.at(state))

    def uncertainty(self, state: pc.Snapshot) -> np.ndarray:
        return super().uncertainty(self.at(state))

    def at(self, state: pc.Snapshot) -> pc.Snapshot:
        noise = 1e-12 * math.sin(1e4 * state.time)
        speed = -1.0 if state.time < 0.3 else noise if state.time < 0.6 else self.later
        fields = {"positions": np.array([[2.0, 0.0], [0.0, 0.0]]), "velocities": np.array([[speed, 1.0], [0.0, 0.0]])}
        return pc.Snapshot(state.time, fields, scene=state.scene)


@pytest.mark.parametrize(("later", "number"), [(-1.0, 0), (0.0, 0), (1.0, 1)])
def test_an_approach_to_a_constant_distance_is_an_event_if_a_retreat_follows(later, number):
    event = pc.Event(Prescribed("planet", slice(None), "sun", slice(None)), 1)
    event.function.__dict__["later"] = later
    run = pc.Simulation(orbit(0.0), dt=0.07)
    run.run(1.0, events=[event])
    times = run.events[event].times
    assert len(times) == number
    assert ((times > 0.3) & (times < 0.6 + 1e-12)).all()


def test_numbers_of_bodies_are_those_of_numpy_too():
    numbers = np.arange(2)
    events = [
        pc.Event.closest_approach(numbers[0], (numbers[1], numbers[0])),
        pc.Event.crossing(np.uint8(0), "y"),
    ]
    run = pc.Simulation(orbit(0.5), dt=0.01)
    run.run(7.0, events=events)
    assert [len(each) for each in run.events] == [1, 2]
    assert events[1].name == "0: y = 0"
    for wrong in (np.bool_(True), np.timedelta64(0), True, np.float64(0.0)):
        with pytest.raises(pc.SceneError, match=r"Event.crossing.body: must be a body, its index"):
            pc.Event.crossing(wrong, "y")


@pytest.mark.parametrize("dt", [0.03, "auto", pc.AdaptiveStep()])
def test_a_terminal_event_ends_the_recording(dt):
    """y = 2 − 5t² is 0 at √0.4 = 0.632 s: the last of 30 frames per second before is the one at 18/30 s."""
    landing = HEIGHT
    numerics = {"dt": dt, "integrator": "VelocityVerlet"}
    recording = pc.simulate(FALL, 5.0, events=[landing], **numerics)
    whole = pc.simulate(FALL, 5.0, **numerics)
    assert len(recording) == 19
    assert_array_equal(recording.times, whole.times[:19])
    assert_array_equal(recording.positions, whole.positions[:19])
    assert_array_equal(recording.energy.balance, whole.energy.balance[:19])
    assert all(len(each) == 19 for each in (recording.momentum, recording.energy.times, recording.angular_momentum))
    (time,) = recording.events[landing].times
    assert_allclose(time, math.sqrt(0.4), rtol=1e-14)
    run = pc.Simulation(FALL, **numerics)
    run.run(5.0, events=[landing])
    assert run.time == run.events[landing].times[0] == pytest.approx(time, rel=1e-14)
    assert_array_equal(run.positions, run.events[landing].positions[0])
    if not isinstance(dt, pc.AdaptiveStep):
        assert sum(segment.steps * segment.dt for segment in run.provenance.segments) == pytest.approx(time, rel=1e-14)
    run.run(0.1, events=[landing])
    assert run.positions[0, 1] < -0.5
    assert not len(run.events[landing])


def test_the_third_crossing_ends_the_run():
    crossing = pc.Event.crossing("ball", "x", terminal=3)
    other = pc.Event(lambda state: state.time - 7.8, name="before")
    later = pc.Event(lambda state: state.time - 7.86, name="in the last step, and later")
    run = pc.Simulation(well(), "RungeKutta4", dt=0.05)
    run.run(20.0, events=[crossing, other, later])
    assert_allclose(run.events[crossing].times, [0.5 * math.pi, 1.5 * math.pi, 2.5 * math.pi], atol=1e-5)
    assert run.time == run.events[crossing].times[-1]
    assert [len(each) for each in run.events] == [3, 1, 0]


@pytest.mark.parametrize("dt", [0.013, "auto", pc.AdaptiveStep()])
def test_a_recording_with_events_has_the_same_bits(dt):
    crossing = pc.Event.crossing("ball", "x")
    plain, watched = (pc.simulate(well(3.0), 3.0, dt=dt, events=events) for events in ([], [crossing]))
    assert len(watched.events[crossing]) > 2
    for name in plain.channels:
        assert_array_equal(watched.channels[name], plain.channels[name])
    assert_array_equal(watched.energy.balance, plain.energy.balance)
    assert watched.provenance == plain.provenance


@pytest.mark.parametrize(
    "numerics",
    [
        {"dt": 0.013},
        {"dt": "auto"},
        {"dt": pc.AdaptiveStep()},
        {"dt": pc.AdaptiveStep(tolerance=1e-6), "integrator": "DormandPrince5"},
        {"integrator": "GaussRadau15"},
    ],
)
def test_every_step_is_looked_at_once(numerics):
    seen = []

    def watched(state: pc.Snapshot) -> float:
        seen.append(state.time)
        return 1.0

    run = pc.Simulation(orbit(0.5), **numerics)
    run.run(3.0, events=[pc.Event(watched)])
    assert len(seen) == run.steps + 1
    assert (np.diff(seen) > 0.0).all()
    assert seen[-1] == run.time


@given(st.lists(st.integers(-2, 2), min_size=2, max_size=40), st.sampled_from([-1, 0, 1]))
@settings(max_examples=60)
def test_every_change_of_sign_is_found_once(knots, direction):
    """The value at step k is a given number, and runs straight between two steps: the roots are known. A value that
    becomes 0 counts, one that departs from 0 does not.
    """
    dt = 0.25
    places = dt * np.arange(len(knots))
    event = pc.Event(lambda state: np.interp(state.time, places, knots), direction)
    run = pc.Simulation(STILL, dt=dt)
    run.run(places[-1], events=[event])
    expected = [
        dt * (step + before / (before - after))
        for step, (before, after) in enumerate(pairwise(knots))
        if before != 0 and np.sign(before) != np.sign(after) and direction * before <= 0
    ]
    assert_allclose(run.events[event].times, expected, rtol=0.0, atol=1e-12)


@given(st.floats(-3.0, 3.0), st.floats(0.1, 5.0), st.sampled_from(["straight", "cubic", "steep", "jump", "huge"]))
def test_a_bracket_closes_after_the_root(root, width, kind):
    functions = {
        "straight": lambda x: x - root,
        "cubic": lambda x: (x - root) ** 3,
        "steep": lambda x: math.expm1(30.0 * (x - root)),
        "jump": lambda x: 1.0 if x > root else -1.0,
        "huge": lambda x: 3e307 * (x - root),
    }
    calls = []

    def function(x: float) -> float:
        calls.append(x)
        return functions[kind](x)

    low, high = root - width, root + 0.7 * width
    found = crossed(function, (low, high), (functions[kind](low), functions[kind](high)), 1e-12)
    assert root <= found <= root + 1e-12 or functions[kind](found) == 0.0
    assert len(calls) < 110  # A bisection takes 43.
    assert all(low < x < high for x in calls)


def test_an_angle_wraps_without_an_event():
    """At the angle π a value in (−π, π] jumps past 0: with a period that is no event, and without one it is."""

    def angle(state: pc.Snapshot) -> float:
        x, y = state["planet"].positions[0]
        return math.atan2(y, x)

    wrapped, plain = pc.Event(angle, period=2.0 * math.pi), pc.Event(angle)
    run = pc.Simulation(orbit(0.0), "RungeKutta4", dt=0.01)
    run.run(13.0, events=[wrapped, plain])
    assert_allclose(run.events[wrapped].times, [2.0 * math.pi, 4.0 * math.pi], atol=1e-6)
    assert_allclose(run.events[plain].times, math.pi * np.arange(1, 5), atol=1e-6)


def test_planes_and_pairs_in_a_periodic_domain():
    """A particle with 1 m/s in a domain of 2 m passes x = 0.5 once in 2 s, in one direction, and its neighbor too. One
    with 2 m/s overtakes it every 2 s, first after 1.3 s.
    """
    moving = pc.Particles([[0.0, 0.0]], velocities=[[1.0, 0.0]], name="moving")
    still = pc.Particles([[0.7, 0.1]], name="still")
    fast = pc.Particles([[0.7, 0.2]], velocities=[[2.0, 0.0]], name="fast")
    scene = pc.Scene(moving, still, fast, pc.Periodic((-1.0, -math.inf), (1.0, math.inf)))
    plane, pair = pc.Event.crossing("moving", "x", 0.5), pc.Event.closest_approach("moving", "still")
    image, overtaking = pc.Event.crossing("moving", "x", 2.5, direction=-1), pc.Event.closest_approach(moving, fast)
    run = pc.Simulation(scene, dt=0.03)
    run.run(6.0, events=[plane, pair, image, overtaking])
    assert_allclose(run.events[plane].times, [0.5, 2.5, 4.5], atol=1e-13)
    assert_allclose(run.events[pair].times, [0.7, 2.7, 4.7], atol=1e-13)
    assert_array_equal(run.events[image].times, [])
    assert_allclose(run.events[overtaking].times, [1.3, 3.3, 5.3], atol=1e-13)
    with pytest.raises(pc.SceneError, match=r"events\[0\].crossing.axis: must be perpendicular to an axis"):
        run.run(1.0, events=[pc.Event.crossing("moving", (1.0, 1.0))])


def test_a_standing_wave_passes_zero_after_a_quarter_of_its_period():
    grid = pc.Grid(64, 1.0 / 64, periodic=True)
    wave = pc.Wave(grid, speed=1.0, displacement=lambda x: np.cos(2.0 * np.pi * x), name="string")
    flat = pc.Event(lambda state: state[wave].displacement[0])
    recording = pc.simulate(pc.Scene(wave), 1.0, dt=0.004, events=[flat])
    found = recording.events[flat]
    # The three-point Laplacian slows the wave by (k dx)²/24 = 4e-4, and the step of order 2 by less.
    assert_allclose(found.times, [0.25, 0.75], rtol=1e-3)
    assert found["string"].displacement.shape == (2, 64)
    assert_allclose(found["string"].displacement, 0.0, atol=1e-10)


def test_tracers_cross_planes():
    """x′ = −y, y′ = x: tracer k starts at the angle k, and crosses x = 0 at the angle π/2."""
    angles = np.array([0.0, 0.5, 1.0])
    start = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    tracers = pc.Tracers(start, pc.Flow(lambda time, x: np.stack([-x[:, 1], x[:, 0]], axis=1)), name="tracers")
    events = [pc.Event.crossing(tracers, "x"), pc.Event.crossing(("tracers", 1), "x")]
    run = pc.Simulation(pc.Scene(tracers), "RungeKutta4", dt=0.01)
    run.run(2.0, events=events)
    assert_array_equal(run.events[0].indices, [2, 1, 0])
    assert_allclose(run.events[0].times, 0.5 * math.pi - angles[::-1], atol=1e-9)
    assert_allclose(run.events[1].times, 0.5 * math.pi - 0.5, atol=1e-9)


def test_where_short_steps_differ_in_kind_the_root_is_that_of_the_interpolation():
    """XPBD moves rods to their lengths in every step, however short it is."""
    rod = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], math.inf, fixed=[0], name="rod")
    scene = pc.Scene(rod, pc.Gravity((0.0, -10.0)))
    passing = pc.Event.crossing(("rod", 1), "x", terminal=True)
    numerics = {"integrator": pc.XPBD(3, 2), "dt": 0.02}
    run = pc.Simulation(scene, **numerics)
    run.run(2.0, events=[passing])
    (time,) = run.events[passing].times
    plain = pc.Simulation(scene, **numerics)
    plain.step(run.steps - 1)
    before = next(plain.frames(0.0))
    plain.step()
    assert plain.state_hash() == run.state_hash()  # The run ends with the step.
    after = next(plain.frames(0.0))
    rates = {"positions": "velocities"}
    middle = between(before, after, (time - before.time) / 0.02, 0.02, rates)
    found = run.events[passing]["rod"]
    assert_allclose(found.positions[0], middle.positions, rtol=0.0, atol=1e-14)
    assert_allclose(found.velocities[0], middle.velocities, rtol=0.0, atol=1e-12)
    assert found.positions[0, 1, 0] == pytest.approx(0.0, abs=1e-14)


def test_steps_that_roll_back_have_no_events():
    """The run diverges: what was found lies in steps that hold, and is still there."""
    spring = pc.SpringNetwork([[0.0, 0.0], [1.1, 0.0]], [[0, 1]], 100.0, rest_length=1.0, fixed=[0], name="spring")
    stretch = pc.Event(lambda state: state["spring"].positions[1, 0] - 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pc.StabilityWarning)
        run = pc.Simulation(pc.Scene(spring), "VelocityVerlet", dt=0.3)
        with pytest.raises(pc.SimulationDiverged) as caught:
            run.run(1000.0, events=[stretch])
        plain = pc.Simulation(pc.Scene(spring), "VelocityVerlet", dt=0.3)
        with pytest.raises(pc.SimulationDiverged) as expected:
            plain.run(1000.0)
    assert caught.value.step == expected.value.step
    assert run.state_hash() == plain.state_hash()
    found = run.events[stretch]
    assert len(found) > 2
    assert found.times[-1] <= caught.value.last_good.time == run.time
    assert np.isfinite(found.positions).all()


def test_a_step_in_parts_is_watched_as_one():
    """The ball is below 0 for half a period of the hard spring, π/√(k/m), about half of dt: there a step fails."""
    ball = pc.Particles([[0.0, 0.05]], velocities=[[0.0, -1.0]], name="ball")

    def force(time: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.where(x < 0.0, -1e5 * x, 0.0)

    hard = pc.CustomForce(force, potential=lambda x: 5e4 * (x[x < 0.0] ** 2).sum())
    event = pc.Event.crossing("ball", "y", 0.001)
    runs = []
    for events in ([], [event]):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pc.StabilityWarning)
            run = pc.Simulation(pc.Scene(ball, hard), "VelocityVerlet", dt=0.02, on_divergence="substep")
            run.run(0.3, events=events)
        runs.append(run)
    plain, watched = runs
    assert plain.substeps > 0
    assert watched.state_hash() == plain.state_hash()
    assert watched.provenance == plain.provenance
    down, up = watched.events[event].times
    assert down == pytest.approx(0.049, abs=1e-12)
    assert up == pytest.approx(0.051 + math.pi / math.sqrt(1e5), abs=1e-3)


@pytest.mark.parametrize("error", [ZeroDivisionError("mine"), KeyboardInterrupt()])
def test_nothing_is_lost_when_a_function_raises(error):
    """The run is then at the start of the step, with its events, and goes on with the same bits and the next event."""
    armed = [True]

    def height(state: pc.Snapshot) -> float:
        found = state["ball"].positions[0, 1] - 0.5
        if found < 0.0 and armed[0]:
            raise error
        return float(found)

    above, low = pc.Event.crossing("ball", "y", 1.5), pc.Event(height)
    run, plain = (pc.Simulation(FALL, "VelocityVerlet", dt=0.04) for _ in range(2))
    kind = pc.SceneError if isinstance(error, Exception) else KeyboardInterrupt
    with pytest.raises(kind) as caught:
        run.run(0.64, events=[above, low])
    if kind is pc.SceneError:
        assert str(caught.value).startswith("events[1].function: the function raised ZeroDivisionError: mine")
        assert caught.value.__cause__ is error
    assert len(run.events[above]) == 1
    assert run.steps == 13  # y = 0.5 at √0.3 = 0.548 s, in step 14.
    assert run.provenance.segments[0].steps == 13
    armed[0] = False
    run.run(0.12, events=[low])
    plain.run(0.64)
    assert_allclose(run.events[low].times, [math.sqrt(0.3)], rtol=1e-14)
    assert run.state_hash() == plain.state_hash()


def test_accuracy_holds_for_events():
    crossing = pc.Event.crossing("ball", "x", terminal=4)
    recording = pc.simulate(well(), 20.0, fps=5.0, accuracy=1e-6, events=[crossing])
    assert_allclose(recording.events[crossing].times, math.pi * (np.arange(4) + 0.5), rtol=0.0, atol=1e-6)
    assert recording.times[-1] == pytest.approx(10.8)
    assert any("accuracy" in note or "within" in note for note in recording.plan.notes)


def test_events_are_saved_and_loaded(tmp_path):
    crossing = pc.Event.crossing("ball", "x", name="through the middle")
    never = pc.Event(lambda state: 1.0)
    recording = pc.simulate(well(), 5.0, events=[crossing, never])
    recording.save(tmp_path / "run.npz")
    loaded = pc.load(tmp_path / "run.npz")
    assert [each.name for each in loaded.events] == ["through the middle", "event"]
    for other in (loaded, pickle.loads(pickle.dumps(recording)), copy.deepcopy(recording)):
        for key in ("through the middle", 0, -1):
            one, two = other.events[key], recording.events[key]
            assert_array_equal(one.times, two.times)
            assert_array_equal(one.indices, two.indices)
            assert_array_equal(one["ball"].velocities, two["ball"].velocities)
    assert repr(loaded.events) == repr(recording.events)
    with pytest.raises(KeyError, match="no event 'other': there are 'through the middle', 'event'"):
        loaded.events["other"]
    with pytest.raises(UnknownKey, match="'event'; did you mean 'through the middle'"):
        recording.events["thruogh the middle"]
    with pytest.raises(UnknownKey, match="no event 'event': a loaded recording has no functions: use its name or num"):
        loaded.events[never]
    with pytest.raises(UnknownKey, match=r"no event 'ball: y = 0': there are 'through the middle', 'event'$"):
        recording.events[HEIGHT]
    with pytest.raises(UnknownKey, match="more than one event 'event': there are 'event', 'event'; use its number"):
        pc.simulate(STILL, 0.1, events=[never, pc.Event(lambda state: 2.0)]).events["event"]


def test_misspelt_fields_have_suggestions():
    recording = pc.simulate(FALL, 0.1)
    for shown in (recording, recording["ball"], pc.Simulation(FALL)["ball"]):
        with pytest.raises(AttributeError, match=r"no field 'positon': .*; did you mean 'positions'\?"):
            shown.positon  # noqa: B018
    with pytest.raises(AttributeError, match=r"no field 'enegry': .*; did you mean 'energy'\?"):
        recording.enegry  # noqa: B018
    for shown in (recording["ball"], pc.Simulation(FALL)["ball"]):
        with pytest.raises(UnknownKey, match=r"no field 'positon': .*; did you mean 'positions'\?"):
            shown["positon"]
    assert not hasattr(recording, "_repr_latex_")


def test_a_film_of_a_recording_with_events(tmp_path):
    recording = pc.simulate(FALL, 5.0, fps=10.0, events=[HEIGHT])
    pc.film(recording, tmp_path / "fall.gif", size=(64, 64))
    assert (tmp_path / "fall.gif").stat().st_size > 0


def test_tables_at_a_prompt():
    crossing = pc.Event.crossing("ball", "x", name="middle")
    recording = pc.simulate(well(10.0), 6.0, events=[crossing, pc.Event(lambda state: 1.0, name="never")])
    table = repr(recording.events[crossing]).splitlines()
    assert table[0] == "middle: 19"
    assert table[1].split() == ["time", "[s]", "index", "since", "the", "one", "before", "[s]"]
    assert len(table) == 13
    assert table[-1] == "and 9 more"
    assert repr(recording.events["never"]) == "never: none"
    assert repr(recording.events).splitlines()[2].split() == ["never", "0"]
    assert repr(pc.Events()) == "no events"
    for shown in (recording.events, recording.events[0]):
        assert "<table>" in shown._repr_html_()


def test_frames_are_watched_too():
    run = pc.Simulation(FALL, dt=0.03)
    frames = list(run.frames(5.0, fps=10.0, events=[HEIGHT]))
    assert [frame.time for frame in frames] == pytest.approx([0.1 * index for index in range(7)])
    assert run.time == pytest.approx(math.sqrt(0.4))
    run.run(0.1)
    assert repr(run.events) == "no events"


def test_what_is_set_between_two_frames_is_no_event():
    """At 0.5 s, at y = 0.75, the ball is put to y = 1.75 at rest: it passes y = 1 after √(0.75/5) s once more."""
    event = pc.Event.crossing("ball", "y", 1.0)
    run = pc.Simulation(FALL, "VelocityVerlet", dt=0.02)
    for index, _ in enumerate(run.frames(1.0, fps=10.0, events=[event])):
        if index == 5:
            run.set([0.0, 1.75], [0.0, 0.0])
    assert_allclose(run.events[event].times, [math.sqrt(0.2), 0.5 + math.sqrt(0.15)], rtol=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pc.Event(3.0), "Event.function: must be a function"),
        (lambda: pc.Event(len, direction=2), "Event.direction: must be −1, 0 or 1"),
        (lambda: pc.Event(len, direction=True), "Event.direction: must be a number"),
        (lambda: pc.Event(len, terminal=0), "Event.terminal: must be ≥ 1"),
        (lambda: pc.Event(len, terminal="yes"), "Event.terminal: must be a whole number"),
        (lambda: pc.Event(len, name=3), "Event.name: must be a string"),
        (lambda: pc.Event(len, period=0.0), "Event.period: must be > 0"),
        (lambda: pc.Event.crossing(2.5, "x"), "Event.crossing.body: must be a body"),
        (lambda: pc.Event.crossing("ball", "up"), "Event.crossing.axis: must be 'x', 'y' or 'z'"),
        (lambda: pc.Event.crossing("ball", (0.0, 0.0)), "Event.crossing.axis: must not be the zero vector"),
        (lambda: pc.Event.crossing("ball", "x", math.nan), "Event.crossing.value: must be finite"),
        (lambda: pc.Event.closest_approach(None, "ball"), "Event.closest_approach.a: must be a body"),
    ],
)
def test_wrong_events_are_refused(make, message):
    with pytest.raises(pc.SceneError) as caught:
        make()
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("events", "message"),
    [
        (HEIGHT, "events: must be a list of Event; write events=[…]"),
        ([lambda state: 1.0], "events[0]: must be an Event"),
        ([HEIGHT, HEIGHT], "events[1]: is given twice"),
        ([pc.Event.crossing("stone", "x")], "events[0].crossing.body: "),
        ([pc.Event.crossing(pc.Tracers([[0.0, 0.0]], pc.Flow(lambda time, x: x)), "x")], "events[0].crossing.body: "),
        ([pc.Event.crossing("ball", "z")], "events[0].crossing.axis: must be one of 2D"),
        ([pc.Event.crossing(("ball", 7), "x")], "events[0].crossing.body: "),
        ([pc.Event.closest_approach("ball", 0)], "events[0].closest_approach.b: must be other particles than a"),
        ([pc.Event(lambda state: math.nan)], "events[0].function at t = 0 s: its value: must be finite"),
        ([pc.Event(lambda state: "high")], "events[0].function at t = 0 s: its value: must be"),
        ([pc.Event(lambda state: None)], "events[0].function at t = 0 s: its value: must be"),
        ([pc.Event(lambda state: state.positions)], "events[0].function at t = 0 s: its value: must be a number or"),
        ([pc.Event(lambda state: state.time > 1.0)], "events[0].function at t = 0 s: its value: must be a number that"),
        ([pc.Event(lambda state: 1 / 0)], "events[0].function: the function raised ZeroDivisionError"),
        ([pc.Event(lambda: 1.0)], "events[0].function: the function raised TypeError"),
        ([pc.Event(lambda state: np.ones(1 + (state.time > 0.1)))], "events[0].function: must always return one shape"),
        ([pc.Event(lambda state: state.positions.fill(0.0))], "events[0].function: the function raised ValueError"),
        ([pc.Event(lambda state: 1.0 / (state.time < 0.1))], "events[0].function: the function raised ZeroDivision"),
    ],
)
def test_what_does_not_suit_a_run_is_refused(events, message):
    run = pc.Simulation(FALL, dt=0.01)
    with pytest.raises(pc.SceneError) as caught:
        run.run(1.0, events=events)
    assert str(caught.value).startswith(message)
    before = run.time
    run.run(0.1)
    assert run.time == pytest.approx(before + 0.1)


def test_a_function_that_steps_the_simulation_is_refused():
    run = pc.Simulation(FALL, dt=0.01)

    def meddles(state: pc.Snapshot) -> float:
        if state.time > 0.1:
            run.step()
        return 1.0

    with pytest.raises(pc.SceneError, match="this simulation is running") as caught:
        run.run(1.0, events=[pc.Event(meddles)])
    assert isinstance(caught.value.__cause__, pc.PhyscoreError)
    assert run.steps == 10
