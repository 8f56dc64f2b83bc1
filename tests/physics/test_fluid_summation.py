"""Fluids whose density is counted from where the particles are: energy is that of places and velocities alone."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import EPSILON, Array

SIDE, SPACING, SOUND = 1.0, 0.05, 10.0


COUNTED = pc.WeaklyCompressible(SOUND, artificial_viscosity=0.0, density_from="summation")


def box(cells: Array, velocities: Array | float = 0.0, viscosity: float = 0.0) -> tuple[pc.Fluid, pc.Scene]:
    """An ideal fluid, without any viscosity, in a periodic box that it fills."""
    water = pc.Fluid(cells, SPACING, velocities=velocities, viscosity=viscosity)
    dimension = cells.shape[1]
    return water, pc.Scene(water, pc.Periodic((0.0,) * dimension, (SIDE,) * dimension))


def lattice(dimension: int) -> Array:
    return pc.block((0.0,) * dimension, (SIDE,) * dimension, SPACING)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kernel", [pc.WendlandC2(), pc.WendlandC4(), pc.CubicSpline()], ids=lambda k: type(k).__name__)
def test_a_lattice_has_the_density_at_rest_and_its_compression_is_exact(dimension, kernel):
    """Particles moved by ε sin(kx) along x: ρ/ρ₀ − 1 = −ε k cos(kx), smoothed by (kh)² at most, and to order (εk)².

    At rest the sum in single precision is off by some roundings of 1.2e-7 for each of a hundred neighbors.
    """
    cells = lattice(dimension)
    method = replace(COUNTED, kernel=kernel)
    water, scene = box(cells)
    still = pc.Simulation(scene, dt=1e-5, fluids=method)
    np.testing.assert_allclose(still[water].densities, 1000.0, rtol=1e-6)
    k, size = 2.0 * pi / SIDE, 1e-3
    moved = cells + size * np.sin(k * cells[:, :1]) * np.eye(dimension)[0]
    water, scene = box(moved)
    found = pc.Simulation(scene, dt=1e-5, fluids=method)[water].densities / 1000.0 - 1.0
    exact = -size * k * np.cos(k * cells[:, 0])
    smoothing = (k * kernel.smoothing * SPACING) ** 2
    np.testing.assert_allclose(found, exact, atol=size * k * (smoothing + size * k))
    assert np.corrcoef(found, exact)[0, 1] > 0.999


def swings(dt: float) -> tuple[float, float]:
    """By how much the total energy of a flow swings [J], and its kinetic energy at the start [J]."""
    cells = lattice(2)
    turn = 2.0 * pi * cells
    flow = np.stack([np.sin(turn[:, 1]), np.sin(turn[:, 0])], axis=1)
    _, scene = box(cells, flow)
    run = pc.Simulation(scene, dt=dt, precision="f64", fluids=COUNTED)
    start, energies = run.energy(), []
    for _ in range(20):
        run.run(0.01)
        energies.append(run.energy())
    assert all(energy.dissipated == 0.0 for energy in energies)
    assert max(energy.internal for energy in energies) > 1e-3 * start.kinetic
    return max(abs(energy.total - start.total) for energy in energies), start.kinetic


def test_energy_is_kept_to_the_second_order_of_the_step():
    """Nothing dissipates: places and velocities have a Hamiltonian, and kick–drift–kick keeps it to dt². Halving the
    step leaves a quarter, and half of that again is left for the next order.
    """
    coarse, kinetic = swings(5e-4)
    fine, _ = swings(2.5e-4)
    assert coarse < 1e-5 * kinetic
    assert fine < 1.5 * coarse / 4.0


def test_the_budget_closes_with_viscosity_and_momentum_stays():
    """The budget's hole is that of the step, as without viscosity; momentum changes by roundings of what passes."""
    cells = lattice(2)
    flow = np.stack([np.sin(2.0 * pi * cells[:, 1]), np.cos(2.0 * pi * cells[:, 0])], axis=1)
    water, scene = box(cells, flow, viscosity=1.0)
    run = pc.Simulation(scene, dt=2.5e-4, fluids=replace(COUNTED, artificial_viscosity=0.05))
    start = run.energy()
    moving = float((water.mass[:, None] * np.abs(water.velocities)).sum())
    run.run(0.2)
    end = run.energy()
    assert end.dissipated > 0.05 * start.kinetic
    assert abs(end.balance - start.balance) < 1e-3 * start.kinetic
    assert np.abs(run.momentum()).max() <= np.finfo(np.float32).eps * moving


def test_two_densities_in_balance_stay_at_rest():
    """A heavy fluid beside a light one: particles count alike, so that nothing presses at the interface."""
    cells = lattice(2)
    left = cells[:, 0] < 0.5 * SIDE
    heavy = pc.Fluid(cells[left], SPACING, density=1000.0)
    light = pc.Fluid(cells[~left], SPACING, density=100.0)
    scene = pc.Scene(heavy, light, pc.Periodic((0.0, 0.0), (SIDE, SIDE)))
    run = pc.Simulation(scene, dt=1e-4, precision="f64", fluids=COUNTED)
    run.step(100)
    np.testing.assert_allclose(run[heavy].densities, 1000.0, rtol=1e-9)
    np.testing.assert_allclose(run[light].densities, 100.0, rtol=1e-9)
    assert np.abs(run.velocities).max() < 1e3 * EPSILON * SOUND


def test_walls_close_the_space():
    """Between walls on all sides the images count too: the density at rest is the same up to the walls."""
    cells = lattice(2)
    water = pc.Fluid(cells, SPACING)
    run = pc.Simulation(pc.Scene(water, pc.Box((0.0, 0.0), (SIDE, SIDE))), dt=1e-4, fluids=COUNTED)
    np.testing.assert_allclose(run[water].densities, 1000.0, rtol=1e-6)


def test_a_free_surface_is_refused_with_a_hint():
    water = pc.Fluid(pc.ball((0.0, 0.0), 0.5, SPACING), SPACING)
    with pytest.raises(pc.SceneError, match=r"density_from.*fills its space.*continuity"):
        pc.Simulation(pc.Scene(water), dt=1e-4, fluids=COUNTED)
    with pytest.raises(pc.SceneError, match=r"WeaklyCompressible\.density_from: must be 'continuity' or 'summation'"):
        pc.WeaklyCompressible(density_from="sum")  # type: ignore[arg-type]
