"""Wave functions: modes, orders, conservation, absorbing edges, an interaction, and bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc

METHODS = [pc.SplitStep(), pc.SplitStep(order=4), pc.CrankNicolson(), pc.Staggered()]
ENDS = [("fixed", "fixed"), ("free", "free"), ("fixed", "free"), ("free", "fixed"), ("periodic", "periodic")]


def run(item: pc.Schrodinger, integrator: pc.Integrator, dt: float, steps: int, **numerics: object) -> pc.Simulation:
    simulation = pc.Simulation(pc.Scene(item), integrator=integrator, dt=dt, precision="f64", **numerics)
    simulation.step(steps)
    return simulation


def mode(ends: tuple[str, str], count: int, number: int) -> tuple[np.ndarray, float]:
    """A mode between two ends, and its wave number per spacing."""
    places = np.arange(count) + 0.5
    if ends[0] == "periodic":
        q = 2 * np.pi * number / count
        return np.exp(1j * q * places), q
    half = 0.5 * (ends[0] != ends[1])
    q = np.pi * (number + half) / count
    return (np.sin if ends[0] == "fixed" else np.cos)(q * places) + 0j, q


@pytest.mark.parametrize("cells", [2, 5, 8, 9])
@pytest.mark.parametrize("ends", ENDS)
def test_modes_turn_at_their_energies(ends: tuple[str, str], cells: int) -> None:
    # ψ exp(−iEt/ħ) with E = ħ²q²/2m for split steps, to rounding: transforms of even and odd lengths, at all ends.
    wave, q = mode(ends, cells, 1)
    grid = pc.Grid((cells,), 0.7, periodic=ends[0] == "periodic")
    edges = {} if grid.periodic[0] else {"x-": ends[0], "x+": ends[1]}
    item = pc.Schrodinger(grid, wave, mass=1.3, hbar=0.9, edges=edges)
    energy = (0.9 * q / 0.7) ** 2 / (2 * 1.3)
    simulation = run(item, pc.SplitStep(), 0.3, 4)
    assert np.abs(simulation[item].wave_function - wave * np.exp(-1j * energy * 1.2 / 0.9)).max() < 1e-13
    norm = np.sum(np.abs(wave) ** 2) * 0.7
    assert math.isclose(simulation.energy().kinetic, energy * norm, rel_tol=1e-12)


@pytest.mark.parametrize("ends", ENDS)
def test_differences_have_their_own_modes(ends: tuple[str, str]) -> None:
    # With three points E = ħ²/mh² (1 − cos q), and a step of Crank and Nicolson's turns by 2 atan(E dt/2ħ).
    wave, q = mode(ends, 8, 1)
    grid = pc.Grid((8,), 0.7, periodic=ends[0] == "periodic")
    edges = {} if grid.periodic[0] else {"x-": ends[0], "x+": ends[1]}
    item = pc.Schrodinger(grid, wave, mass=1.3, hbar=0.9, edges=edges)
    energy = 0.81 / (1.3 * 0.49) * (1 - math.cos(q))
    turned = wave * np.exp(-4j * 2 * math.atan(energy * 0.3 / 1.8))
    assert np.abs(run(item, pc.CrankNicolson(), 0.3, 4)[item].wave_function - turned).max() < 1e-13
    leap = np.exp(-4j * 2 * math.asin(energy * 0.3 / 1.8))  # Visscher's: a leapfrog of both parts
    if ends[0] != "periodic":
        shown = run(item, pc.Staggered(), 0.3, 4)[item].wave_function
        assert np.abs(shown.real - (wave * leap).real).max() < 1e-13


@pytest.mark.parametrize("method", METHODS, ids=repr)
@pytest.mark.parametrize("cells", [(24,), (12, 10), (6, 5, 4)], ids=["1D", "2D", "3D"])
def test_orders(method: pc.Integrator, cells: tuple[int, ...]) -> None:
    grid = pc.Grid(cells, 0.5)
    middle = np.array(grid.upper) / 2
    packet = pc.wave_packet(grid, middle, 0.4, 0.8)
    item = pc.Schrodinger(grid, packet, potential=lambda *x: 0.5 * sum((a - m) ** 2 for a, m in zip(x, middle)))
    base = 8 if method != pc.Staggered() else 64
    ends = [run(item, method, 0.8 / steps, steps)[item].wave_function for steps in (base, 2 * base, 4 * base)]
    order = math.log2(np.linalg.norm(ends[0] - ends[1]) / np.linalg.norm(ends[1] - ends[2]))
    assert abs(order - method.order) < 0.25, order


@pytest.mark.parametrize("method", METHODS, ids=repr)
def test_probability_is_kept_and_threads_change_no_bit(method: pc.Integrator) -> None:
    grid = pc.Grid((40, 36), 0.5)
    item = pc.Schrodinger(grid, pc.wave_packet(grid, (8, 9), (1, -0.5), 1.5), potential=lambda x, y: 0.1 * x)
    one, two = (run(item, method, 0.02, 50, threads=threads) for threads in (1, 2))
    assert one.state_hash() == two.state_hash()
    bound = 1e-12 if method != pc.Staggered() else 1e-3  # whose norm oscillates by (E dt/ħ)²
    assert abs(one.budgets()["probability"].total - 1.0) < bound
