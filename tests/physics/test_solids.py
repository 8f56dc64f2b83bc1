"""Solid obstacles: capsules, convex hulls and boxes from outside. Contacts are those of the exact shapes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import EPSILON, Array, simulation

DOWN = pc.Gravity((0.0, 0.0, -9.81))


def distances(points: Array, x: Array) -> Array:
    """The distances (N,) of points from a hull, by the planes through all triples of its vertices that have it on one
    side, and by all segments between vertices; negative within.
    """
    heights = [np.full(len(x), -np.inf)]
    nearest = np.full(len(x), np.inf)
    count = len(points)
    for i in range(count):
        for j in range(i + 1, count):
            way = points[j] - points[i]
            along = np.clip((x - points[i]) @ way / (way @ way), 0.0, 1.0)
            nearest = np.minimum(nearest, np.linalg.norm(x - points[i] - along[:, None] * way, axis=1))
            for k in range(j + 1, count):
                normal = np.cross(way, points[k] - points[i])
                sides = (points - points[i]) @ normal
                if np.linalg.norm(normal) < 1e-9 or (sides.max() > 1e-12 and sides.min() < -1e-12):
                    continue
                normal *= (-1.0 if sides.max() > 1e-12 else 1.0) / np.linalg.norm(normal)
                height = (x - points[i]) @ normal
                heights.append(height)
                foot = x - height[:, None] * normal
                corners = [points[i], points[j], points[k]]
                turns = [np.cross(corners[(c + 1) % 3] - corners[c], foot - corners[c]) @ normal for c in range(3)]
                over = np.all(np.array(turns) >= 0.0, axis=0) | np.all(np.array(turns) <= 0.0, axis=0)
                nearest = np.where(over, np.minimum(nearest, np.abs(height)), nearest)
    highest = np.max(heights, axis=0)
    return np.where(highest <= 0.0, highest, nearest)


@given(st.integers(0, 2**32 - 1), st.sampled_from(["f64", "f32"]))
def test_nothing_enters_a_hull_and_bounces_keep_the_energy(seed: int, precision: str):
    """Balls thrown at a hull from all sides bounce off its facets, edges and vertices; their energy is kept to the
    rounding of each impact, of which there are a few.
    """
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.5, 0.5, (rng.integers(4, 10), 3))
    hull = pc.ConvexHull(points)
    away = rng.normal(size=(60, 3))
    x = 1.5 * away / np.linalg.norm(away, axis=1, keepdims=True)
    v = rng.uniform(1.0, 5.0, (60, 1)) * (rng.uniform(-0.4, 0.4, (60, 3)) - x)
    radius = rng.choice([0.0, 0.1], 60)
    balls = pc.Particles(x, velocities=v, radius=radius)
    run = simulation(pc.Scene(balls, hull), pc.VelocityVerlet(), 0.01, precision=precision)
    rounding = float(np.finfo(precision.replace("f", "float")).eps)
    for _ in range(60):
        run.step()
        assert (distances(points, run.positions) - radius).min() > -16 * rounding
    speeds = np.linalg.norm(run.velocities, axis=1)
    np.testing.assert_allclose(speeds, np.linalg.norm(v, axis=1), rtol=200 * rounding)
    assert np.abs(run.velocities - v).max() > 0.1  # some have hit it


def test_a_box_from_outside_is_the_hull_of_its_corners():
    corners = np.array([[i, j, k] for i in (-0.3, 0.3) for j in (-0.2, 0.2) for k in (0.0, 0.4)])
    rng = np.random.default_rng(2)
    x = np.column_stack([rng.uniform(-0.5, 0.5, (100, 2)), rng.uniform(0.6, 1.0, 100)])
    balls = pc.Particles(x, radius=0.02)
    ends = []
    for solid in (
        pc.Box((-0.3, -0.2, 0.0), (0.3, 0.2, 0.4), inside=False, restitution=0.7, friction=0.2),
        pc.ConvexHull(corners, restitution=0.7, friction=0.2),
    ):
        run = pc.Simulation(pc.Scene(balls, solid, pc.Floor(), DOWN), dt=5e-3)
        run.run(1.0)
        ends.append(np.array(run.positions))
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)


def test_a_capsule_without_length_is_a_sphere():
    """The same bounces as on a sphere, which is solved by polynomials; small differences grow at each by the curvature,
    about 2 · 1 m/0.3 m = 7-fold, four times.
    """
    rng = np.random.default_rng(3)
    x = np.column_stack([rng.uniform(-0.2, 0.2, (50, 2)), rng.uniform(0.5, 1.0, 50)])
    ends = []
    for solid in (pc.Sphere((0.0, 0.0, 0.0), 0.3), pc.Capsule((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.3)):
        run = pc.Simulation(pc.Scene(pc.Particles(x, radius=0.05), solid, DOWN), dt=1e-3)
        run.run(0.8)
        ends.append(np.array(run.positions))
    np.testing.assert_allclose(ends[0], ends[1], atol=1e4 * 7**4 * EPSILON)


@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_a_ball_slides_off_a_table(radius: float):
    """It slides on the top with its speed, and from the edge on its path is the parabola of a throw, that of a ball of
    radius R because v² > g R.
    """
    table = pc.Box((-1.0, -0.5, 0.0), (0.0, 0.5, 1.0), inside=False)
    ball = pc.Particles([[-0.5, 0.1, 1.0 + radius]], velocities=[[2.0, 0.0, 0.0]], radius=radius)
    run = simulation(pc.Scene(ball, table, DOWN), pc.VelocityVerlet(), 0.007)
    before = run.energy().total
    run.run(0.56)
    fallen = 0.56 - 0.25  # The edge is 0.5 m away.
    expected = [2.0 * 0.56 - 0.5, 0.1, 1.0 + radius - 0.5 * 9.81 * fallen**2]
    np.testing.assert_allclose(run.positions[0], expected, atol=1e-9)
    assert run.energy().total == pytest.approx(before, rel=1e-12)


def test_a_slow_ball_rolls_round_the_edge():
    """A ball of radius R that passes an edge slower than √(g R) goes round it: it leaves where its weight no longer
    presses, cos θ = 2/3 + v²/(3 g R), as from a cylinder, and gets there in steps of 1 ms to order h. It is seen to
    have left when it is 1e-6 m away: with the rate 3 g ω sin θ of its normal acceleration after a time t of 1e-6 m = 3
    g ω sin θ t³/6, by when θ has grown by ω t.
    """
    radius, speed = 0.2, 0.3
    table = pc.Box((-1.0, -0.5, -1.0), (0.0, 0.5, 0.0), inside=False)
    ball = pc.Particles([[-0.01, 0.0, radius]], velocities=[[speed, 0.0, 0.0]], radius=radius)
    run = simulation(pc.Scene(ball, table, DOWN), pc.VelocityVerlet(), 1e-3)
    while (run.time < 2.0 and abs(np.linalg.norm(run.positions[0, [0, 2]]) - radius) < 1e-6) or run.positions[
        0, 0
    ] < 0.0:
        run.step()
    cosine = run.positions[0, 2] / np.linalg.norm(run.positions[0])
    leaves = 2.0 / 3.0 + speed**2 / (3.0 * 9.81 * radius)
    sine, turning = np.sqrt(1.0 - leaves**2), np.sqrt(9.81 * leaves / radius)
    later = np.cbrt(6e-6 / (3.0 * 9.81 * turning * sine))
    assert cosine == pytest.approx(leaves - sine * turning * later, abs=5e-3)


def test_friction_holds_on_a_ramp():
    """On a slope of 30° a block stays for μ > tan 30°, and else slides with g (sin 30° − μ cos 30°) until the foot."""
    ramp = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0 * math.tan(math.pi / 6)]]
    down = np.array([math.cos(math.pi / 6), -0.5])
    start = np.array([0.5, 1.5 * math.tan(math.pi / 6)])
    for friction, rate in ((0.7, 0.0), (0.2, 9.81 * (0.5 - 0.2 * math.cos(math.pi / 6)))):
        block = pc.Particles([start])
        scene = pc.Scene(block, pc.ConvexHull(ramp, restitution=0.0, friction=friction), pc.Gravity((0.0, -9.81)))
        run = simulation(scene, pc.VelocityVerlet(), 0.01)
        run.run(0.5)
        np.testing.assert_allclose(run.positions[0], start + 0.5 * rate * 0.25 * down, atol=1e-9)


def test_water_stands_beside_a_step():
    """A pool around a solid step comes to rest with a level surface, and nothing of it is in the step."""
    spacing = 0.025
    water = pc.Fluid(pc.block((0.0, 0.0), (1.0, 0.3), spacing), spacing)
    keep = (np.abs(water.positions[:, 0] - 0.5) > 0.2) | (water.positions[:, 1] > 0.2)
    water = pc.Fluid(water.positions[keep], spacing, viscosity=0.5)
    step = pc.Box((0.3, -0.1), (0.7, 0.2), inside=False)
    run = pc.Simulation(pc.Scene(water, step, pc.Box((0.0, 0.0), (1.0, 1.0)), pc.Gravity((0.0, -9.81))))
    run.run(1.0)
    x = run.positions
    assert not ((np.abs(x[:, 0] - 0.5) < 0.2) & (x[:, 1] < 0.2)).any()
    speed = np.linalg.norm(run.velocities, axis=1)
    assert np.sqrt((speed**2).mean()) < 0.05
    tops = [x[np.abs(x[:, 0] - middle) < 0.1, 1].max() for middle in (0.15, 0.5, 0.85)]
    assert np.ptp(tops) < spacing


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], "span an area"),
        ([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]], "span a volume"),
        (np.zeros((3, 4)), r"shape \(V, 2\)"),
    ],
)
def test_hulls_that_are_none_are_refused(points: Array, message: str):
    with pytest.raises(pc.SceneError, match=message):
        pc.ConvexHull(points)
