"""Rods at walls: impulses in closed form, lengths, who is outside, support, and the energy budget of impacts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import EPSILON, Array
from physics.test_rods import network

INF = math.inf
G = 9.81


def missed(run: pc.Simulation, body: pc.SpringNetwork) -> float:
    """The largest relative error of a rod's length."""
    ends = body.pairs[body.rods]
    length = np.linalg.norm(np.diff(run[body].positions[ends], axis=1)[:, 0], axis=1)
    return float(np.abs(length / body.rest_length[body.rods] - 1.0).max())


def rod(angle: float, height: float, speed: float, masses: tuple[float, float], dimension: int = 2) -> pc.SpringNetwork:
    """A rod of a meter at an angle from the horizontal, whose lower end is so high and falls so fast."""
    arm = np.zeros(dimension)
    arm[0], arm[-1] = math.cos(angle), math.sin(angle)
    low = height * np.eye(dimension)[-1]
    return pc.SpringNetwork([low, low + arm], [[0, 1]], INF, mass=masses, velocities=-speed * np.eye(dimension)[-1])


@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("angle", [0.4, 1.1, math.pi / 2])
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_impulse_on_the_end_of_a_rod(restitution, angle, dimension):
    """With the rod's direction r and its impulse λ = p r_y m₂/(m₁ + m₂), the lower end leaves with e V for
    p = (1 + e) V m₁/(1 − r_y² m₂/(m₁ + m₂)); the energy that is lost is (1 − e²) V p/2 (1 + e). Rods turn by at most
    (V h/L) in the step of the impact, by as much are velocities off.
    """
    speed, masses, h = 2.0, (1.0, 3.0), 1e-4
    body = rod(angle, 0.0505, speed, masses, dimension)
    run = pc.Simulation(pc.Scene(body, pc.Floor(restitution=restitution)), dt=h)
    start = run.energy()
    run.run(0.0254)
    total, up = sum(masses), math.sin(angle)
    impulse = (1.0 + restitution) * speed * masses[0] / (1.0 - up**2 * masses[1] / total)
    pull = impulse * up * masses[1] / total
    arm, vertical = (body.positions[1] - body.positions[0]), np.eye(dimension)[-1]
    expected = np.array(
        [
            -speed * vertical + (impulse * vertical - pull * arm) / masses[0],
            -speed * vertical + pull * arm / masses[1],
        ]
    )
    assert np.abs(run.velocities - expected).max() < 20.0 * speed**2 * 5 * h
    lost = 0.5 * (1.0 - restitution) * speed * impulse
    energy = run.energy()
    assert energy.dissipated_by["contacts"] == pytest.approx(lost, abs=40.0 * speed**3 * h)
    assert energy.balance == pytest.approx(start.balance, abs=40.0 * speed**3 * h)
    assert np.abs(run.momentum()[:-1]).max() < 10 * EPSILON * total * speed
    assert missed(run, body) < 10 * EPSILON


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_a_rod_that_falls_flat_bounces_as_a_particle_does(restitution):
    """Both ends meet the floor at once: the rod does nothing. Of order 2 in the step."""
    h = 1e-3
    runs = []
    for body in (rod(0.0, 0.5, 0.0, (1.0, 2.0)), pc.Particles([[0.0, 0.5]], mass=3.0)):
        runs.append(pc.Simulation(pc.Scene(body, pc.Gravity((0.0, -G)), pc.Floor(restitution=restitution)), dt=h))
        runs[-1].run(0.6)
    rods, ball = runs
    assert np.abs(rods.positions[:, 1] - ball.positions[0, 1]).max() < 2.0 * G * h * h
    assert np.abs(rods.velocities[:, 1] - ball.velocities[0, 1]).max() < 2.0 * G * h
    lost = ball.energy().dissipated_by["contacts"]
    assert rods.energy().dissipated_by["contacts"] == pytest.approx(lost, abs=3.0 * G * 4.0 * h)
    assert np.ptp(rods.positions[:, 1]) < 10 * EPSILON


