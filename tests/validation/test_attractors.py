"""Validation, area D: the attractor of Lorenz."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array

pytestmark = pytest.mark.validation

# D01. Source: a Taylor series of 70 digits, from (1, 1, 1), with σ = 10, ρ = 28, β = 8/3.
LORENZ = {
    1: (-9.378570010925062360842, -8.357033788426644732902, 29.36232533736342818034),
    5: (-6.512113699419599047, -6.974042788417076134262, 23.9241295721033703513),
    10: (-4.902687541134645731904, -3.743872921802919616315, 24.69085810279055545322),
    20: (13.7931995951286188316, 12.95180393618989854005, 34.90160868113514290711),
    25: (-1.184925803349181710619, -2.112836080825951464019, 11.69165314417988999418),
}
# The largest errors of textbook schemes by the number of steps.
TEXTBOOK = {
    (5, pc.RungeKutta4()): {500: 2.1307e-4, 1000: 7.0939e-6, 2000: 4.6359e-7, 4000: 3.1681e-8},
    (5, pc.ExplicitEuler()): {4000: 7.1920e-1, 8000: 3.5349e-1, 16_000: 1.7180e-1},
    (10, pc.RungeKutta4()): {1000: 1.0279e-3, 2000: 3.2354e-5, 4000: 1.0190e-6, 8000: 3.2344e-8},
    (10, pc.ExplicitEuler()): {8000: 2.0308, 16_000: 7.1940e-1, 32_000: 2.7558e-1},
}


def after(start: object, time: float, steps: int, integrator: pc.Integrator, rho: float = 28.0) -> Array:
    """Where tracers are after that time."""
    points = pc.Tracers(start, pc.Lorenz(rho=rho))
    run = pc.Simulation(pc.Scene(points), integrator, dt=time / steps, precision="f64")
    run.step(steps)
    return run[points].positions


def error(time: int, steps: int, integrator: pc.Integrator) -> float:
    return float(np.abs(after([[1.0, 1.0, 1.0]], time, steps, integrator)[0] - LORENZ[time]).max())


@pytest.mark.parametrize(("time", "integrator"), TEXTBOOK, ids=str)
def test_d01_the_error_is_that_of_the_textbook_scheme(time, integrator, record_property):
    """Excellent: within 2 %. From t = 0 to 10 errors of rounding grow to some 1e-16 · 50 · e^9 ≈ 4e-11, a thousandth of
    the smallest error here.
    """
    expected = TEXTBOOK[time, integrator]
    ratios = np.array([error(time, steps, integrator) / figure for steps, figure in expected.items()])
    record_property("ratio to the textbook's error", np.round(ratios, 4).tolist())
    np.testing.assert_allclose(ratios, 1.0, rtol=0.0, atol=0.02)


@pytest.mark.parametrize(("time", "steps", "excellent"), [(20, 20_000, 4.8e-5), (25, 50_000, 7.9e-4)])
def test_d01_as_far_as_rounding_lets_the_state_be_known(time, steps, excellent, record_property):
    found = error(time, steps, pc.RungeKutta4())
    record_property("error", f"{found:.2e}, textbook {excellent / 1.1:.2e}")
    assert found < excellent


# D03. Source: closed forms: x = y = ±√(β (ρ − 1)), z = ρ − 1; Hopf's bifurcation is at ρ = σ (σ + β + 3)/(σ − β − 1),
# 470/19.
CENTER = (8.485281374238570292810, 8.485281374238570292810, 27.0)
REAL, IMAGINARY = 0.093955623964685514569, 10.194505220927849632
"""Of the complex eigenvalues there [1/s]."""


def test_d03_a_tracer_on_the_center_stays_there(record_property):
    """Excellent: 1e-13 after 20 s. One ulp of z, 3.6e-15, grows by e^1.9."""
    moved = float(np.abs(after([CENTER], 20.0, 20_000, pc.RungeKutta4())[0] - CENTER).max())
    record_property("moved", f"{moved:.1e}")
    assert moved < 1e-13


def test_d03_perturbations_decay_below_hopfs_bifurcation_and_grow_above():
    for rho, grows in ((24.0, False), (25.0, True)):
        center = np.array([np.sqrt(8 / 3 * (rho - 1.0))] * 2 + [rho - 1.0])
        place, sizes = center + np.array([1e-4, 0.0, 0.0]), []
        for _ in range(40):
            # The longest of a turn, 2π/ω.
            path = [place]
            for _ in range(8):
                path.append(after([path[-1]], 0.08, 80, pc.RungeKutta4(), rho)[0])
            place = path[-1]
            sizes.append(max(np.linalg.norm(point - center) for point in path))
        assert (sizes[-1] > sizes[5]) == grows, rho


def test_d03_a_perturbation_grows_and_turns_at_the_eigenvalues(record_property):
    """Along the plane of the complex pair, from 1e-6: terms of second order are 1e-6 of it, those of the decaying
    direction e^−13.9 t.
    """
    start, step, count = np.add(CENTER, (0.0, 1e-6, 0.0)), 0.01, 400
    tracer = pc.Tracers([start], pc.Lorenz())
    path = pc.simulate(
        pc.Scene(tracer), 4.0, fps=1 / step, dt=step / 10, integrator=pc.DormandPrince5(), precision="f64"
    )
    late = path[tracer].positions[count // 4 :, 0] - CENTER
    # x[n+1] = 2 a cos(b) x[n] − a² x[n−1], by least squares.
    x = late[:, 0]
    (trace, determinant), *_ = np.linalg.lstsq(np.stack([x[1:-1], x[:-2]], axis=1), x[2:], rcond=None)
    growth = 0.5 * np.log(-determinant) / step
    turn = np.arccos(trace / (2 * np.sqrt(-determinant))) / step
    record_property("real, imaginary", f"{growth:.6f}, {turn:.6f}")
    assert growth == pytest.approx(REAL, abs=1e-4)
    assert turn == pytest.approx(IMAGINARY, abs=1e-4)


# D04. Source: J. C. Sprott, Chaos and Time-Series Analysis (2003): 0.9056, 0, −14.5723; their sum is −41/3.
def test_d04_lyapunov_exponents(record_property):
    """Excellent: the largest within 0.005 after a total of 1e4 s, the sum within 1e-5. The sum is that of ln det ∇φ
    over intervals, which the steps' own error of order 4 changes by some (λ dt)⁴ λ/120, 1e-6 for λ = 23.
    """
    cloud = pc.Tracers(np.random.default_rng(4).normal((0.0, 0.0, 25.0), size=(100, 3)), pc.Lorenz())
    spectrum = pc.lyapunov(cloud, duration=100.0, transient=20.0, dt=0.005, integrator=pc.RungeKutta4())
    record_property("exponents", np.round(spectrum.exponents, 5).tolist())
    assert spectrum.exponents[0] == pytest.approx(0.9056, abs=0.005)
    assert spectrum.exponents[1] == pytest.approx(0.0, abs=0.005)
    assert spectrum.exponents.sum() == pytest.approx(-41 / 3, abs=1e-5)
    assert spectrum.dimension == pytest.approx(2.062, abs=1e-3)
