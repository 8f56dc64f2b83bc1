"""Rigid bodies that meet the faces of cloth and soft bodies between the particles."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc

G = 9.81
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

    Springs without damping give most of the energy back; what the impacts on light corners take is dissipated by contacts.
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
    """A ball flies into the middle of a coarse triangle. 2400 steps round the momentum of 0.3 kg·m/s, at each of 10 particles."""
    cloth = pc.cloth((4, 4), 0.2, 100.0, mass=0.02, damping=0.02, origin=(-0.3, -0.3, 0.0), axes=FLAT)
    ball = pc.RigidBody(pc.Ball(0.03), (0.03, -0.04, 0.1), velocity=(0.4, 0.1, -3.0), mass=0.1, friction=0.3)
    run = pc.simulate(pc.Scene(cloth, ball), 0.6, dt=1 / 4000, fps=100)
    assert np.abs(run.momentum - run.momentum[0]).max() < 1e-14
    assert np.abs(run.angular_momentum - run.angular_momentum[0]).max() < 1e-14
    assert np.abs(run.energy.drift).max() < 1e-3
    assert 0.0 > run[ball].velocities[-1, 0, 2] > -2.0


@pytest.mark.parametrize("friction", [0.2, 0.8])
def test_a_box_slides_down_a_sheet_as_down_a_plane(friction):
    """A sheet that is held everywhere is a plane of triangles, finer and coarser than the box on it: no side of them is felt.

    The box slides with g (sin θ − μ cos θ), or stays. Friction of a plane that is cut into faces is the same in all of them.
    """
    slope = math.radians(20.0)
    along, up = np.array([math.cos(slope), 0.0, -math.sin(slope)]), np.array([math.sin(slope), 0.0, math.cos(slope)])
    sheet = pc.cloth((12, 5), 0.13, 100.0, origin=(0.0, -0.25, 0.0), axes=(along, (0.0, 1.0, 0.0)), pinned=range(60))
    half = 0.5 * slope
    box = pc.RigidBody(
        pc.Cuboid(0.1, 0.08, 0.04),
        0.2 * along + 0.02 * up + (0.0, 0.01, 0.0),
        orientations=(math.cos(half), 0.0, math.sin(half), 0.0),
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
    jelly = pc.soft_body((3, 2), 0.2, 500.0, damping=1.0, mass=0.1, origin=(-0.3, 0.0))
    disc = pc.RigidBody(pc.Disc(0.03), (0.02, 0.35), mass=0.05, friction=0.5)
    floor = pc.Floor(0.0, restitution=0.0, friction=0.5)
    run = pc.simulate(pc.Scene(jelly, disc, floor, pc.Gravity((0.0, -G))), 1.5, dt=1 / 2000, fps=50)
    x, y = run[disc].positions[-1, 0]
    top = run[jelly].positions[-1, 3:]
    surface = np.interp(x, top[:, 0], top[:, 1])
    assert surface + 0.029 < y < surface + 0.035
    assert np.linalg.norm(run[disc].velocities[-1]) < 0.02
    assert np.abs(run.energy.drift).max() < 1e-3
