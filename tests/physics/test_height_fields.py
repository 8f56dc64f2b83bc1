"""Height fields: ground of cells that are not felt. Random ground is in the engine's own tests."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import Array, simulation

DOWN = {2: pc.Gravity((0.0, -9.81)), 3: pc.Gravity((0.0, 0.0, -9.81))}


def ground(dimension: int, slope: float, **options: float) -> pc.HeightField:
    """Ground of cells of 0.1 m that rises along x."""
    if dimension == 2:
        return pc.HeightField.over(lambda x: slope * x, -3.0, 3.0, 0.1, **options)
    return pc.HeightField.over(lambda x, y: slope * x + 0.0 * y, (-3.0, -3.0), (3.0, 3.0), 0.1, **options)


def thrown(dimension: int, seed: int, radius: float) -> pc.Particles:
    """Balls above the middle."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-0.5, 0.5, (40, dimension))
    x[:, -1] += 1.0
    return pc.Particles(x, velocities=rng.uniform(-1.0, 1.0, x.shape), radius=radius)


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("radius", [0.0, 0.05])
@pytest.mark.parametrize("slope", [0.0, 0.3])
@pytest.mark.parametrize("dimension", [2, 3])
def test_ground_in_a_plane_is_that_plane(dimension: int, slope: float, radius: float, precision: str):
    """The same bounces and slides. Heights are rounded, so that a slope of cells of 0.1 m is off by some ten roundings,
    and what a second of bounces makes of these is a hundred times as much.
    """
    normal = (-slope, 1.0) if dimension == 2 else (-slope, 0.0, 1.0)
    ends = []
    for wall in (ground(dimension, slope, restitution=0.6), pc.Plane((0.0,) * dimension, normal, restitution=0.6)):
        scene = pc.Scene(thrown(dimension, 1, radius), wall, DOWN[dimension])
        run = simulation(scene, pc.VelocityVerlet(), 0.01, precision=precision)
        run.run(1.0)
        ends.append(np.array(run.positions))
    rounding = float(np.finfo(precision.replace("f", "float")).eps)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e3 * rounding)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_ball_rolls_over_cells_as_if_there_were_none(dimension: int):
    """Straight on, with the speed and the height that it had, over fifty cells and their edges."""
    speed = 2.0 if dimension == 2 else np.array([2.0, 1.3])
    start = [-2.5, 0.05] if dimension == 2 else [-2.5, -2.0, 0.05]
    ball = pc.Particles([start], velocities=[[*np.atleast_1d(speed), 0.0]], radius=0.05)
    run = simulation(
        pc.Scene(ball, ground(dimension, 0.0, restitution=0.0), DOWN[dimension]), pc.VelocityVerlet(), 0.01
    )
    run.run(2.4)
    expected = np.array(start)
    expected[:-1] += 2.4 * speed
    # Each of 240 steps rounds the place, as does each of a hundred edges.
    np.testing.assert_allclose(run.positions[0], expected, atol=340 * 4 * np.finfo(float).eps)
    np.testing.assert_allclose(run.velocities[0], [*np.atleast_1d(speed), 0.0], atol=1e-13)


def test_balls_roll_in_a_bowl_and_their_energy_is_accounted_for():
    """What valleys between cells take from balls that do not bounce counts as dissipated; slides around edges are of
    second order in the step, and the edges of this bowl are blunt.
    """
    rng = np.random.default_rng(2)
    bowl = pc.HeightField.over(lambda x, y: 0.5 * (x * x + y * y), (-1.5, -1.5), (1.5, 1.5), 0.1, restitution=0.0)
    x = rng.uniform(-0.8, 0.8, (30, 2))
    balls = pc.Particles(np.column_stack([x, 0.15 + 0.5 * (x * x).sum(axis=1)]), radius=0.05)
    recording = pc.simulate(pc.Scene(balls, bowl, DOWN[3]), 4.0, fps=10, dt=2e-3)
    assert np.abs(recording.energy.drift).max() < 1e-6
    assert recording.energy.dissipated[-1] > 0.0
    x = recording.positions
    assert (x[..., 2] > 0.5 * (x[..., :2] ** 2).sum(axis=-1)).all()


@given(st.integers(0, 2**32 - 1))
def test_a_mirror_image_of_the_ground_mirrors_the_motion(seed: int):
    """Balls bounce off facets, which keep angles: small differences grow at edges alone, which points do not feel."""
    rng = np.random.default_rng(seed)
    heights = rng.uniform(-0.1, 0.1, (13, 9))
    ends = []
    for sign in (1.0, -1.0):
        land = pc.HeightField(heights[:: int(sign)], 0.25, (-1.5, -1.0), restitution=0.3)
        balls = thrown(3, seed, 0.0)
        mirrored = pc.Particles(balls.positions * [sign, 1.0, 1.0], velocities=balls.velocities * [sign, 1.0, 1.0])
        run = simulation(pc.Scene(mirrored, land, DOWN[3]), pc.VelocityVerlet(), 0.01)
        run.run(0.55)
        ends.append(np.array(run.positions) * [sign, 1.0, 1.0])
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)


