"""Validation, area B: charges in electric and magnetic fields."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array

pytestmark = pytest.mark.validation


def run_of(scene: pc.Scene, integrator: pc.Integrator, dt: float, steps: int) -> pc.Simulation:
    run = pc.Simulation(scene, integrator, dt=dt, precision="f64")
    run.step(steps)
    return run


def gyrating() -> pc.Scene:
    return pc.Scene(pc.Particles([[0.0, 1.0]], [[1.0, 0.0]], charge=1.0), pc.ElectromagneticField(magnetic=1.0))


# B01. Source: rotation by 2 atan(q B dt/2m) in a step (Birdsall, Langdon 1985, § 4-3), in 40 digits.
ANGLE = 0.1993373049823240547569
AFTER_1000 = (-0.1532225584952714046120, 0.9881917058790582324025)


def test_b01_the_gyration_is_the_discrete_one(record_property):
    """Excellent: 1e-11 rad after 1000 steps, each rounded by some 2 ε. The radius is exactly m v/qB, not √(1 +
    (dt/2)²) of it as in the staggered scheme, since positions and velocities are at the same times.
    """
    recording = pc.simulate(gyrating(), 200.0, fps=5.0, dt=0.2, integrator=pc.Boris(), precision="f64")
    velocity = recording.velocities[-1, 0]
    error = np.abs(velocity - AFTER_1000).max()
    turned = math.atan2(-velocity[1], velocity[0])
    phase = (turned - 1000 * ANGLE + math.pi) % (2.0 * math.pi) - math.pi
    x = recording.positions[:, 0]
    # Least squares for a circle: |x|² = 2 x·c + r² − |c|².
    fit = np.linalg.lstsq(np.column_stack([2.0 * x, np.ones(len(x))]), (x**2).sum(axis=1))[0]
    radius = math.sqrt(fit[2] + fit[0] ** 2 + fit[1] ** 2)
    record_property("velocity", f"{error:.1e}")
    record_property("phase", f"{phase:.1e} rad")
    record_property("radius", f"{radius - 1.0:.1e}")
    assert abs(phase) < 1e-11
    assert error < 1e-11
    assert radius == pytest.approx(1.0, rel=1e-10)


def test_b01_the_speed_is_kept_over_a_million_steps(record_property):
    speed = float(np.linalg.norm(run_of(gyrating(), pc.Boris(), 0.2, 1_000_000).velocities[0]))
    record_property("speed", f"{speed - 1.0:.1e}")
    assert speed == pytest.approx(1.0, abs=1e-12)


def test_b01_an_exact_angle_follows_the_equation_of_motion(record_property):
    """v(200) of the exact solution."""
    velocity = run_of(gyrating(), pc.Boris(exact_angle=True), 0.2, 1000).velocities[0]
    error = np.abs(velocity - (0.4871876750070059103547, 0.8732972972139945817330)).max()
    record_property("error", f"{error:.1e}")
    assert error < 1e-11


# B02. Source: the trochoid in closed form, in 40 digits: x, y, z, v at t = 10.
TROCHOID = np.array(
    [
        [0.5103810001995671679357, -1.655164376168807207033, 5.0],
        [-0.6551643761688072070330, 0.4896189998004328320643, 0.5],
    ]
)


def drifting() -> pc.Scene:
    ions = pc.Particles([[0.0, 0.0, 0.0]], [[1.0, 0.0, 0.5]], charge=1.0)
    return pc.Scene(ions, pc.ElectromagneticField((0.0, 0.1, 0.0), (0.0, 0.0, 1.0)))


def test_b02_the_state_on_a_trochoid(record_property):
    """Excellent: 7e-10 by RungeKutta4 with dt = 0.01."""
    run = run_of(drifting(), pc.RungeKutta4(), 0.01, 1000)
    error = np.abs(np.stack([run.positions[0], run.velocities[0]]) - TROCHOID).max()
    record_property("error", f"{error:.2e}")
    assert error < 7e-10


def test_b02_the_drift_is_exact_for_boris(record_property):
    """Excellent: 1e-10 of the drift 0.1 m/s. A velocity is the drift and a rotation by a constant angle: a fit by least
    squares finds each to rounding.
    """
    recording = pc.simulate(drifting(), 100.0, fps=10.0, dt=0.1, integrator=pc.Boris(), precision="f64")
    angle = 2.0 * math.atan(0.05) * np.arange(len(recording.times))
    basis = np.column_stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
    drift = np.linalg.lstsq(basis, recording.velocities[:, 0, 0])[0][0]
    record_property("drift", f"{drift / 0.1 - 1.0:.1e}")
    assert drift == pytest.approx(0.1, rel=1e-10)


# B04. Source: elements of the hyperbola, checked with an integration of 50 digits.
def scattered(start: tuple[float, float], speed: float, dt: float, steps: int) -> pc.Simulation:
    alpha = pc.Particles([start], [[speed, 0.0]], charge=1.0)
    nucleus = pc.Particles([[0.0, 0.0]], charge=1.0, fixed=[0])
    return run_of(pc.Scene(alpha, nucleus, pc.Coulomb(1.0)), pc.RungeKutta4(), dt, steps)


def test_b04_the_deflection_by_a_nucleus(record_property):
    """Excellent: the direction at t = 200 to 1e-9 rad, by RungeKutta4 with dt = 0.02."""
    velocity = scattered((-100.0, 1.0), 1.0, 0.02, 10_000).velocities[0]
    error = math.atan2(velocity[1], velocity[0]) - 1.56079042788
    record_property("error", f"{error:.1e} rad")
    assert abs(error) < 1e-9


def test_b04_the_energy_after_a_close_encounter(record_property):
    """Excellent: 1e-9, with an impact parameter of 0.1."""
    run = scattered((-100.0, 0.1), 1.0, 0.005, 40_000)
    energy = run.energy()
    error = energy.total / (0.5 + 1.0 / math.hypot(100.0, 0.1)) - 1.0
    record_property("error", f"{error:.1e}")
    assert abs(error) < 1e-9


# B06. Source: ω± = ω_c/2 ± √(ω_c²/4 − ω_z²/2) (Brown, Gabrielse 1986).
MODIFIED, MAGNETRON = 9.949747468305832670806, 0.05025253169416732919409


def roots_of(dt: float) -> Array:
    """The angles of a step's modes, by least squares for the linear map of one step."""
    ion = pc.Particles([[1.0, 0.3, 0.5]], [[0.1, -0.2, 0.3]], charge=1.0)
    scene = pc.Scene(ion, pc.ElectromagneticField(pc.QuadrupoleTrap(1.0), (0.0, 0.0, 10.0)))
    recording = pc.simulate(scene, 2000 * dt, fps=1.0 / dt, dt=dt, integrator=pc.Boris(), precision="f64")
    states = np.hstack([recording.positions[:, 0], recording.velocities[:, 0]])
    step = np.linalg.lstsq(states[:-1], states[1:], rcond=None)[0]
    return np.sort(np.abs(np.angle(np.linalg.eigvals(step))))[::2] / dt


def test_b06_the_modes_of_a_penning_trap(record_property):
    """Excellent: frequencies and their theorem to 1e-6. Boris is of order 2: with h and h/2, (4 ω(h/2) − ω(h))/3 is of
    order 4, off by some (ω h)⁴/300 = 3e-9 for h = 0.003.
    """
    expected = np.array([MAGNETRON, 1.0, MODIFIED])
    coarse, fine = roots_of(0.003), roots_of(0.0015)
    found = (4.0 * fine - coarse) / 3.0
    theorem = (found**2).sum() / 100.0 - 1.0
    record_property("frequencies", [f"{error:.1e}" for error in found / expected - 1.0])
    record_property("theorem", f"{theorem:.1e}")
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    assert abs(theorem) < 1e-6
