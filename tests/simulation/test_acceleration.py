"""The acceleration field of a scene: what a test particle of 1 kg would feel at rest."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc

POINTS = np.random.default_rng(5).uniform(0.5, 2.0, size=(21, 3))
DOWN = pc.Gravity((0.0, 0.0, -9.81))
BODY = pc.Particles([[5.0, 5.0, 5.0]], mass=3.0, name="stone")
ROUNDING = 1e-14
"""Some ten operations, each exact to 1.1e-16, on numbers of the same sign."""


def field(*items: object, **numerics: object) -> np.ndarray:
    return pc.Simulation(pc.Scene(BODY, *items), dt=1e-3, **numerics).acceleration(POINTS)


def test_gravity_is_an_acceleration_whatever_the_masses():
    assert (field(DOWN) == [0.0, 0.0, -9.81]).all()


@pytest.mark.parametrize("exponent", [-2.0, -1.0, -1.7, 1.0])
def test_a_central_force_acts_on_one_kilogram(exponent):
    center = np.array([-1.0, -0.5, -2.0])
    away = POINTS - center
    radius = np.sqrt((away**2).sum(1, keepdims=True) + 0.3**2)
    found = field(pc.CentralForce(tuple(center), 2.5, exponent, 0.3))
    np.testing.assert_allclose(found, -2.5 * radius ** (exponent - 1.0) * away, rtol=10 * ROUNDING)


def test_drag_takes_a_particle_at_rest_along_with_the_wind():
    wind = np.array([1.0, -2.0, 0.5])
    found = field(pc.Drag(0.4, 0.3, wind=tuple(wind)))
    assert np.allclose(found, (0.4 + 0.3 * np.linalg.norm(wind)) * wind, rtol=ROUNDING)
    assert (field(pc.Drag(0.4, 0.3)) == 0.0).all()


def test_a_custom_force_is_asked_at_the_points_at_rest_and_at_the_present_time():
    def force(time, positions, velocities):
        assert (velocities == 0.0).all() or positions.shape != POINTS.shape
        return time * positions**2

    simulation = pc.Simulation(pc.Scene(pc.Particles([[1.0, 1.0, 1.0]]), pc.CustomForce(force)), dt=0.25)
    assert (simulation.acceleration(POINTS) == 0.0).all()
    simulation.step(2)
    assert (simulation.acceleration(POINTS) == 0.5 * POINTS**2).all()


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@pytest.mark.parametrize("dimension", [2, 3])
def test_it_is_the_acceleration_of_a_particle_that_is_there(dimension):
    """Explicit Euler gives a particle at rest the velocity h·a; for h a power of two the quotient is exact."""
    h = 2.0**-20
    points = POINTS[:, :dimension]
    forces = [
        pc.Gravity(-9.81 * np.eye(dimension)[-1]),
        pc.CentralForce((0.0,) * dimension, 2.0),
        pc.CentralForce((1.0,) * dimension, 3.0, 1.0),
        pc.Drag(0.1, 0.2, wind=np.arange(1.0, 1.0 + dimension)),
        pc.CustomForce(lambda time, x, v: x**2),
    ]
    probes = pc.Simulation(pc.Scene(pc.Particles(points), *forces), integrator=pc.ExplicitEuler(), dt=h)
    found = probes.acceleration(points)
    before = probes.state_hash()
    assert probes.acceleration(points[:4]).tolist() == found[:4].tolist()
    assert probes.state_hash() == before
    probes.step()
    assert (probes.velocities / h == found).all()


@pytest.mark.filterwarnings("ignore::physcore.SceneWarning")
def test_what_passes_between_particles_is_left_out():
    items = (pc.SoftSpheres(100.0), pc.LennardJones(1.0, 0.9), pc.Floor(-1.0))
    net = pc.SpringNetwork([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]], [[0, 1]], 10.0, rest_length=1.0, radius=0.5)
    simulation = pc.Simulation(pc.Scene(net, *items[:1], items[2], DOWN), dt=1e-3)
    assert (simulation.acceleration([[0.1, 0.0, 0.0]]) == [[0.0, 0.0, -9.81]]).all()
    for law in (items[1], pc.Gravitation(1.0), pc.Coulomb(1.0)):
        simulation = pc.Simulation(pc.Scene(net, law, DOWN), dt=1e-3)
        assert (simulation.acceleration([[0.1, 0.0, 0.0]]) == [[0.0, 0.0, -9.81]]).all()


def test_a_fluid_is_left_out():
    water = pc.Fluid(pc.block((0.0, 0.0), (0.4, 0.4), 0.1), 0.1)
    scene = pc.Scene(water, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (0.8, 0.8)))
    found = pc.Simulation(scene, dt=1e-4).acceleration([[0.2, 0.2], [0.7, 0.7]])
    assert (found == [0.0, -9.81]).all()


def test_the_forces_on_one_body_count_by_themselves():
    one, other = pc.Particles([[0.0, 0.0]], name="one"), pc.Particles([[1.0, 0.0]])
    scene = pc.Scene(
        one, other, pc.Gravity((0.0, -1.0), on=one), pc.Gravity((0.0, -2.0), on=other), pc.Gravity((4.0, 0.0))
    )
    simulation = pc.Simulation(scene, dt=0.1)
    for key in (one, 0, -2, "one"):
        assert simulation.acceleration([[0.0, 0.0]], on=key).tolist() == [[4.0, -1.0]]
    assert simulation.acceleration([[0.0, 0.0]], on=other).tolist() == [[4.0, -2.0]]
    assert simulation.acceleration([[0.0, 0.0]]).tolist() == [[4.0, -3.0]]


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
def test_single_precision_does_not_matter():
    star = pc.CentralForce((0.0, 0.0, 0.0), 2.0)
    assert (field(star, DOWN, precision="f32") == field(star, DOWN, precision="f64")).all()


def test_no_points_have_no_accelerations_and_no_forces_give_none():
    assert pc.Simulation(pc.Scene(BODY, DOWN)).acceleration(np.empty((0, 3))).shape == (0, 3)
    found = pc.Simulation(pc.Scene(BODY)).acceleration(POINTS)
    assert found.shape == POINTS.shape
    assert (found == 0.0).all()


@pytest.mark.parametrize(
    ("points", "on", "message"),
    [
        ([0.0, 0.0, 0.0], None, r"acceleration\.points: must have the shape \(M, 3\), got \(3,\)"),
        ([[0.0, 0.0]], None, r"acceleration\.points: must have the shape \(M, 3\), got \(1, 2\)"),
        ([[0.0, np.nan, 0.0]], None, r"acceleration\.points\[0, 1\]: must be finite"),
        ([[0.0, 0.0, 0.0]], "tree", r"acceleration\.on: no body 'tree'"),
        ([[0.0, 0.0, 0.0]], 1, r"acceleration\.on: no body 1"),
    ],
)
def test_what_makes_no_sense_is_refused(points, on, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.Simulation(pc.Scene(BODY, DOWN)).acceleration(points, on)


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
def test_an_acceleration_without_end_is_refused_with_its_point():
    simulation = pc.Simulation(pc.Scene(BODY, pc.CentralForce((0.0, 0.0, 0.0), 1.0, -8.0)), dt=1e-3)
    with pytest.raises(pc.SceneError, match=r"acceleration\.points\[1\]: expected a place with a finite acceleration"):
        simulation.acceleration([[1.0, 0.0, 0.0], [1e-80, 0.0, 0.0]])


def test_a_function_that_knows_its_particles_is_refused_by_its_path():
    pull = np.array([[1.0, 0.0, 0.0]])
    simulation = pc.Simulation(pc.Scene(BODY, DOWN, pc.CustomForce(lambda time, x, v: pull)), dt=1e-3)
    with pytest.raises(pc.SceneError, match=r"forces\[1\]\.function: expected forces of shape \(21, 3\)"):
        simulation.acceleration(POINTS)
