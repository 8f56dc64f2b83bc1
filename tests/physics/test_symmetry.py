"""Symmetry: what the laws of motion do not care about, the numbers do not either."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

import physcore as pc
from physics.laboratory import (
    ALL,
    EPSILON,
    SYMMETRIC,
    SYMPLECTIC,
    Array,
    Network,
    name,
    networks,
    orbits,
    simulation,
    state,
)

STEPS = 300
DT = 0.005
"""Below a fifteenth of the limit of the stiffest network: ω ≤ 28/s for 100 N/m, 0.5 kg and a few springs each."""


def moved(scene: pc.Scene, integrator: pc.Integrator, steps: int = STEPS) -> Array:
    run = simulation(scene, integrator, DT)
    run.step(steps)
    return state(run)


def growth(net: Network, integrator: pc.Integrator) -> float:
    """By how much a small difference grows during a run, found with one of 1e-9 m."""
    shift = 1e-9 * np.random.default_rng(0).standard_normal(net.positions.shape)
    parted = moved(net.scene(positions=net.positions + shift), integrator) - moved(net.scene(), integrator)
    return max(1.0, float(np.abs(parted).max()) / 1e-9)


def tolerance(net: Network, integrator: pc.Integrator, size: float = 10.0) -> float:
    """How far two runs may part that differ by rounding alone.

    Every step rounds each number, of `size` at most, by an ε of it or a few, and what was rounded off grows as any
    other small difference does. That was measured in one direction: a factor of 10 covers the others.
    """
    return 10.0 * growth(net, integrator) * STEPS * EPSILON * size


@pytest.mark.parametrize("integrator", ALL, ids=name)
@given(net=networks(damping=0.5))
def test_internal_forces_keep_the_momentum(integrator, net):
    """Newton's third law: the springs' forces cancel, and rounding is left: an ε of Σ m |v| per step and force.

    A particle has at most 12 springs in these networks, and a step up to four stages.
    """
    run = simulation(net.scene(), integrator, DT)
    before = run.momentum()
    largest = 0.0
    for _ in range(10):
        run.step(STEPS // 10)
        largest = max(largest, float((net.mass[:, None] * np.abs(run.velocities)).sum()))
    assert np.abs(run.momentum() - before).max() <= 12 * 4 * STEPS * EPSILON * largest


@pytest.mark.parametrize("integrator", SYMPLECTIC, ids=name)
@given(net=networks(damping=0.5))
def test_internal_forces_keep_the_angular_momentum(integrator, net):
    """A kick along a spring turns nothing, damped or not; a drift leaves r × v; the rest is rounding, at r ≤ 5 m."""
    run = simulation(net.scene(), integrator, DT)
    before = run.angular_momentum()
    largest = 0.0
    for _ in range(10):
        run.step(STEPS // 10)
        largest = max(largest, float((net.mass[:, None] * np.abs(run.velocities)).sum()))
    assert np.abs(run.angular_momentum() - before).max() <= 5.0 * 12 * 4 * STEPS * EPSILON * largest


@pytest.mark.parametrize("integrator", SYMPLECTIC, ids=name)
@given(orbit=orbits())
def test_a_central_field_keeps_the_angular_momentum(integrator, orbit):
    """The field pulls along r. An ε of r v ≤ 4 m²/s per operation, of which a step has four stages of six."""
    run = simulation(orbit.scene(), integrator, DT)
    before = run.angular_momentum()
    run.step(STEPS)
    assert np.abs(run.angular_momentum() - before).max() <= 4.0 * 24 * STEPS * EPSILON


@pytest.mark.parametrize("integrator", SYMMETRIC, ids=name)
@given(net=networks())
def test_turned_around_a_network_runs_back_to_its_start(integrator, net):
    run = simulation(net.scene(), integrator, DT)
    start = state(run)
    run.step(STEPS)
    run.set(velocities=-run.velocities)
    run.step(STEPS)
    run.set(velocities=-run.velocities)
    # What the way out rounded off grows on the way back too, and as many steps are rounded again.
    assert np.abs(state(run) - start).max() <= 2.0 * growth(net, integrator) * tolerance(net, integrator)
    assert run.energy().work == 0.0  # Turning the velocities around takes no work.
