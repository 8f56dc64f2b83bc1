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


def slowest(count: int) -> tuple[float, float]:
    """The radius of a circle of so many cells, and ω of its slowest swing: ω² = n (n² − 1) σ/(ρR³), n = 2."""
    radius = math.sqrt(count / math.pi)
    return radius, math.sqrt(6.0 / radius**3)


def ellipticity(positions: Array) -> Array:
    """(⟨x²⟩ − ⟨y²⟩)/(⟨x²⟩ + ⟨y²⟩) about the center, (F)."""
    places = positions - positions.mean(axis=1, keepdims=True)
    x, y = np.moveaxis((places**2).mean(axis=1), 1, 0)
    found: Array = (x - y) / (x + y)
    return found


def rim(positions: Array) -> Array:
    """The distance of the outermost particle from the center in each of 24 sectors."""
    places = positions - positions.mean(axis=0)
    sector = np.floor(np.arctan2(places[:, 1], places[:, 0]) / (math.pi / 12.0)).astype(int)
    distances = np.linalg.norm(places, axis=1)
    return np.array([distances[sector == each].max() for each in range(-12, 12)])


@pytest.mark.parametrize("spacings", [20.0, 30.0])
def test_a_drop_swings_as_rayleigh_has_it(spacings, record_property):
    """The period to 10 %, over two of them, with 20 and with 30 spacings in the radius; amplitude 8 %."""
    cells = pc.ball((0.0, 0.0), spacings, 1.0) * np.array([1.08, 1.0 / 1.08])
    radius, omega = slowest(len(cells))
    period = 2.0 * math.pi / omega
    recording = start(drop(cells)).record(2.0 * period, fps=40.0 / period)
    found, rate = best_wave(recording.times, ellipticity(recording.positions), omega)
    surface = recording.energy.by_term["surface tension"] / (2.0 * math.pi * radius)
    record_property("frequency", f"{found / omega - 1.0:+.1%}")
    record_property("loss of amplitude per period", f"{1.0 - math.exp(-rate * 2.0 * math.pi / found):.0%}")
    record_property("energy of the surface over σ", f"{surface[0]:.2f} at first, {surface[-1]:.2f} settled")
    record_property("budget", f"{hole(recording.energy):.1e}")
    assert found == pytest.approx(omega, rel=0.10)
    assert surface[-1] == pytest.approx(1.0, abs=0.03)
    assert hole(recording.energy) < 0.05


def best_wave(times: Array, values: Array, omega: float) -> tuple[float, float]:
    """The same as `damped_wave`, over ω within 40 %: the least of its misfits from several places."""
    guesses = [damped_wave(times, values, omega * guess) for guess in np.linspace(0.65, 1.35, 8)]

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


def color(positions: Array, middle: float) -> Array:
    """Σ W over its value in a lattice, without the particle itself, within `middle` of the center.

    Wendland's C2 with h = 1.5.
    """

    def total(places: Array, points: Array) -> Array:
        q = np.linalg.norm(places[:, None] - points, axis=-1) / 1.5
        found: Array = (np.clip(1.0 - 0.5 * q, 0.0, None) ** 4 * (2.0 * q + 1.0)).sum(axis=1) - 1.0
        return found

    places = positions - positions.mean(axis=0)
    dimension = places.shape[1]
    lattice = np.stack(np.meshgrid(*[np.arange(-2.0, 3.0)] * dimension), axis=-1).reshape(-1, dimension)
    inside = places[np.linalg.norm(places, axis=1) < middle]
    found: Array = total(inside, places) / total(np.zeros((1, dimension)), lattice)
    return found


@pytest.mark.xfail(
    reason="the energy of tension presses too: a color of 1.1 % (2D) and 1.7 % (3D) above 1 does as much as Laplace's "
    "law, and without a lattice it is off by as much; in the middle +0.4 % and −2.3 %"
)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_drop_has_laplace_s_pressure(dimension, record_property):
    """(D − 1) σ/R in the middle, as a mean over two periods of its ringing, with 12 spacings in the radius: 15 %.

    R is that of the volume of all particles. A surface two spacings thick acts at a radius that is less by up to one,
    8 %, and is within 3 % of σ once it has settled in 2D, in 3D within as much again.

    Why it fails. The energy ½ A (1 − c)² for a volume, with a color c in proportion to the density of the particles
    around, has the pressure A (c − 1) c. A is 7.3 σ/Δ in 2D and 15 σ/Δ in 3D (`moduli` in tension.rs, over `SETTLED`),
    so that c − 1 = (D − 1) σ/(R A), 0.011 and 0.017 here, bears all of Laplace's pressure. c is exactly 1 in lattices
    alone. In a drop they melt, and the equation of state, which sees the density that is carried along, bears what is
    left.
    """
    cells = pc.ball((0.0,) * dimension, 12.0 if dimension == 2 else 8.0, 1.0)
    volume = len(cells)
    radius = math.sqrt(volume / math.pi) if dimension == 2 else (0.75 * volume / math.pi) ** (1.0 / 3.0)
    probe = pc.Probe((0.0,) * dimension, radius=0.5 * radius)
    run = start(drop(cells, viscosity=0.1), probe)
    period = 2.0 * math.pi / math.sqrt(6.0 / radius**3)
    run.run(2.0 * period)
    recording = run.record(2.0 * period, fps=20.0 / period)
    found = float(recording[probe].pressure[1:].mean()) * radius / (dimension - 1)
    off = np.mean([color(positions, 0.5 * radius).mean() for positions in recording.positions[1::8]]) - 1.0
    borne = off * (7.27 if dimension == 2 else 15.02) * radius / (dimension - 1)
    record_property("pressure over (D − 1) σ/R", f"{found:.3f}")
    record_property("color in the middle", f"{off:+.2%}, whose pressure is {borne:+.2f} of it")
    assert found == pytest.approx(1.0, abs=0.15)