def test_what_lies_on_a_floor_stays_and_loses_nothing():
    """A chain of which every node touches, and an upright rod on its tip, which a second one braces."""
    nodes = [[0.1 * k, 0.0] for k in range(6)] + [[0.2, 0.3]]
    pairs = [*([k, k + 1] for k in range(5)), [1, 6], [3, 6]]
    body = pc.SpringNetwork(nodes, pairs, INF, mass=[0.1, 0.3, 0.2, 0.1, 0.4, 0.1, 1.0])
    run = pc.Simulation(pc.Scene(body, pc.Gravity((0.0, -G)), pc.Floor(restitution=0.7)), dt=1e-3)
    # Two feet on a floor without friction slide apart; the chain between them holds them.
    run.step(500)
    assert np.abs(run.positions - body.positions).max() < 1e3 * EPSILON
    assert abs(run.energy().dissipated) < 1e3 * EPSILON


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_a_chain_pours_onto_a_floor_and_comes_to_rest(precision):
    """Lengths hold in every frame, nobody is below the floor, and momentum along the floor is kept to rounding."""
    nodes = np.column_stack([0.02 * (np.arange(21) % 2), 0.05 + 0.05 * np.arange(21)])
    body = pc.SpringNetwork(nodes, np.column_stack([np.arange(20), np.arange(1, 21)]), INF, mass=0.05)
    run = pc.Simulation(pc.Scene(body, pc.Gravity((0.0, -G)), pc.Floor(restitution=0.0)), dt=5e-4, precision=precision)
    start, unit = run.energy().balance, float(np.finfo(precision.replace("f", "float")).eps)
    for _ in range(60):
        run.step(20)
        assert missed(run, body) < (1e-12 if precision == "f64" else 1e-5)
        assert run.positions[:, 1].min() > -4.0 * unit
    assert abs(run.momentum()[0]) < 1e3 * unit
    assert run.energy().dissipated_by["contacts"] > 0.3 * 0.05 * 21 * G * 0.5
    assert run.energy().balance == pytest.approx(start, abs=0.02 * 21 * 0.05 * G * 0.5)


@pytest.mark.parametrize(
    "walls",
    [
        [pc.Box((-1.0, -1.0), (4.0, 4.0), restitution=0.5)],
        [pc.Sphere((1.5, 1.5), 3.5, inside=True, restitution=0.3)],
        [pc.Floor(-1.2, restitution=0.8), pc.Sphere((1.5, -1.5), 1.0, inside=False, restitution=0.8)],
    ],
    ids=["in a box", "in a sphere", "on a ball on a floor"],
)
def test_a_network_among_walls(walls):
    """Rods and springs, loops and redundant rods."""
    for seed in range(4):
        body = network(seed, 2, fixed=False, elastic=True, redundant=True)
        run = pc.Simulation(pc.Scene(body, pc.Gravity((0.0, -G)), *walls), dt=1e-3)
        before = run.energy()
        for _ in range(30):
            run.step(50)
            assert missed(run, body) < 1e3 * EPSILON
            assert outside(run.positions, walls) < 20.0 * EPSILON
        energy = run.energy()
        assert energy.dissipated_by["contacts"] > 0.0
        assert energy.balance == pytest.approx(before.balance, abs=0.03 * (before.kinetic + body.mass.sum() * G * 2.0))


def outside(x: Array, walls: list[pc.Boundary]) -> float:
    """How far the worst particle is outside [m]."""
    worst = 0.0
    for wall in walls:
        if isinstance(wall, pc.Box):
            worst = max(worst, float((np.array(wall.lower) - x).max()), float((x - np.array(wall.upper)).max()))
        elif isinstance(wall, pc.Floor):
            worst = max(worst, float(wall.height - x[:, -1].min()))
        elif isinstance(wall, pc.Sphere):
            distance = np.linalg.norm(x - np.array(wall.center), axis=1) - wall.radius
            worst = max(worst, float((distance if wall.inside else -distance).max()))
    return worst


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    dimension=st.sampled_from([2, 3]),
    restitution=st.sampled_from([0.0, 0.4, 1.0]),
    redundant=st.booleans(),
)
def test_any_network_over_a_floor(seed, dimension, restitution, redundant):
    """Lengths hold, nobody is below, momentum along the floor is kept, and what contacts take is no gain of energy."""
    body = network(seed, dimension, fixed=False, elastic=False, redundant=redundant)
    floor = pc.Floor(float(body.positions[:, -1].min()) - 0.3, restitution=restitution)
    run = pc.Simulation(pc.Scene(body, pc.Gravity(-G * np.eye(dimension)[-1]), floor), dt=1e-3)
    momentum, before = run.momentum()[:-1], run.energy()
    for _ in range(16):
        run.step(50)
        assert missed(run, body) < 1e3 * EPSILON
        assert outside(run.positions, [floor]) <= 20.0 * EPSILON
    scale = float(body.mass.sum()) * 5.0
    assert np.abs(run.momentum()[:-1] - momentum).max() < 1e4 * EPSILON * scale
    size = before.kinetic + float(body.mass.sum()) * G * 4.0
    energy = run.energy()
    assert energy.dissipated_by["contacts"] > -0.01 * size
    assert energy.balance == pytest.approx(before.balance, abs=0.03 * size)


