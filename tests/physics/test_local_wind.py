"""Wind that depends on the place: drag and forces on faces where the air moves otherwise elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array, simulation

WIND = np.array([3.0, -2.0, 0.5])


def uniform(time: float, x: Array) -> Array:
    """The same wind everywhere."""
    return np.tile(WIND * (1.0 + time), (len(x), 1))


def dust(count: int = 50, dimension: int = 3) -> pc.Particles:
    rng = np.random.default_rng(0)
    return pc.Particles(*rng.normal(size=(2, count, dimension)), mass=rng.uniform(0.5, 2.0, count))


def flag() -> pc.SpringNetwork:
    return pc.cloth((7, 5), 0.1, 20.0, 0.01, origin=(0.0, 0.0, 0.0))


METHODS = [pc.VelocityVerlet(), pc.RungeKutta4(), pc.SemiImplicitEuler(), pc.BackwardEuler(), pc.BDF2(), pc.XPBD()]


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("integrator", METHODS, ids=repr)
def test_a_wind_that_is_alike_everywhere_is_one_of_the_time(integrator, precision):
    """Bit for bit, in a force that has the same operations."""
    runs = []
    for wind in (lambda t: WIND * (1.0 + t), uniform):
        scene = pc.Scene(dust(), pc.Drag(0.3, 0.1, wind=wind))
        runs.append(pc.Simulation(scene, integrator, dt=0.01, precision=precision))
        runs[-1].step(20)
    assert runs[0].state_hash() == runs[1].state_hash()
    assert runs[0].energy().work == runs[1].energy().work


@pytest.mark.parametrize("integrator", METHODS[:-1], ids=repr)
def test_a_flag_in_such_a_wind_too(integrator):
    runs = []
    for velocity in (lambda t: WIND * (1.0 + t), uniform):
        runs.append(pc.Simulation(pc.Scene(flag(), pc.Wind(velocity)), integrator, dt=1e-3))
        runs[-1].step(20)
    assert runs[0].state_hash() == runs[1].state_hash()
    assert runs[0].energy().dissipated == runs[1].energy().dissipated


@pytest.mark.parametrize(
    ("integrator", "order"), [(pc.RungeKutta4(), 4), (pc.VelocityVerlet(), 2), (pc.BDF2(1e-13), 2)], ids=str
)
def test_a_vortex_carries_particles_in_spirals(integrator, order):
    """m x'' = −b (x' − Ω × x) is linear: z'' + (b/m) z' − i (b/m) Ω z = 0 for z = x + i y, with two exponentials. The
    error falls with the order of the method, and the budget closes to it.
    """
    rate, spin, z, w = 3.0, 2.0, 1.0 + 0.5j, -0.3 + 1.0j
    roots = np.roots([1.0, rate, -1j * rate * spin])
    exact = np.array([1.0, 1.0]) @ (np.linalg.solve([[1.0, 1.0], roots], [z, w]) * np.exp(roots * 1.5))
    scene = pc.Scene(
        pc.Particles([[z.real, z.imag]], [[w.real, w.imag]], mass=0.5),
        pc.Drag(0.5 * rate, wind=lambda t, x: spin * np.stack([-x[:, 1], x[:, 0]], axis=1)),
    )
    errors, drifts = [], []
    for steps in (60, 120):
        run = simulation(scene, integrator, 1.5 / steps)
        start = run.energy().balance
        run.step(steps)
        errors.append(abs(complex(*run.positions[0]) - exact))
        drifts.append(abs(run.energy().balance - start))
    assert errors[1] < 0.05
    assert np.log2(errors[0] / errors[1]) > order - 0.3
    assert drifts[1] < 0.6 * drifts[0] + 1e-12


def test_particles_end_with_the_wind_of_their_place():
    """In a shear flow v_x = γ y, with quadratic drag and gravity across: −c |u| u_z = m g and u = (0, 0, −u_t)."""
    x = np.array([[0.0, y, 0.0] for y in (-1.0, 0.0, 2.0)])
    shear = pc.Flow(lambda t, x: np.stack([0.7 * x[:, 1], 0.0 * x[:, 1], 0.0 * x[:, 1]], axis=1))
    scene = pc.Scene(pc.Particles(x, mass=0.1), pc.Drag(quadratic=0.5, wind=shear), pc.Gravity((0.0, 0.0, -9.81)))
    run = simulation(scene, pc.RungeKutta4(), 1e-3)
    run.run(3.0)
    terminal = math.sqrt(0.1 * 9.81 / 0.5)
    expected = np.stack([0.7 * x[:, 1], 0.0 * x[:, 1], np.full(3, -terminal)], axis=1)
    np.testing.assert_allclose(run.velocities, expected, atol=1e-6)


def test_each_face_has_the_wind_at_its_centroid():
    """Plates across a wind that grows with height, at first: ½ ρ A C w(z)², a third at each corner."""
    corners = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    x = np.concatenate([corners, corners + np.array([0.0, 0.0, 3.0])])
    body = pc.SpringNetwork(x, [], 0.0, faces=[[0, 1, 2], [3, 4, 5]])
    wind = pc.Wind(lambda t, x: np.outer(1.0 + x[:, 2], [1.0, 0.0, 0.0]), 1.3, 1.1)
    run = simulation(pc.Scene(body, wind), pc.SemiImplicitEuler(), 1e-6)
    run.step()
    speed = 1.0 + np.repeat([1.0 / 3.0, 3.0 + 1.0 / 3.0], 3)
    np.testing.assert_allclose(run.velocities[:, 0] / 1e-6, 0.5 * 1.3 * 0.5 * 1.1 * speed**2 / 3.0, rtol=1e-9)


def test_a_converging_wind_limits_the_step():
    """m x'' = −b (x' + G x) with G ≫ b/m oscillates with ω² = b G/m: the limit is that of Verlet, 2/ω, or below."""
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.Drag(1.0, wind=lambda t, x: -1e4 * x))
    limit = pc.Simulation(scene, pc.VelocityVerlet()).plan.dt_limit
    assert 0.5 * 2.0 / 1e2 < limit <= 2.0 / 1e2


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.Drag(1.0, wind=lambda: (0.0, 0.0)), r"Drag\.wind: must take \(time\) or \(time, positions\), got"),
        (lambda: pc.Wind(lambda a, b, c: a), r"Wind\.velocity: must take \(time\) or \(time, positions\), got"),
        (
            lambda: run(lambda t, x: x[:, :1]),
            r"forces\[0\]\.wind: expected velocities of shape \(2, 2\).*got the shape \(2, 1\)",
        ),
        (lambda: run(lambda t, x: 1 / 0), r"forces\[0\]\.wind.*ZeroDivisionError"),
        (lambda: run(lambda t, x: "no"), r"forces\[0\]\.wind: expected velocities"),
    ],
)
def test_mistakes_are_named(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()


def test_a_wind_that_is_not_finite_diverges():
    with pytest.raises(pc.SimulationDiverged, match="wind"):
        run(lambda t, x: np.where(t > 0.05, np.inf, x))


def run(wind: object) -> None:
    simulation(pc.Scene(dust(2, 2), pc.Drag(1.0, wind=wind)), pc.VelocityVerlet(), 0.01).step(20)
