"""Validation, area F: drops that swing, grow round and rest by surface tension alone, in units of σ, ρ and the spacing.

All fluids have the defaults of `pc.Fluid` but for viscosity.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array
from validation.flows import damped_wave, hole, start

pytestmark = [pytest.mark.validation, pytest.mark.long, pytest.mark.filterwarnings("ignore::physcore.MachWarning")]


def drop(cells: Array, **changes: Any) -> pc.Fluid:
    return pc.Fluid(cells, 1.0, **{"density": 1.0, "surface_tension": 1.0, "viscosity": 0.0, **changes})


def slowest(count: int, dimension: int = 2) -> tuple[float, float]:
    """The radius of a circle or a ball of so many cells, and ω of its slowest swing, n = 2.

    ω² = n (n² − 1) σ/(ρR³) in 2D and n (n − 1) (n + 2) σ/(ρR³) in 3D.
    """
    if dimension == 2:
        radius, factor = math.sqrt(count / math.pi), 6.0
    else:
        radius, factor = (0.75 * count / math.pi) ** (1.0 / 3.0), 8.0
    return radius, math.sqrt(factor / radius**3)


def surface_energy(energy: float, radius: float, dimension: int) -> float:
    """The energy of the surface of a circle or a ball for its length or area."""
    return energy / (2.0 * math.pi * radius if dimension == 2 else 4.0 * math.pi * radius**2)


def ellipticity(positions: Array) -> Array:
    """The mean square along the first axis less that along the others, over the sum of all, about the center, (F)."""
    places = positions - positions.mean(axis=1, keepdims=True)
    squares = (places**2).mean(axis=1)
    found: Array = (squares[:, 0] - squares[:, 1:].mean(axis=1)) / squares.sum(axis=1)
    return found


def rim(positions: Array) -> Array:
    """The distance of the outermost particle from the center in each of 24 sectors."""
    places = positions - positions.mean(axis=0)
    sector = np.floor(np.arctan2(places[:, 1], places[:, 0]) / (math.pi / 12.0)).astype(int)
    distances = np.linalg.norm(places, axis=1)
    return np.array([distances[sector == each].max() for each in range(-12, 12)])


@pytest.mark.parametrize(("dimension", "spacings"), [(2, 20.0), (2, 30.0), (3, 8.0), (3, 10.0), (3, 12.0)])
def test_a_drop_swings_as_rayleigh_has_it(dimension, spacings, record_property):
    """The frequency to 10 % in 2D and 20 % in 3D, over two periods, with so many spacings in the radius; amplitude 8 %.

    In 2D it is up to 10 % too low, by the grains of a lattice in which particles settle; in 3D some 10 % too high. The
    energy of the surface is that of σ to 3 % in 2D, and to 6 % in 3D, where surfaces are more curved. Rearranging
    particles dissipates: at most 30 % of the amplitude in a period in 2D, 60 % in 3D.
    """
    stretch = np.array([1.08, *[1.08 ** (-1.0 / (dimension - 1))] * (dimension - 1)])
    cells = pc.ball((0.0,) * dimension, spacings, 1.0) * stretch
    radius, omega = slowest(len(cells), dimension)
    period = 2.0 * math.pi / omega
    recording = start(drop(cells)).record(2.0 * period, fps=40.0 / period)
    found, rate = best_wave(recording.times, ellipticity(recording.positions), omega)
    energies = recording.energy.by_term["surface tension"][[0, -1]]
    surface = [surface_energy(float(energy), radius, dimension) for energy in energies]
    record_property("frequency", f"{found / omega - 1.0:+.1%}")
    loss = 1.0 - math.exp(-rate * 2.0 * math.pi / found)
    record_property("loss of amplitude per period", f"{loss:.0%}")
    record_property("energy of the surface over σ", f"{surface[0]:.2f} at first, {surface[-1]:.2f} settled")
    record_property("budget", f"{hole(recording.energy):.1e}")
    assert found == pytest.approx(omega, rel=0.10 if dimension == 2 else 0.20)
    assert loss < (0.3 if dimension == 2 else 0.6)
    assert surface[-1] == pytest.approx(1.0, abs=0.03 if dimension == 2 else 0.06)
    assert hole(recording.energy) < 0.05


@pytest.mark.parametrize(("dimension", "spacings"), [(2, 15.0), (3, 7.0)])
@pytest.mark.parametrize(
    "kernel", [pc.WendlandC2(1.25), pc.WendlandC2(2.0), pc.WendlandC4(), pc.CubicSpline()], ids=str
)
def test_the_energy_of_a_surface_with_other_kernels(kernel, dimension, spacings, record_property):
    """σ to a third: how far a surface settles is measured with the default kernel."""
    cells = pc.ball((0.0,) * dimension, spacings, 1.0)
    radius, omega = slowest(len(cells), dimension)
    run = start(drop(cells), fluids=pc.WeaklyCompressible(kernel=kernel))
    run.run(4.0 * math.pi / omega)
    found = surface_energy(float(run.energy().by_term["surface tension"]), radius, dimension)
    record_property("energy of the surface over σ", f"{found:.2f}")
    assert found == pytest.approx(1.0, abs=0.34)


def best_wave(times: Array, values: Array, omega: float) -> tuple[float, float]:
    """The same as `damped_wave`, over ω within 40 % and losses of up to 69 % a period: the least of several misfits."""
    guesses = [damped_wave(times, values, omega * guess, loss=1.18) for guess in np.linspace(0.65, 1.35, 8)]

    def misfit(wave: tuple[float, float]) -> float:
        frequency, rate = wave
        basis = np.exp(-rate * times)[:, None] * np.stack(
            [np.cos(frequency * times), np.sin(frequency * times)], axis=1
        )
        amplitudes = np.linalg.lstsq(basis, values, rcond=None)[0]
        return float(((basis @ amplitudes - values) ** 2).sum())

    return min(guesses, key=misfit)


def test_a_square_becomes_a_circle(record_property):
    """Within one spacing, and as far out as the circle of its area, whose outermost row is half a spacing in."""
    cells = pc.block((-16.0, -16.0), (16.0, 16.0), 1.0)
    radius, omega = slowest(len(cells))
    run = start(drop(cells, viscosity=0.2))
    run.run(3.0 * 2.0 * math.pi / omega)
    found = rim(run.positions)
    record_property("rim", f"{found.min():.2f} to {found.max():.2f}, circle {radius - 0.5:.2f}")
    assert np.ptp(found) < 1.0
    assert found.mean() == pytest.approx(radius - 0.5, abs=0.5)


def test_a_drop_at_rest_stays_at_rest(record_property):
    """Four periods: the kinetic energy that is left is below 1e-3 of that of the surface, and nothing evaporates."""
    cells = pc.ball((0.0, 0.0), 15.0, 1.0)
    radius, omega = slowest(len(cells))
    run = start(drop(cells))
    recording = run.record(4.0 * 2.0 * math.pi / omega, fps=40.0 * omega)
    kinetic = recording.energy.kinetic / recording.energy.by_term["surface tension"]
    record_property(
        "kinetic energy over that of the surface", f"{kinetic.max():.1e} at most, {kinetic[-1]:.1e} at the end"
    )
    speeds = np.linalg.norm(run.velocities, axis=1)
    record_property("speeds at the end, over √(σ/ρR)", f"{speeds.max() * math.sqrt(radius):.2f} at most")
    assert kinetic[-1] < 1e-3
    assert rim(run.positions).max() < radius + 0.5


@pytest.mark.parametrize("ratio", [1.0, 5.0])
def test_a_drop_in_another_fluid_grows_round(ratio, record_property):
    """A square of a fluid as heavy as the other one and five times as heavy, which fills a periodic box around it."""
    cells = pc.block((-20.0, -20.0), (20.0, 20.0), 1.0)
    inside = np.abs(cells).max(axis=1) < 10.0
    heavy = drop(cells[inside], density=ratio, viscosity=0.2)
    light = drop(cells[~inside], surface_tension=0.0, viscosity=0.2)
    run = start(heavy, light, pc.Periodic((-20.0, -20.0), (20.0, 20.0)))
    radius, omega = slowest(inside.sum())
    run.run(3.0 * 2.0 * math.pi / omega * math.sqrt((1.0 + ratio) / 1.0))
    found = rim(run[heavy].positions)
    mixed = (np.linalg.norm(run[light].positions, axis=1) < found.min() - 1.5).sum()
    record_property("rim", f"{found.min():.2f} to {found.max():.2f}, circle {radius - 0.5:.2f}")
    assert np.ptp(found) < 1.5
    assert mixed == 0


@pytest.mark.parametrize(("dimension", "spacings"), [(2, 12.0), (2, 20.0), (2, 30.0), (3, 8.0), (3, 10.0), (3, 12.0)])
def test_a_drop_has_laplace_s_pressure(dimension, spacings, record_property):
    """(D − 1) σ/R in the middle, as a mean over two periods of its ringing, with so many spacings in the radius: 15 %.

    R is that of the volume of all particles. A surface two spacings thick acts at a radius that is less by up to one,
    8 to 12 % of the smallest, and σ is that of a settled surface to 3 % in 2D and to 6 % in 3D.
    """
    cells = pc.ball((0.0,) * dimension, spacings, 1.0)
    radius, omega = slowest(len(cells), dimension)
    probe = pc.Probe((0.0,) * dimension, radius=0.5 * radius)
    run = start(drop(cells, viscosity=0.1), probe)
    period = 2.0 * math.pi / omega
    run.run(2.0 * period)
    recording = run.record(2.0 * period, fps=20.0 / period)
    found = float(recording[probe].pressure[1:].mean()) * radius / (dimension - 1)
    record_property("pressure over (D − 1) σ/R", f"{found:.3f}")
    assert found == pytest.approx(1.0, abs=0.15)
