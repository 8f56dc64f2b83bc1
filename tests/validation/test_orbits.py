"""Validation, area C, as far as a fixed center goes: Kepler's orbit and the head-on fall."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array, simulation, state

pytestmark = pytest.mark.validation

# C01. Source: Kepler's equation, 45 digits; E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, sec. I.2.
# μ = 1, e = 0.6, from (0.4, 0) with (0, 2). Columns x, y, vx, vy.
KEPLER = {
    1: (-0.62894817682662423058, 0.79966473097003926660, -0.98251569093881132769, -0.022763170097430419920),
    10: (-1.5350235919098136943, -0.28366840649978086186, 0.22715073207749833769, -0.47918775820321956529),
    100: (-0.10418320443418060473, -0.69474171556795059932, 1.2361777626870763242, 0.56462325108586457376),
    1000: (-0.60273757992408318276, 0.79999700225684716268, -0.99835640455095182096, -0.0021864725532467498838),
}
TEXTBOOK_KEPLER = {
    pc.ExplicitEuler(): (1.0028, 1.3134, 1.0840, 0.61157),
    pc.SemiImplicitEuler(): (6.6824e-2, 4.6504e-2, 2.6588e-2, 1.4139e-2),
    pc.VelocityVerlet(): (2.6462e-2, 6.5867e-3, 1.6448e-3, 4.1109e-4),
    pc.RungeKutta4(): (1.7614e-5, 9.6944e-7, 5.6475e-8, 3.4011e-9),
}
STEPS = (500, 1000, 2000, 4000)


def kepler() -> pc.Scene:
    return pc.Scene(pc.Particles([[0.4, 0.0]], [[0.0, 2.0]]), pc.CentralForce((0.0, 0.0), 1.0))


def error_at(integrator: pc.Integrator, time: int, steps: int) -> Array:
    run = simulation(kepler(), integrator, time / steps)
    run.step(steps)
    return np.abs(state(run)[:, 0].ravel() - KEPLER[time])


@pytest.mark.parametrize("integrator", TEXTBOOK_KEPLER, ids=lambda i: type(i).__name__)
def test_c01_the_error_is_that_of_the_textbook_scheme(integrator, record_property):
    """The larger one of x and y at t = 10. Excellent: within 0.003; order within 0.02 (Verlet), 0.1 (RungeKutta4)."""
    errors = np.array([error_at(integrator, 10, steps)[:2].max() for steps in STEPS])
    ratios = errors / TEXTBOOK_KEPLER[integrator]
    record_property("ratio to the textbook's error", np.round(ratios, 5).tolist())
    np.testing.assert_allclose(ratios, 1.0, rtol=0.0, atol=0.003)
    order = np.log2(errors[-2] / errors[-1])
    if integrator.order > 1:
        assert order == pytest.approx(integrator.order, abs={2: 0.02, 4: 0.1}[integrator.order])


@pytest.mark.parametrize(("time", "steps", "tolerance"), [(1, 4000, 1e-11), (10, 40_000, 1e-10), (100, 400_000, 1e-9)])
def test_c01_pefrl_follows_the_orbit(time, steps, tolerance, record_property):
    """No catalogue figure: dt = 2.5e-4, where the error of order 4 is that of the phase and grows with time."""
    error = error_at(pc.PEFRL(), time, steps).max()
    record_property("error", f"{error:.1e}")
    assert error <= tolerance


def test_c01_a_million_steps_of_verlet(record_property):
    """Excellent: largest |ΔE/E| 7.4136e-4 ± 0.1 %, drift between the first and last hundred orbits 3e-7, |ΔL/L| 1e-13.

    Sampled at every seventh step: at some ninety places of an orbit, which shift from orbit to orbit.
    """
    run = simulation(kepler(), pc.VelocityVerlet(), 0.01)
    momentum = run.angular_momentum()[0]

    def orbits(count: int) -> Array:
        errors = []
        for _ in range(round(count * 2.0 * np.pi / 0.07)):
            run.step(7)
            errors.append(run.energy().total / -0.5 - 1.0)
        return np.array(errors)

    first = orbits(100)
    run.step(1_000_000 - run.steps - 7 * len(first))
    last = orbits(100)
    largest = np.abs(np.concatenate([first, last])).max()
    drift = abs(first.mean() - last.mean())
    turning = abs(run.angular_momentum()[0] / momentum - 1.0)
    record_property("largest, drift, angular momentum", f"{largest:.4e}, {drift:.1e}, {turning:.1e}")
    assert largest == pytest.approx(7.4136e-4, rel=1e-3)
    assert drift <= 3e-7
    assert turning <= 1e-13


@pytest.mark.long
def test_c01_pefrl_after_a_thousand_seconds(record_property):
    """4e6 steps round the phase: 1e-7 of it, on an orbit that passes the center 159 times."""
    error = error_at(pc.PEFRL(), 1000, 4_000_000).max()
    record_property("error", f"{error:.1e}")
    assert error <= 1e-7


# C03. Source: degenerate Kepler orbit, t = π/2 √(d³/(2 G (m₁ + m₂))). G = m₁ = m₂ = 1, 1 m apart, at rest.
TIME_TO_001 = 0.7850638246719994091796


@pytest.mark.parametrize("integrator", [pc.VelocityVerlet(), pc.PEFRL()], ids=lambda i: type(i).__name__)
def test_c03_a_head_on_fall(integrator, record_property):
    """Excellent: 1e-6 on the time to a separation of 0.01. The separation obeys r'' = −2/r².

    At 0.01 what is left of the fall takes r/v = 5e-4 s: with dt = 1e-5 Verlet is off by (dt/5e-4)² of it, 2e-7 s.
    """
    run = simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 2.0)), integrator, 1e-5)
    run.step(78_000)
    while run.positions[0, 0] > 0.01:
        run.step(1)
    (x, _), (v, _) = run.positions[0], run.velocities[0]
    a = -2.0 / x**2
    time = run.time - (x - 0.01) / v + 0.5 * a * ((x - 0.01) / v) ** 2 / v
    record_property("error", f"{time - TIME_TO_001:.1e} s")
    assert abs(time - TIME_TO_001) <= 1e-6


def test_c03_through_the_center_nothing_becomes_nan():
    """Unsoftened, the pair passes through r = 0, or the run says that it ran away."""
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 2.0))
    run = simulation(scene, pc.VelocityVerlet(), 1e-4)
    with contextlib.suppress(pc.SimulationDiverged):
        run.run(2.0)
    assert np.isfinite(state(run)).all()
