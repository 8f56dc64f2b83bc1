"""Rigid bodies in fluids: Archimedes' force and draft, momentum, torque, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc

G, SPACING = 9.81, 0.025
STILL = pc.WeaklyCompressible(sound_speed=25.0)
DISC = pc.Disc(0.1)
"""A disc of eight spacings across."""


def around(bodies: pc.RigidBodies, lower: tuple[float, ...], upper: tuple[float, ...], **options: float) -> pc.Fluid:
    """Water in a box around bodies."""
    points = pc.block(lower, upper, SPACING)
    return pc.Fluid(points[~bodies.contains(points)], SPACING, **options)


@pytest.mark.parametrize(
    ("shape", "turn"),
    [
        (pc.Rectangle(0.2, 0.15), {}),
        (pc.Rectangle(0.2, 0.15), {"angle": 0.5}),
        (DISC, {}),
        (pc.Polygon([(0.0, 0.0), (0.3, 0.0), (0.1, 0.1), (0.0, 0.3)]), {"angle": 1.0}),
    ],
)
def test_a_held_body_bears_the_weight_of_the_water_that_it_displaces(shape, turn):
    """ρ g A upward, and nothing sideways. The water begins half a spacing from the body, to a quarter of a spacing
    everywhere, and most of this cancels around the body: a twentieth of a spacing times its outline is left.
    """
    body = pc.RigidBody(shape, (0.4, 0.3), fixed=True, **turn)
    water = around(body, (0.0, 0.0), (0.8, 0.6), viscosity=5.0)
    scene = pc.Scene(body, water, pc.Box((0.0, 0.0), (0.8, 1.0)), pc.Gravity((0.0, -G)))
    recording = pc.simulate(scene, 1.5, fps=20, fluids=STILL)
    mean = recording[body].force[15:].mean(axis=0)
    weight = 1000.0 * G * shape.area
    outline = 4.0 * math.sqrt(shape.area)
    assert mean[1] == pytest.approx(weight, abs=0.05 * SPACING * outline * 1000.0 * G)
    assert abs(mean[0]) < 0.05 * SPACING * outline * 1000.0 * G


@pytest.mark.parametrize("density", [300.0, 700.0])
def test_a_box_floats_with_archimedes_draft(density):
    """The box, released with a tilt, comes to be level, and draws ρ/ρ₀ of its height in the mean of its last heaves: to
    3 % of the height, a quarter of the spacing. The level follows from the volume of the water.
    """
    width, height, room = 0.4, 0.2, 0.8
    draft = density / 1000.0 * height
    box = pc.RigidBody(pc.Rectangle(width, height), (0.4, 0.44), angle=0.1, density=density)
    water = around(box, (0.0, 0.0), (room, 0.4), viscosity=8.0)
    scene = pc.Scene(box, water, pc.Box((0.0, 0.0), (room, 1.0)), pc.Gravity((0.0, -G)))
    recording = pc.simulate(scene, 4.0, fps=20, fluids=pc.WeaklyCompressible(sound_speed=40.0))
    level = (len(water) * SPACING**2 + width * draft) / room
    center = recording[box].positions[-30:, 0, 1].mean()
    assert level - (center - 0.5 * height) == pytest.approx(draft, abs=0.03 * height)
    assert np.abs(recording[box].angles[-30:]).max() < 0.02
    assert np.abs(recording[box].velocities[-30:]).max() < 0.1


def test_a_cube_floats_in_space():
    """As in the plane, with half a percent for a tank whose depth is ten cells of water."""
    edge, room, spacing, density = 0.3, 0.6, 0.05, 500.0
    box = pc.RigidBody(pc.Cuboid(edge, edge, edge), (0.3, 0.3, 0.4), density=density)
    points = pc.block((0.0, 0.0, 0.0), (room, room, 0.4), spacing)
    water = pc.Fluid(points[~box.contains(points)], spacing, viscosity=15.0)
    tank = pc.Box((0.0, 0.0, 0.0), (room, room, 1.0))
    recording = pc.simulate(
        pc.Scene(box, water, tank, pc.Gravity((0.0, 0.0, -G))),
        2.5,
        fps=20,
        fluids=pc.WeaklyCompressible(sound_speed=30.0),
    )
    draft = density / 1000.0 * edge
    level = (len(water) * spacing**3 + edge**2 * draft) / room**2
    center = recording[box].positions[-20:, 0, 2].mean()
    assert level - (center - 0.5 * edge) == pytest.approx(draft, abs=0.03 * edge)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_drop_and_the_body_that_it_hits_keep_their_momentum(dimension):
    """Both momenta to rounding: every pair pushes with opposite forces along the line between its ends."""
    if dimension == 2:
        body = pc.RigidBody(pc.Rectangle(0.3, 0.2), (0.0, 0.0), angle=0.4, angular_velocity=3.0, density=600.0)
    else:
        body = pc.RigidBody(
            pc.Cuboid(0.3, 0.2, 0.25), (0.0, 0.0, 0.0), angular_velocity=(1.0, 3.0, -2.0), density=600.0
        )
    size = (0.1, 0.12, 0.1)[:dimension]
    corner = (0.25, -0.02, -0.05)[:dimension]
    upper = tuple(low + length for low, length in zip(corner, size, strict=True))
    speed = (-3.0, 0.4, 0.0)[:dimension]
    drop = pc.Fluid.block(corner, upper, SPACING, velocities=speed)
    run = pc.Simulation(pc.Scene(body, drop), precision="f64", fluids=pc.WeaklyCompressible(sound_speed=40.0))
    momentum, spin = run.momentum(), run.angular_momentum()
    start = run[body].angular_velocities.copy()
    run.run(0.15)
    assert np.abs(run[body].angular_velocities - start).max() > 0.1  # it was hit off its center
    scale = float(drop.mass.sum()) * 3.0
    np.testing.assert_allclose(run.momentum(), momentum, atol=1e-12 * scale)
    np.testing.assert_allclose(run.angular_momentum(), spin, atol=1e-11 * scale)


def test_a_heavy_disc_falls_to_the_bottom_of_a_tank():
    """Its way ends on the floor, no water is in it, and the energy budget closes to a hundredth of the fall.

    The budget is that until jets of water meet under the disc after 0.63 s and compress the water there by a tenth.
    """
    disc = pc.RigidBody(DISC, (0.4, 0.75), density=3000.0, restitution=0.0)
    water = around(disc, (0.0, 0.0), (0.8, 0.5), viscosity=2.0)
    tank = pc.Box((0.0, 0.0), (0.8, 1.2), restitution=0.0, friction=0.5)
    recording = pc.simulate(pc.Scene(disc, water, tank, pc.Gravity((0.0, -G))), 1.5, fps=20)
    assert recording[disc].positions[-1, 0, 1] == pytest.approx(0.1, abs=1e-3)
    away = np.linalg.norm(recording.positions[-1] - recording[disc].positions[-1], axis=1)
    assert away.min() > 0.1 - 0.25 * SPACING
    fall = float(disc.mass[0]) * G * 0.65
    balance = recording.energy.balance[recording.times <= 0.6]
    assert np.abs(balance - balance[0]).max() < 0.01 * fall


def test_a_turned_paddle_supplies_what_the_water_dissipates():
    """The work of its shaft is the integral of torque times rate: the kinetic energy and the heat of the water."""
    paddle = pc.RigidBody(pc.Rectangle(0.4, 0.1), (0.4, 0.4), fixed=True, angular_velocity=3.0)
    water = around(paddle, (0.0, 0.0), (0.8, 0.8), viscosity=20.0)
    tank = pc.Box((0.0, 0.0), (0.8, 0.8), no_slip=True)
    recording = pc.simulate(pc.Scene(paddle, water, tank), 1.0, fps=20, fluids=STILL)
    energy = recording.energy
    assert energy.work[-1] > 10.0
    assert np.abs(energy.balance - energy.balance[0]).max() < 0.01 * energy.work[-1]


@pytest.mark.parametrize("phase", [0.25, 0.5, 0.75])
def test_the_density_around_a_body_that_bounces_follows_its_mean_motion(phase):
    """A disc that hits a post after a part τ of a step moves by V h (2 τ − 1), and so does the density change.

    What is left is of second order in V h, which is one hundredth of the spacing.
    """
    speed, dt = 1.0, 0.01 * SPACING
    disc = pc.RigidBody(DISC, (0.2, 0.2), velocity=(speed, 0.0), mass=1e6, friction=0.0, restitution=1.0)

    def changes(gap: float) -> np.ndarray:
        post = pc.RigidBody(pc.Rectangle(0.02, 0.02), (0.31 + gap, 0.2), fixed=True)
        points = pc.block((0.0, 0.0), (0.4, 0.4), SPACING)
        water = pc.Fluid(points[~disc.contains(points) & ~post.contains(points)], SPACING)
        simulation = pc.Simulation(pc.Scene(disc, post, water), dt=dt, fluids=STILL)
        before = simulation[water].densities.copy()
        simulation.step(1)
        return simulation[water].densities - before

    free, bounced = changes(2.0 * speed * dt), changes(phase * speed * dt)
    assert np.abs(free).max() > 1.0
    assert np.abs(bounced - (2.0 * phase - 1.0) * free).max() < 0.01 * np.abs(free).max()


def test_a_scene_turned_by_a_quarter_moves_the_same():
    """With gravity along x: the samples of a body turn with it."""

    def run(turn: bool) -> tuple[np.ndarray, np.ndarray]:
        def at(x: float, y: float) -> tuple[float, float]:
            return (-y, x) if turn else (x, y)

        body = pc.RigidBody(pc.Rectangle(0.2, 0.15), at(0.3, 0.5), angle=0.3 + 0.5 * math.pi * turn, density=500.0)
        points = pc.block((0.0, 0.0), (0.6, 0.35), SPACING)
        points = np.column_stack([-points[:, 1], points[:, 0]]) if turn else points
        corners = np.array([at(0.0, 0.0), at(0.6, 1.0)])
        scene = pc.Scene(
            body,
            pc.Fluid(points, SPACING),
            pc.Box(tuple(corners.min(axis=0)), tuple(corners.max(axis=0))),
            pc.Gravity(at(0.0, -G)),
        )
        simulation = pc.Simulation(scene, dt=2e-4, precision="f64", fluids=pc.WeaklyCompressible(sound_speed=40.0))
        simulation.step(1000)
        place, angle = simulation[body].positions[0], simulation[body].angles[0]
        back = np.array([place[1], -place[0]]) if turn else place
        return back, angle - 0.5 * math.pi * turn

    (place, angle), (other, turned) = run(False), run(True)
    np.testing.assert_allclose(other, place, atol=1e-10)
    assert turned == pytest.approx(angle, abs=1e-9)


def test_fluid_in_a_body_is_refused_with_its_number_and_the_cure():
    box = pc.RigidBody(pc.Rectangle(0.2, 0.2), (0.5, 0.5))
    water = pc.Fluid.block((0.0, 0.0), (1.0, 0.5), spacing=0.05)
    with pytest.raises(pc.SceneError, match=r"bodies\[1\].positions: .*8 of 200 .*bodies\[0\].*contains"):
        pc.Simulation(pc.Scene(box, water), fluids=STILL)
    free = pc.Fluid(water.positions[~box.contains(water.positions)], 0.05)
    assert len(free) == 192
    pc.Simulation(pc.Scene(box, free), fluids=STILL)
    pc.Simulation(pc.Scene(box, pc.Fluid(water.positions, 0.05, obstacles=False)), fluids=STILL)


def test_points_in_bodies_are_those_within_their_surface():
    """Against the closed form of a turned box, and of balls."""
    rng = np.random.default_rng(1)
    points = rng.uniform(-1.0, 1.0, (2000, 2))
    box = pc.RigidBody(pc.Rectangle(0.8, 0.4), (0.1, 0.2), angle=0.7)
    away = points - (0.1, 0.2)
    x, y = away @ (math.cos(0.7), math.sin(0.7)), away @ (-math.sin(0.7), math.cos(0.7))
    inside = (np.abs(x) < 0.4) & (np.abs(y) < 0.2)
    np.testing.assert_array_equal(box.contains(points), inside)
    space = rng.uniform(-1.0, 1.0, (2000, 3))
    balls = pc.RigidBodies(pc.Ball(0.4), [(0.5, 0.0, 0.0), (-0.5, 0.0, 0.0)])
    near = np.minimum(
        np.linalg.norm(space - balls.positions[0], axis=1), np.linalg.norm(space + balls.positions[0], axis=1)
    )
    np.testing.assert_array_equal(balls.contains(space), near <= 0.4)
    with pytest.raises(pc.SceneError, match=r"contains\.points"):
        balls.contains(points)


def test_a_plate_thinner_than_the_kernel_is_mentioned_with_the_cure():
    plate = pc.RigidBody(pc.Rectangle(0.5, 0.02), (0.4, 0.6))
    water = pc.Fluid.block((0.0, 0.0), (0.8, 0.4), spacing=0.05)
    notes = pc.Simulation(pc.Scene(plate, water), fluids=STILL).plan.notes
    (note,) = [note for note in notes if note.startswith("bodies[0]")]
    assert "thick" in note
    assert "spacing of" in note
