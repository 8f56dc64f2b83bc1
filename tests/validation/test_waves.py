"""Validation, area I: waves on grids against the exact solution of the discrete equations.

"Excellent" and "good" are the tolerances of the catalogue from which the cases are taken.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array, modal_frequency, simulation

pytestmark = pytest.mark.validation

VERLET = pc.VelocityVerlet()

# I01. Source: ω = π √(m² + n²); of leapfrog sin(ω dt/2) = C √(sin²(πmh/2) + sin²(πnh/2)), 40 digits. Unit square, fixed
# edges, c = 1; the leapfrog's: mode (1, 1), h = 1/64, C = c dt/h = 0.5, u₁ = u₀ + C²/2 ∇²u₀, which is Verlet from rest.
MODES = {(1, 1): 0.7071067811865475244008, (1, 2): 1.118033988749894848205, (2, 2): 1.414213562373095048802}
OMEGA = 4.442882938158366247016
OMEGA_DISCRETE = 4.442659884570561704192
PHASE_ERROR = -0.00005020469611945289885874
AMPLITUDE_AFTER_1000 = -0.9886570453809487915661


def shape_of(mode: tuple[int, int], cells: int) -> Array:
    """sin(πmx) sin(πny) at the centers of cells: the faces of the outer ones are the edges."""
    sine = np.sin(np.pi * np.outer(mode, (np.arange(cells) + 0.5) / cells))
    return np.outer(*sine)


def drum(cells: int = 64, mode: tuple[int, int] = (1, 1), order: Literal[2, 4] = 2) -> pc.Wave:
    """A mode of the unit square, at rest."""
    return pc.Wave(pc.Grid((cells, cells), 1.0 / cells), 1.0, shape_of(mode, cells), order=order, name="wave")


def amplitudes(run: pc.Simulation, shape: Array, steps: int) -> Array:
    """How much of a shape there is at every step."""
    series = []
    for _ in range(steps + 1):
        series.append(float((run["wave"].displacement * shape).sum() / (shape * shape).sum()))
        run.step(1)
    return np.array(series)


def frequency(series: Array, dt: float) -> float:
    """ω of a coordinate that goes as cos(ω t), at steps of dt: modal_frequency gives 2/dt · sin(ω dt/2)."""
    return 2.0 / dt * math.asin(0.5 * dt * modal_frequency(series, dt))


@pytest.mark.parametrize(("precision", "tolerance"), [("f64", 1e-12), ("f32", 3e-5)])
def test_i01_the_amplitude_of_a_membrane_after_a_thousand_steps(precision, tolerance, record_property):
    """Excellent: 1e-12, and 3e-5 in single precision. Also in every cell by itself."""
    run = simulation(pc.Scene(drum()), VERLET, 0.5 / 64, precision=precision)
    run.step(1000)
    shape = shape_of((1, 1), 64)
    off = run["wave"].displacement - AMPLITUDE_AFTER_1000 * shape
    error = float((off * shape).sum() / (shape * shape).sum())
    record_property("error, largest in a cell", f"{error:.1e}, {np.abs(off).max():.1e}")
    assert abs(error) <= tolerance
    assert np.abs(off).max() <= tolerance


def test_i01_the_frequency_is_that_of_leapfrog_and_has_its_order(record_property):
    """Excellent: the order within 0.02 of 2, with C = 0.5 throughout. The second differences of 500 amplitudes are
    (ω dt)² = 1e-3 of them: a frequency to 1e-13.
    """
    found = [
        frequency(amplitudes(simulation(pc.Scene(drum(n)), VERLET, 0.5 / n), shape_of((1, 1), n), 500), 0.5 / n)
        for n in (64, 128)
    ]
    errors = np.array(found) / OMEGA - 1.0
    order = math.log2(errors[0] / errors[1])
    record_property("relative phase error and order", f"{errors[0]:.9e}, {order:.5f}")
    assert found[0] == pytest.approx(OMEGA_DISCRETE, rel=1e-12)
    assert errors[0] == pytest.approx(PHASE_ERROR, rel=1e-8)
    assert order == pytest.approx(2.0, abs=0.02)


@pytest.mark.parametrize("mode", MODES)
def test_i01_the_modes_of_a_membrane(mode, record_property):
    """No catalogue tolerance. Differences of order 4 are off by (kh)⁴/180 of ω along each axis, 5e-7 at most with
    h = 1/64 and k = 2π; BlanesMoan6 adds nothing.
    """
    run = simulation(pc.Scene(drum(64, mode, order=4)), pc.BlanesMoan6(), 0.5 / 64)
    error = frequency(amplitudes(run, shape_of(mode, 64), 300), 0.5 / 64) / (2.0 * np.pi * MODES[mode]) - 1.0
    record_property("error", f"{error:.1e}")
    assert abs(error) <= 6e-7


# I02. Source: the discrete dispersion relation, 40 digits. Phase velocity / c by C, points per wave and direction.
PHASE_VELOCITIES = {
    (0.5, 5, "axis"): 0.9495081261186383,
    (0.5, 5, "diagonal"): 0.9829735095948017,
    (0.5, 10, "axis"): 0.9875879803247744,
    (0.5, 10, "diagonal"): 0.9958520065799098,
    (0.5, 20, "axis"): 0.9969110090358339,
    (0.5, 20, "diagonal"): 0.9989696943239291,
    (math.sqrt(0.5), 5, "axis"): 0.9647609337588130,
    (math.sqrt(0.5), 5, "diagonal"): 1.0,
    (math.sqrt(0.5), 10, "axis"): 0.9916321313028263,
    (math.sqrt(0.5), 10, "diagonal"): 1.0,
    (math.sqrt(0.5), 20, "axis"): 0.9979349358221977,
    (math.sqrt(0.5), 20, "diagonal"): 1.0,
}


@pytest.mark.parametrize("case", PHASE_VELOCITIES, ids=lambda case: f"C={case[0]:.4f}, {case[1]} per wave, {case[2]}")
def test_i02_the_phase_velocity_of_leapfrog(case, record_property):
    """Excellent: 1e-8. Of a traveling plane wave, from the displacement at one place, which is a sine of the time.

    A diagonal wave of 5 cells' length fits no periodic grid. A step reaches one cell far: with 110 cells to all edges
    nothing of them comes to the middle in 100 steps. (ω dt)² ≥ 0.02: rounding makes 1e-14 of it.
    """
    courant, points, direction = case
    grid = pc.Grid((221, 221), 1.0)
    x, y = grid.coordinates
    k = 2.0 * np.pi / points
    phase = k * (x - 110.5) if direction == "axis" else k * ((x - 110.5) + (y - 110.5)) / math.sqrt(2.0)
    run = simulation(pc.Scene(pc.Wave(grid, 1.0, np.cos(phase), k * np.sin(phase), name="wave")), VERLET, courant)
    series = []
    for _ in range(101):
        series.append(float(run["wave"].displacement[110, 110]))
        run.step(1)
    error = frequency(np.array(series), courant) / k / PHASE_VELOCITIES[case] - 1.0
    record_property("error", f"{error:.1e}")
    assert abs(error) <= 1e-8


# I06. Source: s = 1.01 of the limit: g = 2s² − 1 + 2s √(s² − 1).
GROWTH = 1.32658442695090807


def noise() -> pc.Wave:
    """All modes. On an even number of cells round both axes the checkerboard is one, and the fastest."""
    start = np.random.default_rng(6).normal(size=(16, 16))
    return pc.Wave(pc.Grid((16, 16), 1.0, periodic=True), 1.0, start, name="wave")


def test_i06_just_below_the_limit_the_energy_stays_bounded(record_property):
    """At s = 0.99 the energy that is kept is at least 1 − s² = 0.0199 of the true one, for each mode, at any time."""
    run = simulation(pc.Scene(noise()), VERLET, 0.99 / math.sqrt(2.0))
    energies = [run.energy().total]
    for _ in range(100):
        run.step(1000)
        energies.append(run.energy().total)
    record_property("largest energy of the first", f"{max(energies) / energies[0]:.2f}")
    assert max(energies) <= energies[0] / (1.0 - 0.99**2)


def test_i06_just_above_the_limit_noise_grows_as_the_checkerboard_does(record_property):
    """Excellent: 1e-5. On 16 × 16 cells the next modes are at sin² (7π/16) + 1 of 2, s = 1.0003, and grow by 1.05 per
    step: after 100 steps they are (1.05/1.33)^100 = 1e-10 of the checkerboard.
    """
    with pytest.warns(pc.StabilityWarning, match="limit"):
        run = pc.Simulation(pc.Scene(noise()), VERLET, 1.01 / math.sqrt(2.0), "f64", max_energy_growth=1e60)
    run.step(120)
    before = run["wave"].displacement.copy()
    run.step(20)
    growth = float(np.linalg.norm(run["wave"].displacement) / np.linalg.norm(before)) ** (1.0 / 20.0)
    record_property("growth per step, relative error", f"{growth:.9f}, {growth / GROWTH - 1.0:.1e}")
    assert growth == pytest.approx(GROWTH, rel=1e-5)


# I07. Source: leapfrog keeps Σ (uⁿ⁺¹ − uⁿ)²/dt² + ∇uⁿ⁺¹·∇uⁿ.
def kept(run: pc.Simulation) -> float:
    """That of the present step and the next, which it takes. Beyond a fixed edge there is −u."""
    first = run["wave"].displacement.copy()
    run.step(1)
    second = run["wave"].displacement
    padded = np.pad(second, 1)
    padded[[0, -1], 1:-1], padded[1:-1, [0, -1]] = -second[[0, -1]], -second[:, [0, -1]]
    neighbors = padded[2:, 1:-1] + padded[:-2, 1:-1] + padded[1:-1, 2:] + padded[1:-1, :-2]
    return float((((second - first) / run.plan.dt) ** 2 - first * (neighbors - 4.0 * second) * 64.0**2).sum())


def test_i07_a_hundred_thousand_steps_and_back(record_property):
    """Excellent: a drift of 1e-12 of the energy, and 1e-11 m at the return with the rate turned round."""
    run = simulation(pc.Scene(drum()), VERLET, 0.5 / 64)
    energies = [kept(run)]
    for _ in range(100):
        run.step(999)
        energies.append(kept(run))
    drift = float(np.abs(np.array(energies) / energies[0] - 1.0).max())
    steps = run.steps
    run["wave"].set(rate=-run["wave"].rate)
    run.step(steps)
    error = float(np.abs(run["wave"].displacement - shape_of((1, 1), 64)).max())
    record_property("drift, return", f"{drift:.1e}, {error:.1e}")
    assert drift <= 1e-12
    assert error <= 1e-11
