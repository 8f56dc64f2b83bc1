"""Rigid bodies together with cloth, grains and forces at a distance."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc

G = 9.81
INNER, THICK, SIDES = 1.0, 0.1, 24
"""Inner radius and thickness of a drum [m], and the number of its sides."""


def square_cloth(side, stiffness, center, axes, **options):
    """A square cloth of `side` points along each edge, around a center."""
    spacing = 0.05
    origin = np.subtract(center, 0.5 * (side - 1) * spacing * np.sum(axes, axis=0))
    return pc.cloth((side, side), spacing, stiffness, damping=0.05, mass=0.002, origin=origin, axes=axes, **options)


def drum():
    """A ring of bars, as a polygon of so many sides."""
    half = math.tan(math.pi / SIDES) * (INNER + THICK)
    middle = INNER + 0.5 * THICK
    angles = 2.0 * math.pi * np.arange(SIDES) / SIDES
    bar = pc.Rectangle(THICK, 2.0 * half)
    return pc.Compound([(bar, (middle * math.cos(a), middle * math.sin(a)), a) for a in angles])


@pytest.mark.parametrize("driven", ["fixed", "motor"])
def test_a_rotating_drum_keeps_its_grains_and_pays_for_their_heat(driven):
    """Grains fall and are carried up. The drift is that of the springs between grains, of order dt²."""
    radius, spin = 0.05, 1.5
    sites = np.stack(np.meshgrid(np.arange(5), np.arange(5)), -1).reshape(-1, 2) - 2.0
    places = 2.2 * radius * sites + 0.003 * np.column_stack([sites[:, 1] ** 2, sites[:, 0]])
    grains = pc.Particles(places, mass=0.02, radius=radius)
    options = {"friction": 0.6, "restitution": 0.2, "angular_velocity": spin}
    if driven == "fixed":
        ring = pc.RigidBody(drum(), (0.0, 0.0), fixed=True, **options)
        items = [ring]
    else:
        ring = pc.RigidBody(drum(), (0.0, 0.0), mass=5.0, **options)
        axle = pc.Hinge(ring, None, (0.0, 0.0))
        items = [ring, axle, pc.Motor(axle, spin, 50.0)]
    contacts = pc.SoftSpheres(1e3, restitution=0.5, on=grains)
    run = pc.simulate(pc.Scene(grains, *items, contacts, pc.Gravity((0.0, -G))), 1.5, dt=1 / 4000, fps=30)
    # A grain gets farthest from the center in a corner of the polygon.
    reach = np.hypot(run.positions[..., 0], run.positions[..., 1]).max()
    assert reach < INNER / math.cos(math.pi / SIDES) - radius + 1e-6
    assert np.abs(run.energy.drift).max() < 5e-3
    assert run[ring].angular_velocities[-1, 0] == pytest.approx(spin, rel=1e-6)
    assert run.energy.work[-1] > 0.1
    assert run.energy.dissipated_by["contacts"][-1] > 0.1


def test_a_ball_and_a_free_cloth_keep_their_momentum():
    """A ball flies into a cloth that hangs on nothing and carries it along.

    Impulses on points, which do not turn, act beside them by the gaps of contacts: angular momentum changes by 1e-8.
    """
    cloth = square_cloth(13, 200.0, (0.0, 0.0, 0.0), ((1, 0, 0), (0, 0, 1)))
    ball = pc.RigidBody(pc.Ball(0.12), (0.013, -0.2, 0.017), velocity=(0.0, 3.0, 0.0), mass=0.2, friction=0.3)
    run = pc.simulate(pc.Scene(cloth, ball), 0.4, dt=1 / 4000, fps=200)
    assert np.abs(run.momentum - run.momentum[0]).max() < 1e-13
    assert np.abs(run.angular_momentum - run.angular_momentum[0]).max() < 3e-8
    assert np.abs(run.energy.drift).max() < 2e-3
    apart = np.linalg.norm(run.positions - run[ball].positions, axis=2).min()
    assert apart > 0.12 - 1e-4
    assert 0.0 < run[ball].velocities[-1, 0, 1] < 1.5


@pytest.mark.parametrize("radius", [0.0, 0.025])
def test_the_corners_of_a_box_stay_under_a_cloth(radius):
    """Between its particles too.

    What is behind a nearer part of the cloth is not looked at before it is nearest, and goes on for a step at most: at
    the 2.6 m/s of a fall through half the cloth, 1.3e-3 m.
    """
    half = 0.15
    center = (0.011, 0.007, half + 0.01 + radius)
    cloth = square_cloth(15, 100.0, center, ((1, 0, 0), (0, 1, 0)), radius=radius)
    box = pc.RigidBody(pc.Cuboid(2 * half, 2 * half, 2 * half), (0.0, 0.0, 0.0), fixed=True)
    run = pc.simulate(pc.Scene(cloth, box, pc.Gravity((0.0, 0.0, -G))), 0.5, dt=1 / 2000, fps=50)
    inside = (np.abs(run.positions) < half - 1.3e-3).all(axis=2)
    assert not inside.any()
    assert max(above(run.positions[frame][cloth.faces], half) for frame in range(10, 26)) < 1.3e-3


def above(triangles, half):
    """How far the upper corners of a box reach through triangles (T, 3, 3), along their diagonals outward; 0: not."""
    first, second, third = triangles.transpose(1, 0, 2)
    normals = np.cross(second - first, third - first)
    highest = -math.inf
    for x in (-1.0, 1.0):
        for y in (-1.0, 1.0):
            corner, way = half * np.array([x, y, 1.0]), np.array([x, y, 1.0]) / math.sqrt(3.0)
            along = ((first - corner) * normals).sum(axis=1) / (normals @ way)
            foot = corner + along[:, np.newaxis] * way
            sides = [(first, second), (second, third), (third, first)]
            within = [(np.cross(end - start, foot - start) * normals).sum(axis=1) >= 0.0 for start, end in sides]
            hit = np.logical_and.reduce(within) & (np.abs(along) < 0.1)
            highest = max(highest, *(-along[hit]), -math.inf)
    return highest


def test_bodies_attract_each_other_as_points():
    """Two bodies circle each other: ω² = G (M + m)/d³. What turns goes on turning."""
    distance, masses = 2.0, np.array([3.0, 1.0])
    rate = math.sqrt(masses.sum() / distance**3)
    places = np.array([[-0.5, 0.0], [1.5, 0.0]])
    bodies = pc.RigidBodies(
        pc.Rectangle(0.3, 0.1),
        places,
        velocities=rate * places[:, ::-1],
        angular_velocities=(1.0, -2.0),
        mass=masses,
    )
    run = pc.simulate(pc.Scene(bodies, pc.Gravitation(constant=1.0)), 5.0, dt=1 / 500, fps=20)
    apart = np.linalg.norm(run[bodies].positions[:, 1] - run[bodies].positions[:, 0], axis=1)
    assert apart == pytest.approx(distance, rel=1e-5)
    assert run[bodies].angles == pytest.approx(np.outer(run.times, (1.0, -2.0)), abs=1e-12)


def test_a_body_swings_in_a_well_as_its_mass_does():
    """ω² = k/m, whatever the shape."""
    body = pc.RigidBody(pc.Cuboid(0.4, 0.1, 0.2), (1.0, 0.0, 0.0), mass=2.0, angular_velocity=(1.0, 2.0, 0.0))
    run = pc.simulate(pc.Scene(body, pc.CentralForce((0.0, 0.0, 0.0), 8.0, exponent=1.0)), 3.0, dt=1 / 500, fps=20)
    assert run[body].positions[:, 0, 0] == pytest.approx(np.cos(2.0 * run.times), abs=2e-5)


def test_charged_bodies_repel_each_other_and_fall_in_a_field():
    """½ μ v² = k q² (1/d₀ − 1/d). In a field E the common center falls with q E/m."""
    charge, strength = 0.5, 4.0
    bodies = pc.RigidBodies(pc.Disc(0.1), [(-0.5, 0.0), (0.5, 0.0)], mass=2.0, charge=charge)
    field = pc.ElectromagneticField(electric=(0.0, -3.0))
    scene = pc.Scene(bodies, pc.Coulomb(constant=strength), field)
    run = pc.simulate(scene, 2.0, dt=1 / 1000, fps=20)
    places, speeds = run[bodies].positions, run[bodies].velocities
    apart, rate = (np.diff(each[..., 0], axis=1)[:, 0] for each in (places, speeds))
    assert 0.5 * rate**2 == pytest.approx(strength * charge**2 * (1.0 - 1.0 / apart), abs=1e-6)
    fall = -0.5 * 3.0 * charge / 2.0 * run.times**2
    assert places[..., 1] == pytest.approx(np.broadcast_to(fall[:, np.newaxis], (len(fall), 2)), abs=1e-12)
