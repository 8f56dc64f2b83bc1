"""Wind on faces: forces of a plate in a stream, terminal velocities, and the energy between the air and the cloth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import EPSILON, Array, simulation

DENSITY, NORMAL, TANGENTIAL = 1.3, 1.1, 0.2
AIR = np.array([3.0, -2.0, 5.0])


def sail(seed: int, **more: object) -> pc.SpringNetwork:
    """Random faces of random particles in random motion, without springs."""
    rng = np.random.default_rng(seed)
    positions, velocities = rng.normal(size=(2, 9, 3))
    faces = np.array([rng.choice(9, 3, replace=False) for _ in range(7)])
    values = {"mass": rng.uniform(0.5, 2.0, 9), "velocities": velocities, "faces": faces, **more}
    return pc.SpringNetwork(positions, [], 0.0, **values)


def forces(body: pc.SpringNetwork) -> tuple[Array, Array]:
    """The force on each particle, shape (N, 3), and the powers that the air gives and that are dissipated."""
    total, powers = np.zeros_like(body.positions), np.zeros(2)
    for face in body.faces:
        a, b, c = body.positions[face]
        area = 0.5 * np.linalg.norm(np.cross(b - a, c - a))
        normal = np.cross(b - a, c - a) / (2.0 * area)
        relative = AIR - body.velocities[face].mean(axis=0)
        across = (relative @ normal) * normal
        along = relative - across
        pressure = NORMAL * np.linalg.norm(across) * across + TANGENTIAL * np.linalg.norm(along) * along
        force = 0.5 * DENSITY * area * pressure
        total[face] += force / 3.0
        powers += [force @ AIR, force @ relative]
    return total, powers


@given(st.integers(0, 2**32 - 1))
def test_a_face_feels_the_force_of_a_plate(seed: int):
    """A short step of the explicit method changes each velocity by F h/m: 1e-8 s of forces of order 10 N on 1 kg, and
    what the sum of v and F h/m loses is ε v/(F h) = 2e-9 of F. Energies after it are F·v h likewise.
    """
    body, h = sail(seed), 1e-8
    run = simulation(pc.Scene(body, pc.Wind(AIR, DENSITY, NORMAL, TANGENTIAL)), pc.SemiImplicitEuler(), h)
    run.step()
    expected, (supplied, dissipated) = forces(body)
    size = np.abs(expected).max()
    found = body.mass[:, None] * (run.velocities - body.velocities) / h
    assert np.abs(found - expected).max() < 1e-6 * size + 16 * EPSILON / h
    energy = run.energy()
    assert energy.work == pytest.approx(supplied * h, rel=1e-6)
    assert energy.dissipated == pytest.approx(dissipated * h, rel=1e-6)


def test_the_turn_of_a_face_does_not_matter():
    """The same motion where the corners of faces go round the other way: −n takes the place of n, bit for bit."""
    body = sail(1)
    other = sail(1, faces=body.faces[:, ::-1])
    runs = [simulation(pc.Scene(each, pc.Wind(AIR)), pc.VelocityVerlet(), 1e-3) for each in (body, other)]
    for run in runs:
        run.run(0.2)
    # The centroid is a sum in another order: rounding, which grows little in 200 steps.
    np.testing.assert_allclose(runs[0].positions, runs[1].positions, rtol=0, atol=1e4 * EPSILON)


@pytest.mark.parametrize("integrator", [pc.VelocityVerlet(), pc.RungeKutta4(), pc.SemiImplicitEuler()], ids=repr)
def test_a_plate_is_carried_along(integrator: pc.Integrator):
    """A plate across the wind follows m du/dt = ½ ρ A C (w − u)², so w − u = w/(1 + t/τ) with τ = 2 m/(ρ A C w). What
    the steps of h err is of order h/τ of it, 1e-3 at first order.
    """
    wind, mass, area = 6.0, 0.3, 0.5
    corners = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    plate = pc.SpringNetwork(corners, [], 0.0, mass=mass / 3.0, faces=[[0, 1, 2]])
    decay = 2.0 * mass / (DENSITY * area * NORMAL * wind)
    run = simulation(pc.Scene(plate, pc.Wind((wind, 0.0, 0.0), DENSITY, NORMAL)), integrator, 1e-3 * decay)
    run.run(3.0 * decay)
    lag = wind / (1.0 + 3.0)
    np.testing.assert_allclose(wind - run.velocities[:, 0], lag, rtol=1e-3)
    energy = run.energy()
    assert energy.total == pytest.approx(0.5 * mass * (wind - lag) ** 2, rel=1e-3)
    # The air gives the momentum m u at its own speed.
    assert energy.work == pytest.approx(mass * (wind - lag) * wind, rel=1e-3)


def test_a_plate_sinks_at_its_terminal_velocity():
    """A level plate in still air: u = u_t tanh(g t/u_t) with m g = ½ ρ A C u_t². Verlet takes the resistance of the
    velocity of the last half step, an error of order h g/u_t, 3e-3.
    """
    mass, area, time, h = 0.03, 0.5, 0.3, 1e-3
    corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    plate = pc.SpringNetwork(corners, [], 0.0, mass=mass / 3.0, faces=[[0, 1, 2]])
    scene = pc.Scene(plate, pc.Wind((0.0, 0.0, 0.0), DENSITY, NORMAL), pc.Gravity((0.0, 0.0, -9.81)))
    run = simulation(scene, pc.VelocityVerlet(), h)
    run.run(time)
    terminal = math.sqrt(2.0 * mass * 9.81 / (DENSITY * NORMAL * area))
    expected = terminal * math.tanh(9.81 * time / terminal)
    np.testing.assert_allclose(-run.velocities[:, 2], expected, rtol=3e-3)


def test_a_flag_turns_into_the_wind_and_flutters():
    """Its free edge points along the wind, and goes on moving across it; the budget closes. Energies are of second
    order in the step: half of it, a quarter of the drift.
    """
    flag = pc.cloth((16, 9), 0.04, 60.0, 0.003, mass=0.0016, axes=((1, 0, 0), (0, 0, 1)), pinned="left")
    scene = pc.Scene(flag, pc.Wind((4.0, 4.0, 0.0), 1.2))
    drift = []
    for step in (1e-3, 5e-4):
        recording = pc.simulate(scene, duration=3.0, fps=30, integrator=pc.VelocityVerlet(), dt=step)
        edge = recording.positions[60:].reshape(-1, 9, 16, 3)[:, :, -1].mean(axis=1)
        heading = np.degrees(np.arctan2(*edge.mean(axis=0)[1::-1]))
        assert heading == pytest.approx(45.0, abs=10.0)
        energy = recording.energy
        assert energy.work[-1] > energy.dissipated[-1] > 0.0
        drift.append(np.abs(energy.drift).max())
    assert drift[0] < 1e-2
    assert drift[1] < 0.5 * drift[0]


def test_torn_faces_feel_nothing():
    """A triangle whose one spring breaks in the first step flies on with what it has."""
    corners = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    body = pc.SpringNetwork(corners, [[0, 1]], 1.0, rest_length=0.9, faces=[[0, 1, 2]], breaking_strain=0.05)
    run = pc.Simulation(pc.Scene(body, pc.Wind((5.0, 0.0, 0.0))), dt=1e-3)
    run.step()
    torn = np.array(run.velocities)
    run.run(0.1)
    assert torn[:, 0].min() > 0.0
    np.testing.assert_array_equal(run.velocities, torn)


def test_wind_without_faces_is_refused():
    rope = pc.rope(4, 0.1, 10.0, start=(0.0, 0.0, 0.0), direction=(1.0, 0.0, 0.0))
    with pytest.raises(pc.SceneError, match=r"none on any body.*Drag"):
        pc.Scene(rope, pc.Wind((1.0, 0.0, 0.0)))
    cloth = pc.cloth((3, 3), 0.1, 10.0, origin=(0.0, 0.0, 0.0))
    with pytest.raises(pc.SceneError, match=r"faces.*without any"):
        pc.Scene(rope, cloth, pc.Wind((1.0, 0.0, 0.0), on=[cloth, rope]))
    flat = pc.cloth((3, 3), 0.1, 10.0)
    with pytest.raises(pc.SceneError, match="2 components"):
        pc.Scene(flat, pc.Wind((1.0, 0.0, 0.0)))


def test_a_face_without_area_is_refused():
    flat = pc.SpringNetwork([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], [[0, 1]], 1.0, faces=[[0, 1, 2]])
    with pytest.raises(pc.SceneError, match=r"forces\[0\].*: must have faces with an area.*faces\[0\]"):
        pc.Scene(flat, pc.Wind((1.0, 0.0, 0.0)))
