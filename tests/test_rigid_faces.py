"""Rigid bodies that meet the faces of cloth and soft bodies between the particles."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc

G = 9.81
QUARTER = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
"""Orientation of an axis along y that was along z."""
FLAT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


def trampoline(**options):
    """A net of cells of 0.1 m, held at its rim."""
    return pc.cloth(
        (7, 7),
        0.1,
        2000.0,
        mass=0.01,
        origin=(-0.3, -0.3, 0.0),
        axes=FLAT,
        pinned=("top", "bottom", "left", "right"),
        **options,
    )


@pytest.mark.parametrize("place", [(0.03, 0.06), (0.05, 0.05), (0.05, 0.0)], ids=["triangle", "diagonal", "side"])
def test_a_ball_smaller_than_the_cells_of_a_net_bounces(place):
    """A ball of a fifth of the cell falls on a triangle, and on its sides. It comes back, and never passes.

    Springs without damping give most of the energy back. Contacts dissipate what impacts on light corners take.
    """
    net = trampoline()
    ball = pc.RigidBody(pc.Ball(0.02), (*place, 0.15), mass=0.05, restitution=0.5)
    run = pc.simulate(pc.Scene(net, ball, pc.Gravity((0.0, 0.0, -G))), 0.6, dt=1 / 4000, fps=200)
    heights = run[ball].positions[:, 0, 2]
    assert heights.min() > -0.15
    assert heights[int(np.argmin(heights)) :].max() > 0.02
    assert np.abs(run.energy.drift).max() < 1e-3
    assert run.energy.dissipated_by["contacts"][-1] > 0.0


def test_a_ball_and_the_faces_of_a_free_cloth_keep_their_momenta():
    """A ball flies into the middle of a coarse triangle. 2400 steps round a momentum of 0.3 kg·m/s.

    Impulses on particles, which do not turn, act beside them by the gaps of contacts of 1e-6 of the ball: angular
    momentum changes by 1e-9.
    """
    cloth = pc.cloth((4, 4), 0.2, 100.0, mass=0.02, damping=0.02, origin=(-0.3, -0.3, 0.0), axes=FLAT)
    ball = pc.RigidBody(pc.Ball(0.03), (0.03, -0.04, 0.1), velocity=(0.4, 0.1, -3.0), mass=0.1, friction=0.3)
    run = pc.simulate(pc.Scene(cloth, ball), 0.6, dt=1 / 4000, fps=100)
    assert np.abs(run.momentum - run.momentum[0]).max() < 1e-14
    assert np.abs(run.angular_momentum - run.angular_momentum[0]).max() < 1e-9
    assert np.abs(run.energy.drift).max() < 1e-3
    assert run[ball].positions[-1, 0, 2] > run[cloth].positions[-1, :, 2].mean()


@pytest.mark.parametrize("friction", [0.2, 0.8])
def test_a_box_slides_down_a_sheet_as_down_a_plane(friction):
    """A sheet that is held everywhere is a plane of triangles, larger than the box on it: no side of them is felt.

    The box slides with g (sin θ − μ cos θ), or stays.
    """
    slope = math.radians(20.0)
    along, up = np.array([math.cos(slope), 0.0, -math.sin(slope)]), np.array([math.sin(slope), 0.0, math.cos(slope)])
    sheet = pc.cloth((12, 5), 0.13, 100.0, origin=(0.0, -0.25, 0.0), axes=(along, (0.0, 1.0, 0.0)), pinned=range(60))
    half = 0.5 * slope
    box = pc.RigidBody(
        pc.Cuboid(0.1, 0.08, 0.04),
        0.2 * along + 0.02 * up + (0.0, 0.01, 0.0),
        orientation=(math.cos(half), 0.0, math.sin(half), 0.0),
        friction=friction,
    )
    run = pc.simulate(pc.Scene(sheet, box, pc.Gravity((0.0, 0.0, -G))), 0.6, dt=1 / 1000, fps=50)
    moved = run[box].positions[:, 0] - run[box].positions[0, 0]
    acceleration = G * max(0.0, math.sin(slope) - friction * math.cos(slope))
    assert np.abs(moved @ along - 0.5 * acceleration * run.times**2).max() < 1e-6
    assert np.abs(moved @ up).max() < 1e-6


def test_a_ball_rolls_down_a_sheet_as_down_a_plane():
    """Without slip with 5/7 of g sin θ; sides that it crosses do not lift it."""
    slope = math.radians(20.0)
    along, up = np.array([math.cos(slope), 0.0, -math.sin(slope)]), np.array([math.sin(slope), 0.0, math.cos(slope)])
    sheet = pc.cloth((12, 5), 0.13, 100.0, origin=(0.0, -0.25, 0.0), axes=(along, (0.0, 1.0, 0.0)), pinned=range(60))
    ball = pc.RigidBody(pc.Ball(0.03), 0.2 * along + 0.03 * up + (0.0, 0.01, 0.0), friction=0.8)
    run = pc.simulate(pc.Scene(sheet, ball, pc.Gravity((0.0, 0.0, -G))), 0.8, dt=1 / 1000, fps=50)
    moved = run[ball].positions[:, 0] - run[ball].positions[0, 0]
    assert np.abs(moved @ along - 0.5 * 5.0 / 7.0 * G * math.sin(slope) * run.times**2).max() < 1e-5
    assert np.abs(moved @ up).max() < 1e-6


def test_a_disc_smaller_than_the_sides_of_a_soft_body_lies_on_its_rim():
    """In 2D the sides at the rim are faces: a disc that falls on the middle of one comes to rest above it."""
    jelly = pc.soft_body((2, 2), 0.2, 500.0, damping=1.0, mass=0.1, origin=(-0.1, 0.0))
    disc = pc.RigidBody(pc.Disc(0.03), (0.0, 0.35), mass=0.05, friction=0.5)
    floor = pc.Floor(0.0, restitution=0.0, friction=0.5)
    run = pc.simulate(pc.Scene(jelly, disc, floor, pc.Gravity((0.0, -G))), 1.5, dt=1 / 2000, fps=50)
    x, y = run[disc].positions[-1, 0]
    top = run[jelly].positions[-1, 2:]
    surface = np.interp(x, top[:, 0], top[:, 1])
    assert surface + 0.029 < y < surface + 0.035
    assert np.linalg.norm(run[disc].velocities[-1]) < 0.02
    assert np.abs(run.energy.drift).max() < 1e-3


def test_a_rope_hangs_over_a_bar_thinner_than_its_segments():
    """The middle of a segment falls on the bar: friction holds it there, with an end on each side."""
    rope = pc.rope(8, 1.05, 2000.0, damping=0.3, mass=0.02, start=(-0.525, 0.0, 0.1), direction=(1.0, 0.0, 0.0))
    bar = pc.RigidBody(pc.Capsule(0.4, 0.02), (0.0, 0.0, 0.0), orientation=QUARTER, friction=0.9, fixed=True)
    run = pc.simulate(pc.Scene(rope, bar, pc.Gravity((0.0, 0.0, -G))), 0.5, dt=1 / 4000, fps=50)
    middle = run[rope].positions[:, 3:5].mean(axis=1)
    assert np.linalg.norm(middle[:, [0, 2]], axis=1).min() > 0.02 - 1e-6
    assert middle[-1, 2] > 0.0
    assert (run[rope].positions[-1, [0, -1], 2] < -0.15).all()
    assert np.abs(run.energy.drift).max() < 1e-3


def test_a_large_ball_needs_the_particles_of_a_fine_cloth_alone():
    """Between them the cloth is within the ball by at most a 24th of its sides.

    A ball with a radius of four diagonals meets no faces, a smaller one and a box do.
    """
    cloth = pc.cloth((9, 9), 0.05, 100.0, damping=0.05, mass=1e-3, origin=(-0.2, -0.2, 0.3), axes=FLAT)
    gravity = pc.Gravity((0.0, 0.0, -G))

    def notes(shape):
        return " ".join(
            pc.Simulation(pc.Scene(cloth, pc.RigidBody(shape, (0.0, 0.0, 0.0), fixed=True), gravity)).plan.notes
        )

    assert "faces" not in notes(pc.Ball(0.285))
    assert "128 faces" in notes(pc.Ball(0.28))
    assert "128 faces" in notes(pc.Cuboid(0.5, 0.5, 0.5))
