"""Contacts: heights, friction and sliding as the textbook has them, and an energy budget that no wall opens."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import ALL, EPSILON, name, simulation, state

G = 9.81
SECOND_ORDER = [integrator for integrator in ALL if integrator.order > 1]
"""These follow the parabola of a free flight exactly; a method of order 1 falls differently between the walls."""


def ball(height: float, restitution: float, radius: float = 0.0, **floor: float) -> pc.Scene:
    body = pc.Particles([[0.0, height + radius]], radius=radius)
    return pc.Scene(body, pc.Gravity((0.0, -G)), pc.Floor(0.0, restitution=restitution, **floor))


def apexes(run: pc.Simulation, count: int) -> list[float]:
    """The heights of the first turning points after a bounce: exact on the parabola that starts from any state."""
    heights: list[float] = []
    rising = False
    while len(heights) < count:
        run.step(1)
        (_, y), (_, v) = run.positions[0], run.velocities[0]
        if rising and v <= 0.0:
            heights.append(float(y + v * v / (2.0 * G)))
        rising = v > 0.0
    return heights


@pytest.mark.parametrize("integrator", SECOND_ORDER, ids=name)
@pytest.mark.parametrize("restitution", [1.0, 0.9, 0.8, 0.5])
@pytest.mark.parametrize("dt", [1e-3, 1.0 / 240.0, 0.03])
def test_bounce_heights_are_powers_of_the_restitution(integrator, restitution, dt):
    """h_n = h e^(2n), within 1e-6 whatever the step: the impact is found within it."""
    run = simulation(ball(1.0, restitution), integrator, dt)
    np.testing.assert_allclose(apexes(run, 4), restitution ** (2.0 * np.arange(1, 5)), rtol=1e-6)


@pytest.mark.parametrize("integrator", SECOND_ORDER, ids=name)
@given(restitution=st.floats(0.0, 1.0), radius=st.floats(0.0, 0.1), speed=st.floats(-5.0, 5.0))
def test_a_bouncing_ball_keeps_its_budget_to_rounding(integrator, restitution, radius, speed):
    """A parabola is exact, and what a contact takes is what it counts: an ε of the energy per step and bounce."""
    body = pc.Particles([[0.0, 1.0 + radius]], [[1.0, speed]], radius=radius)
    scene = pc.Scene(body, pc.Gravity((0.0, -G)), pc.Floor(0.0, restitution=restitution, friction=0.3))
    run = simulation(scene, integrator, 0.004)
    before = run.energy().balance
    size = abs(run.energy().total) + G
    for _ in range(10):
        run.step(100)
        assert abs(run.energy().balance - before) <= 1000 * 4 * EPSILON * size
        assert run.positions[0, 1] >= radius - 4 * EPSILON


def inside(body: pc.Particles, dimension: int, restitution: float, friction: float) -> pc.Scene:
    """Particles in a box within a bowl, around a ball."""
    corner = np.full(dimension, 1.0)
    return pc.Scene(
        body,
        pc.Gravity(tuple(-G * np.eye(dimension)[-1])),
        pc.Box(tuple(-corner), tuple(corner), restitution=restitution, friction=friction),
        pc.Sphere((0.0,) * dimension, 1.2, inside=True, restitution=restitution, friction=friction),
        pc.Sphere((0.0,) * dimension, 0.2, restitution=restitution, friction=friction),
    )


def gas(seed: int, dimension: int, speed: float) -> pc.Particles:
    """Thirty particles of radius 0.01 at distances of 0.3 to 0.8 from the middle, in all directions."""
    rng = np.random.default_rng(seed)
    directions = rng.standard_normal((30, dimension))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return pc.Particles(
        directions * rng.uniform(0.3, 0.8, (30, 1)), speed * rng.standard_normal((30, dimension)), radius=0.01
    )


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("integrator", ALL, ids=name)
@given(
    seed=st.integers(0, 2**32 - 1),
    dimension=st.sampled_from([2, 3]),
    speed=st.sampled_from([0.1, 10.0, 1e4]),
    restitution=st.floats(0.0, 1.0),
    friction=st.floats(0.0, 2.0),
)
def test_nothing_tunnels_at_any_speed(integrator, precision, seed, dimension, speed, restitution, friction):
    """At 1e4 m/s and 1 ms a particle crosses the box five times in a step, and is inside after each of them."""
    body = gas(seed, dimension, speed)
    run = simulation(inside(body, dimension, restitution, friction), integrator, 1e-3, precision=precision)
    slack = 4.0 * float(np.finfo(precision.replace("f", "float")).eps)
    for _ in range(20):
        run.step(1)
        reach, distance = np.abs(run.positions).max(), np.linalg.norm(run.positions, axis=1)
        assert reach <= 0.99 + slack
        assert distance.max() <= 1.19 + slack
        assert distance.min() >= 0.21 - slack
        assert np.isfinite(state(run)).all()


@pytest.mark.parametrize("integrator", SECOND_ORDER, ids=name)
@given(seed=st.integers(0, 2**32 - 1), dimension=st.sampled_from([2, 3]))
def test_walls_that_give_all_back_never_add_energy(integrator, seed, dimension):
    """Restitution 1 turns a velocity around: over hundreds of bounces the energy stays to an ε per bounce and step."""
    run = simulation(inside(gas(seed, dimension, 5.0), dimension, 1.0, 0.0), integrator, 2e-3)
    before = run.energy().total
    run.step(1000)
    after = run.energy()
    # Some 30 particles with up to 10 bounces per unit of time and speed, and 1000 steps each; at random signs.
    assert abs(after.total - before) <= 1000 * 10 * EPSILON * before
    assert abs(after.dissipated) <= 1000 * 10 * EPSILON * before


@pytest.mark.parametrize("integrator", SECOND_ORDER, ids=name)
@given(seed=st.integers(0, 2**32 - 1), dimension=st.sampled_from([2, 3]), restitution=st.floats(0.0, 1.0))
def test_the_budget_of_a_gas_closes_across_all_bounces(integrator, seed, dimension, restitution):
    """total + dissipated is as constant as the parabolas between flat walls, and the slides on them: to rounding.

    500 steps of 30 particles at up to 20 m/s; each rounds some ten numbers by an ε of the energy of the whole at most.
    """
    box = pc.Box((-1.0,) * dimension, (1.0,) * dimension, restitution=restitution, friction=0.3)
    gravity = pc.Gravity(tuple(-G * np.eye(dimension)[-1]))
    run = simulation(pc.Scene(gas(seed, dimension, 5.0), gravity, box), integrator, 2e-3)
    before = run.energy().balance
    run.step(500)
    assert abs(run.energy().balance - before) <= 500 * 10 * EPSILON * (abs(before) + 30 * G)
    assert run.energy().dissipated > 0.0


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("integrator", SECOND_ORDER, ids=name)
def test_the_budget_of_a_slide_around_a_bowl_closes_to_second_order(integrator, friction):
    """On a curved wall a slide is followed in stretches, and their error shrinks by 4 when dt is halved."""
    bowl = pc.Sphere((0.0, 0.0), 1.0, inside=True, restitution=0.0, friction=friction)
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.Gravity((0.0, -G)), bowl)
    errors = []
    for dt in (2e-3, 1e-3, 5e-4):
        run = simulation(scene, integrator, dt)
        before = run.energy().balance
        run.step(round(1.0 / dt))
        errors.append(run.energy().balance - before)
    assert abs(errors[0]) < 1e-4 * G
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("integrator", SECOND_ORDER, ids=name)
@given(angle=st.floats(0.1, 1.2), friction=st.floats(0.0, 1.5))
def test_a_block_on_a_slope_slides_or_sticks_as_coulomb_says(integrator, angle, friction):
    """a = g (sin α − μ cos α) where that is positive, else it stays; and friction takes μ g cos α per meter.

    A block that starts at rest on the plane is in contact from the first step; the contact stage resolves it within a
    step, so that the velocity is off by at most what gravity gives in one.
    """
    normal = np.array([np.sin(angle), np.cos(angle)])
    downhill = np.array([np.cos(angle), -np.sin(angle)])
    plane = pc.Plane((0.0, 0.0), tuple(normal), restitution=0.0, friction=friction)
    run = simulation(pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Gravity((0.0, -G)), plane), integrator, 1e-3)
    run.step(1000)
    acceleration = max(0.0, G * (np.sin(angle) - friction * np.cos(angle)))
    assert run.velocities[0] @ downhill == pytest.approx(acceleration, abs=2.0 * G * 1e-3)
    assert run.positions[0] @ downhill == pytest.approx(acceleration / 2.0, abs=2.0 * G * 1e-3)
    assert abs(run.velocities[0] @ normal) <= G * 1e-3
    assert abs(run.positions[0] @ normal) <= 1e-9
    expected = G * friction * np.cos(angle) * acceleration / 2.0
    assert run.energy().dissipated == pytest.approx(expected, rel=0.02, abs=1e-3)


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_a_ball_that_rests_on_the_floor_stays_there(integrator):
    """Neither jitter nor creep, in 1e4 steps.

    Explicit Euler moves with the velocity before the kick: whatever it does near the floor is within one kick, g h in
    speed and g h² in place.
    """
    h = 0.005
    jitter = 9.81 * h if isinstance(integrator, pc.ExplicitEuler) else 1e-12
    run = simulation(ball(0.0, 0.5, radius=0.1), integrator, h)
    run.step(10_000)
    assert run.positions[0, 1] == pytest.approx(0.1, abs=max(jitter * h, 1e-12))
    assert abs(run.velocities[0, 1]) <= jitter


@pytest.mark.parametrize("gravity", [0.01, G, 1000.0])
def test_a_ball_comes_to_rest_when_infinitely_many_bounces_would_be_over(gravity):
    """From the speed v they take 2ev/g (1 + e + e² + …), which is 2v/g for e = ½: 1 % later it lies, and not before."""
    ball, speed = pc.Particles([[0.0, 0.0]], [[0.0, -1.0]]), 1.0
    for time, lies in ((0.99, False), (1.01, True)):
        dt = time * 2.0 * speed / gravity
        scene = pc.Scene(ball, pc.Gravity((0.0, -gravity)), pc.Floor(0.0, restitution=0.5))
        run = simulation(scene, pc.VelocityVerlet(), dt)
        run.step(1)
        assert bool((state(run) == 0.0).all()) == lies


def test_an_impulse_at_the_wall_follows_coulomb():
    """Oblique impact: Δv_t = −min(μ (1 + e) |v_n|, |v_t|) along v_t, v_n → −e v_n."""
    for velocity, friction in (([3.0, -4.0], 0.1), ([0.2, -4.0], 0.5)):
        body = pc.Particles([[0.0, 0.5]], [velocity])
        run = simulation(pc.Scene(body, pc.Floor(0.0, restitution=0.6, friction=friction)), pc.VelocityVerlet(), 0.01)
        run.step(30)
        slip = max(0.0, velocity[0] - friction * 1.6 * 4.0)
        np.testing.assert_allclose(run.velocities, [[slip, 2.4]], rtol=1e-14, atol=1e-14)
        lost = 0.5 * (velocity[0] ** 2 + 16.0 - slip**2 - 2.4**2)
        assert run.energy().dissipated_by["contacts"] == pytest.approx(lost, rel=1e-14)


def test_a_wrong_coefficient_would_be_seen():
    """The tests above are sharp: a floor that is 1 % too lively misses the heights a thousandfold."""
    honest, lively = (apexes(simulation(ball(1.0, e), pc.VelocityVerlet(), 1e-3), 1)[0] for e in (0.8, 0.808))
    assert abs(honest - 0.64) < 1e-6
    assert abs(lively - 0.64) > 1e-3