def test_beside_the_ground_there_is_nothing():
    """What goes over the border falls, and what comes back to the side below bounces off it."""
    table = pc.HeightField([0.0, 0.0], 1.0)
    balls = pc.Particles([[0.5, 0.1], [2.0, -1.0]], velocities=[[2.0, 0.0], [-2.0, 0.0]], radius=0.1)
    run = simulation(pc.Scene(balls, table), pc.VelocityVerlet(), 0.01)
    run.run(1.0)
    np.testing.assert_allclose(run.positions, [[2.5, 0.1], [2.2, -1.0]], atol=1e-12)
    run = simulation(pc.Scene(balls, table, DOWN[2]), pc.VelocityVerlet(), 0.01)
    run.run(1.0)
    fallen = 1.0 - 0.25  # v² > g R: it leaves the ground at the border.
    # When it leaves the border is found to the root of rounding, 2e-8 s.
    assert run.positions[0, 1] == pytest.approx(0.1 - 0.5 * 9.81 * fallen**2, abs=2e-7)


@pytest.mark.parametrize("depth", [1e-3, 0.3, 50.0])
def test_what_starts_in_the_ground_is_refused(depth: float):
    heights: Array = 0.1 * np.cos(np.arange(12.0))
    for dimension, land in ((2, pc.HeightField(heights, 0.5)), (3, pc.HeightField(np.tile(heights, (5, 1)).T, 0.5))):
        place = [2.6, 1.1, -0.1 - depth] if dimension == 3 else [2.6, -0.1 - depth]
        with pytest.raises(pc.SceneError, match=r"bodies\[0\].positions\[0\].*\(height field\)"):
            pc.Simulation(pc.Scene(pc.Particles([place]), land, DOWN[dimension]))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1.0], 1.0), "HeightField.heights: must have the shape"),
        (([[1.0, 2.0]], 1.0), "at least two nodes"),
        (([[1.0, 2.0], [np.inf, 0.0]], 1.0), r"HeightField.heights\[1, 0\]: must be finite"),
        (([1.0, 2.0], 0.0), "HeightField.spacing: must be > 0"),
        (([1.0, 2.0], 1.0, (0.0, 0.0)), "HeightField.origin: must be one number"),
    ],
)
def test_ground_that_is_none_is_refused(arguments: tuple[object, ...], message: str):
    with pytest.raises(pc.SceneError, match=message):
        pc.HeightField(*arguments)  # type: ignore[arg-type]


def test_a_function_gives_the_heights_of_nodes():
    land = pc.HeightField.over(lambda x, y: x + 10.0 * y, (0.0, 1.0), (1.0, 3.1), 0.5)
    assert land.heights.shape == (3, 5)
    np.testing.assert_allclose(land.nodes[1, 2], [0.5, 2.0, 20.5])
    with pytest.raises(pc.SceneError, match="the function raised"):
        pc.HeightField.over(lambda x: x, (0.0, 0.0), (1.0, 1.0), 0.5)
    with pytest.raises(pc.SceneError, match=r"HeightField.upper: must be 1 to"):
        pc.HeightField.over(lambda x: x, 0.0, 0.1, 0.5)
    with pytest.raises(pc.SceneError, match=r"HeightField.spacing: .* nodes take .* GB"):
        pc.HeightField.over(lambda x, y: x + y, (0.0, 0.0), (1.0, 1.0), 1e-6)


def test_a_scene_of_another_dimension_is_refused():
    with pytest.raises(pc.SceneError, match=r"boundaries\[0\].heights"):
        pc.Scene(pc.Particles([[0.0, 1.0, 0.0]]), pc.HeightField([0.0, 1.0], 1.0))


def test_it_is_no_wall_of_fluids():
    water = pc.Fluid(pc.block((0.0, 0.0), (0.4, 0.4), 0.1), 0.1)
    stone = pc.Particles([[0.5, 1.0]], name="stone")
    with pytest.raises(pc.SceneError, match=r"boundaries\[0\].on: a height field is no wall of fluids"):
        pc.Scene(water, stone, pc.HeightField([-0.1, -0.1], 1.0))
    pc.Scene(water, stone, pc.HeightField([-0.1, -0.1], 1.0, on="stone"))