def test_the_balance_of_impacts_closes_with_the_step():
    """A tumbling rod bounces some ten times: of order 1 in the mean over phases of its impacts."""
    errors = []
    for h in (2e-3, 2.5e-4):
        drift = []
        for height in np.linspace(0.4, 0.5, 8):
            body = rod(0.7, height, 0.0, (1.0, 2.0))
            run = pc.Simulation(pc.Scene(body, pc.Gravity((0.0, -G)), pc.Floor(restitution=0.8)), dt=h)
            start = run.energy().balance
            run.run(1.0)
            drift.append(run.energy().balance - start)
        errors.append(float(np.sqrt(np.mean(np.square(drift)))))
    assert errors[1] < 0.35 * errors[0]
    assert errors[1] < 0.01 * 3.0 * G * 0.5


def test_tensions_count_what_walls_bear():
    """An upright rod on a floor bears the weight of its upper end; a chain that hangs down to it, what it has to."""
    upright = pc.SpringNetwork([[0.0, 0.0], [0.0, 1.0]], [[0, 1]], INF, mass=[1.0, 3.0])
    nodes = [[1.0, 1.0], [1.0, 0.5], [1.0, 0.0]]
    hung = pc.SpringNetwork(nodes, [[0, 1], [1, 2]], INF, mass=2.0, fixed=[0])
    run = pc.Simulation(pc.Scene(upright, hung, pc.Gravity((0.0, -10.0)), pc.Floor()), dt=1e-3)
    run.step(3)
    np.testing.assert_allclose(run[upright].tensions, [-30.0], rtol=1e-9)
    # Floor and rods share the weight of the lowest node, T₂ = 20 − N, by least norm; T₁ = T₂ + 20.
    one, other = run[hung].tensions
    assert one - other == pytest.approx(20.0, rel=1e-9)
    assert -1e-9 <= other <= 20.0 + 1e-9


def test_a_radius_keeps_its_distance_and_others_meet_their_walls_alone():
    """Of two bodies that a floor acts on, one of rods: the other bounces as it does without the first."""
    body = rod(0.3, 0.3, 0.0, (1.0, 1.0))
    round_ends = pc.SpringNetwork(body.positions, body.pairs, INF, mass=1.0, radius=0.05)
    ball = pc.Particles([[3.0, 0.4]], radius=0.1)
    floor, gravity = pc.Floor(restitution=0.5), pc.Gravity((0.0, -G))
    both = pc.Simulation(pc.Scene(round_ends, ball, gravity, floor), dt=1e-3)
    alone = pc.Simulation(pc.Scene(ball, gravity, floor), pc.VelocityVerlet(), dt=1e-3)
    lowest = INF
    for _ in range(300):
        both.step()
        alone.step()
        lowest = min(lowest, float(both.positions[:2, 1].min()))
    assert 0.05 - 10 * EPSILON <= lowest < 0.0525
    assert np.abs(both.positions[2] - alone.positions[0]).max() < 100 * EPSILON
    assert both.plan.order == 1
    assert "contacts" in both.plan.stages


def test_walls_that_leave_no_room_are_no_step():
    """A rod between a fixed end and a floor that rises above what it can reach."""
    body = pc.SpringNetwork([[0.0, 1.0], [0.0, 0.2]], [[0, 1]], INF, fixed=[0], velocities=[[0.0, -1.0], [0.0, -1.0]])
    run = pc.Simulation(pc.Scene(body, pc.Plane((0.0, 0.0), (0.0, 1.0)), pc.Plane((0.0, 2.0), (0.0, -1.0))), dt=1e-2)
    with pytest.raises(pc.SimulationDiverged, match=r"walls leave them no room"):
        run.run(1.0)
