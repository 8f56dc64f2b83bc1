"""Meshes and ground as obstacles of particles, cloth, soft bodies and fluids, and hulls of many points."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc

RADIUS, TUBE = 0.5, 0.2
"""Radii of a torus [m]."""
SECTIONS = 32
SAGITTA = 1.1 * (RADIUS + TUBE) * (1.0 - np.cos(np.pi / SECTIONS))
"""Largest distance of its facets from the torus [m], along both circles."""
GRAVITY = pc.Gravity((0.0, 0.0, -9.81))


def revolved(profile, sections):
    """Vertices and faces of a closed curve (K, 2) of radii and heights turned about z."""
    turn = 2.0 * np.pi * np.arange(sections) / sections
    r, z = np.asarray(profile).T
    points = np.stack([np.outer(np.cos(turn), r), np.outer(np.sin(turn), r), np.tile(z, (sections, 1))], axis=-1)
    count = len(r)
    here = np.arange(sections * count).reshape(sections, count)
    a, b, c, d = here, np.roll(here, -1, 0), np.roll(np.roll(here, -1, 0), -1, 1), np.roll(here, -1, 1)
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return pc.Mesh(points.reshape(-1, 3), faces)


def torus():
    angle = 2.0 * np.pi * np.arange(SECTIONS) / SECTIONS
    return revolved(np.column_stack([RADIUS + TUBE * np.cos(angle), TUBE * np.sin(angle)]), SECTIONS)


def gap(points):
    """Distances from the torus [m]."""
    return np.hypot(np.hypot(points[..., 0], points[..., 1]) - RADIUS, points[..., 2]) - TUBE


def test_the_torus_is_closed_and_right_side_out():
    mesh = torus()
    assert mesh.is_closed
    assert mesh.volume == pytest.approx(2.0 * np.pi**2 * RADIUS * TUBE**2, rel=0.02)


def test_particles_stay_outside_of_a_mesh():
    rng = np.random.default_rng(3)
    grains = pc.Particles(rng.uniform((-0.7, -0.7, 0.3), (0.7, 0.7, 0.6), (200, 3)), radius=0.02)
    rock = torus().boundary(friction=0.3, restitution=0.5)
    recording = pc.simulate(pc.Scene(grains, rock, GRAVITY), 0.5, dt=1 / 480)
    assert gap(recording[grains].positions).min() > 0.02 - SAGITTA
    assert abs(recording.energy.drift).max() < 1e-6
    assert recording.energy.dissipated[-1] > 0.0
    np.testing.assert_array_equal(recording[rock].positions[-1], rock.positions)
    # Those above the hole fall through it.
    inner = np.hypot(*grains.positions[:, :2].T) < RADIUS - TUBE - 0.05
    assert (recording[grains].positions[-1, inner, 2] < -0.2).all()


@pytest.mark.parametrize("kind", ["cloth", "soft"])
def test_a_cloth_and_a_soft_body_lie_on_a_mesh(kind):
    if kind == "cloth":
        body = pc.cloth(
            (15, 15),
            0.1,
            100.0,
            damping=0.05,
            mass=1e-3,
            origin=(-0.7, -0.7, 0.3),
            axes=((1, 0, 0), (0, 1, 0)),
            radius=0.01,
        )
    else:
        body = pc.soft_body((10, 10, 2), 0.14, 2e3, damping=2.0, mass=0.05, origin=(-0.65, -0.65, 0.25), radius=0.01)
    recording = pc.simulate(pc.Scene(body, torus().boundary(friction=0.5, restitution=0.0), GRAVITY), 0.5, dt=1 / 960)
    # Corners hang down outside; what is above the tube lies on it.
    assert gap(recording[body].positions).min() > 0.01 - SAGITTA
    above = np.hypot(*recording[body].positions[-1, :, :2].T) < RADIUS + TUBE
    assert recording[body].positions[-1, above, 2].min() > -TUBE
    assert abs(recording.energy.drift).max() < 0.02


def bowl():
    """A bowl of inner radius 0.3 m and 0.1 m thick, whose lowest inner point is at 0.1 m."""
    angle = np.linspace(0.05, 0.5 * np.pi, 9)
    inner, outer = (np.column_stack([r * np.sin(angle), 0.4 - r * np.cos(angle)]) for r in (0.3, 0.4))
    return revolved(np.concatenate([outer, inner[::-1]]), 24)


def test_a_mesh_holds_water():
    spacing = 0.04
    vessel = bowl().boundary()
    # The hole that the profile leaves about the axis has a radius of 1.5 cm, less than half a spacing.
    points = pc.block((-0.16, -0.16, 0.2), (0.16, 0.16, 0.36), spacing)
    water = pc.Fluid(points[~bowl().contains(points)], spacing, viscosity=1.0)
    recording = pc.simulate(
        pc.Scene(water, vessel, GRAVITY), 0.5, fps=10, fluids=pc.WeaklyCompressible(sound_speed=20.0)
    )
    last = recording[water].positions[-1]
    assert np.linalg.norm(last - (0.0, 0.0, 0.4), axis=1).max() < 0.3 + 0.25 * spacing
    assert last[:, 2].min() > 0.1 - 0.25 * spacing
    force = recording[vessel].force[-1]
    assert force.ravel()[-1] == pytest.approx(-9.81 * water.mass.sum(), rel=0.3)  # it still moves


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_solid_of_a_height_field_has_its_surface(dimension):
    """Particles bounce off both at the same times and places."""
    x = np.arange(9) / 4.0
    heights = 0.3 * np.cos(2.0 * x) if dimension == 2 else 0.2 * np.cos(2.0 * x)[:, None] * np.sin(3.0 * x)
    ground = pc.HeightField(heights, 0.25, restitution=0.8, friction=0.0)
    solid = ground.solid(0.5, restitution=0.8)
    area = 2.0 ** (dimension - 1)
    assert solid.shape.properties(dimension).size > 0.5 * area
    start = np.random.default_rng(4).uniform(0.5, 1.5, (30, dimension))
    start[:, -1] += 0.5
    grains = pc.Particles(start, radius=0.01)
    pull = pc.Gravity((0.0,) * (dimension - 1) + (-9.81,))
    both = [pc.simulate(pc.Scene(grains, item, pull), 0.6, dt=1e-3)[grains].positions for item in (ground, solid)]
    np.testing.assert_allclose(both[0], both[1], atol=1e-3)
    assert np.abs(both[0][-1] - start).max() > 0.1


@pytest.mark.parametrize("dimension", [2, 3])
def test_water_rests_on_the_solid_of_a_height_field(dimension):
    """In a valley between walls it comes to rest above the ground, and the ground bears its weight."""
    x = np.linspace(-0.5, 0.5, 11)
    heights = 2.0 * x**2 if dimension == 2 else 2.0 * (x[:, None] ** 2 + x**2)
    ground = pc.HeightField(heights, 0.1, origin=-0.5)
    with pytest.raises(pc.SceneError, match=r"a height field is no wall of fluids.*ground.solid\(depth\)"):
        pc.Scene(pc.Fluid(np.zeros((1, dimension)), 0.1), ground)
    spacing, flat = (0.02, dimension - 1) if dimension == 2 else (0.05, dimension - 1)
    points = pc.block((-0.15,) * flat + (0.15,), (0.15,) * flat + (0.35,), spacing)
    bed = ground.solid(0.1)
    water = pc.Fluid(points[~bed.contains(points)], spacing, viscosity=2.0)
    pull = pc.Gravity((0.0,) * flat + (-9.81,))
    recording = pc.simulate(pc.Scene(water, bed, pull), 0.6, fps=10, fluids=pc.WeaklyCompressible(sound_speed=30.0))
    last = recording[water].positions[-1]
    below = 2.0 * np.square(last[:, :flat]).sum(axis=1) - last[:, -1]
    # Nodes are on the paraboloid, chords above it by at most h²/4 · 2 for each axis.
    assert below.max() < 0.25 * spacing
    assert np.abs(last[:, 0]).max() < 0.5
    force = recording[bed].force[-1].ravel()[-1]
    assert force == pytest.approx(-9.81 * water.mass.sum(), rel=0.2)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_hull_takes_any_number_of_points(dimension):
    """Of a ball of points; those within have no effect, and a ball on top rests at the height of the hull."""
    rng = np.random.default_rng(6)
    directions = rng.normal(size=(600, dimension))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    within = 0.9 * directions[:200] * rng.uniform(size=(200, 1))
    hull = pc.ConvexHull(np.concatenate([within, directions]))
    facets = hull.facets()
    used = np.unique(np.concatenate(facets))
    np.testing.assert_array_equal(used, np.arange(200, 800))  # all points of a sphere are corners
    assert len(facets) == (600 if dimension == 2 else 2 * 600 - 4)  # Euler, of triangles
    for facet in facets[::50]:
        corners = hull.points[facet]
        normal = (
            np.cross(*(corners[1:] - corners[0])) if dimension == 3 else np.diff(corners, axis=0)[0] @ [[0, 1], [-1, 0]]
        )
        heights = (hull.points - corners[0]) @ (normal / np.linalg.norm(normal))
        assert min(heights.max(), -heights.min()) < 1e-12
    top = np.zeros(dimension)
    top[-1] = 1.5
    ball = pc.Particles([top], np.where(np.arange(dimension) == dimension - 1, -1.0, 0.0), radius=0.1)
    recording = pc.simulate(pc.Scene(ball, hull), 0.5, fps=100, dt=1e-3)
    lowest = recording[ball].positions[:, 0, -1].min()
    # The sphere is within 1.5 times the square of the mean distance of its points of the hull, at random.
    assert 1.0 < lowest < 1.11


def test_contact_with_a_mesh_that_is_finer_than_the_thickness():
    """Edges of the other body may be shorter than the thickness; those of the body itself may not."""
    angle = 2.0 * np.pi * np.arange(48) / 48
    fine = revolved(np.column_stack([0.1 + 0.05 * np.cos(angle), 0.05 * np.sin(angle)]), 48)
    rock = fine.cloth(100.0, 10.0, fixed=np.arange(len(fine.vertices)))
    cloth = pc.cloth(
        (7, 7), 0.05, 50.0, damping=0.02, mass=1e-3, origin=(-0.15, -0.15, 0.08), axes=((1, 0, 0), (0, 1, 0))
    )
    thickness = 0.01
    edges = rock.positions[rock.pairs]
    assert np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).min() < 0.7 * thickness
    contact = pc.SelfContact(cloth, thickness, friction=0.3, on=rock)
    recording = pc.simulate(pc.Scene(cloth, rock, GRAVITY, contact), 0.3, dt=1 / 480)
    ring = np.hypot(np.hypot(*recording[cloth].positions[-1, :, :2].T) - 0.1, recording[cloth].positions[-1, :, 2])
    # Contact begins at the thickness and closes by the tolerance of its solver; vertices never pass through.
    assert ring.min() > 0.05 + 0.5 * thickness
    assert recording[cloth].positions[-1, 24, 2] > 0.0  # the middle spans the hole
    with pytest.raises(pc.SceneError, match=r"SelfContact.thickness: must be below the length of the shortest edge"):
        pc.SelfContact(rock, thickness, on=cloth)
