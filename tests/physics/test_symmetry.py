"""Symmetry: what the laws of motion do not care about, the numbers do not either."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import (
    ALL,
    EPSILON,
    SYMMETRIC,
    SYMPLECTIC,
    Array,
    Network,
    Orbit,
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


def rotation(seed: int, dimension: int) -> Array:
    """A random orthogonal matrix; every second one is a reflection."""
    return np.linalg.qr(np.random.default_rng(seed).standard_normal((dimension, dimension)))[0]


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


@pytest.mark.parametrize("integrator", ALL, ids=name)
@given(net=networks(damping=0.5), seed=st.integers(0, 2**32 - 1))
def test_turning_and_mirroring_a_network_turns_and_mirrors_its_motion(integrator, net, seed):
    turn = rotation(seed, net.positions.shape[1])
    turned = net.scene(positions=net.positions @ turn, velocities=net.velocities @ turn)
    difference = moved(turned, integrator) - moved(net.scene(), integrator) @ turn
    assert np.abs(difference).max() <= tolerance(net, integrator)


@pytest.mark.parametrize("integrator", ALL, ids=name)
@given(net=networks(damping=0.5))
def test_a_mirror_along_an_axis_changes_signs_and_no_bit(integrator, net):
    """Rounding to nearest treats both signs alike."""
    mirror = np.ones(net.positions.shape[1])
    mirror[0] = -1.0
    mirrored = net.scene(positions=net.positions * mirror, velocities=net.velocities * mirror)
    assert np.array_equal(moved(mirrored, integrator), moved(net.scene(), integrator) * mirror)


@pytest.mark.parametrize("integrator", ALL, ids=name)
@given(net=networks(damping=0.5), seed=st.integers(0, 2**32 - 1))
def test_moving_a_network_moves_its_motion(integrator, net, seed):
    """Galilei: neither where it is nor how fast all of it goes matters. Positions are rounded as numbers of 100 m."""
    shift, boost = np.random.default_rng(seed).uniform(-50.0, 50.0, (2, net.positions.shape[1]))
    start = net.positions + shift
    there = moved(net.scene(positions=start, velocities=net.velocities + boost), integrator)
    # What the shift itself rounded off is part of the start.
    here = moved(net.scene(positions=start - shift), integrator)
    here += np.stack([shift + boost * STEPS * DT, boost])[:, None]
    assert np.abs(there - here).max() <= tolerance(net, integrator, size=200.0)


@pytest.mark.parametrize("integrator", ALL, ids=name)
@given(net=networks(damping=0.5), seed=st.integers(0, 2**32 - 1))
def test_the_order_of_particles_and_springs_does_not_matter(integrator, net, seed):
    """A permutation changes the order of sums, so rounding, and nothing else; results keep the caller's order."""
    rng = np.random.default_rng(seed)
    order, springs = rng.permutation(len(net.mass)), rng.permutation(len(net.pairs))
    place = np.argsort(order)
    pairs = place[net.pairs][springs]
    swap = rng.random(len(pairs)) < 0.5
    pairs[swap] = pairs[swap, ::-1]
    shuffled = net.scene(
        positions=net.positions[order],
        velocities=net.velocities[order],
        mass=net.mass[order],
        pairs=pairs,
        stiffness=net.stiffness[springs],
        rest_length=net.rest_length[springs],
        damping=net.damping[springs],
    )
    difference = moved(shuffled, integrator)[:, place] - moved(net.scene(), integrator)
    assert np.abs(difference).max() <= tolerance(net, integrator)


EXPONENTS = st.integers(-8, 8)


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("integrator", ALL, ids=name)
@given(net=networks(damping=0.5), length=EXPONENTS, time=EXPONENTS, mass=EXPONENTS)
def test_other_units_change_no_bit(integrator, precision, net, length, time, mass):
    """Powers of two as units of length, time and mass scale every number exactly, away from underflow."""
    m, s, kg = 2.0**length, 2.0**time, 2.0**mass
    down = np.zeros(net.positions.shape[1])
    down[-1] = -1.0

    def scene(m: float, s: float, kg: float) -> pc.Scene:
        body = net.body(
            positions=net.positions * m,
            velocities=net.velocities * (m / s),
            stiffness=net.stiffness * (kg / s**2),
            damping=net.damping * (kg / s),
            rest_length=net.rest_length * m,
            mass=net.mass * kg,
        )
        drag = pc.Drag(linear=0.1 * (kg / s), quadratic=0.2 * (kg / m), wind=tuple(down * (m / s)))
        return pc.Scene(body, pc.Gravity(tuple(down * (m / s**2))), drag)

    plain = simulation(scene(1.0, 1.0, 1.0), integrator, DT, precision=precision)
    scaled = simulation(scene(m, s, kg), integrator, DT * s, precision=precision)
    plain.step(50)
    scaled.step(50)
    assert np.array_equal(scaled.positions, plain.positions * m)
    assert np.array_equal(scaled.velocities, plain.velocities * (m / s))
    joule = kg * m**2 / s**2
    assert scaled.energy().balance == plain.energy().balance * joule
    assert scaled.energy().dissipated == plain.energy().dissipated * joule
    assert pc.stability_limit(scaled.scene, integrator) == pc.stability_limit(plain.scene, integrator) * s


WHOLE = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0]


@pytest.mark.parametrize("integrator", ALL, ids=name)
@given(orbit=orbits(), exponent=st.sampled_from(WHOLE), length=EXPONENTS, time=EXPONENTS)
def test_other_units_change_no_bit_of_an_orbit(integrator, orbit, exponent, length, time):
    """A strength is a force at one meter: it scales as F / r^p."""
    m, s = 2.0**length, 2.0**time

    def run(m: float, s: float) -> pc.Simulation:
        center = tuple(np.zeros(orbit.positions.shape[1]))
        body = pc.Particles(orbit.positions * m, orbit.velocities * (m / s))
        strength = (m / s**2) / m**exponent
        field = pc.CentralForce(center, strength, exponent, softening=orbit.softening * m)
        result = simulation(pc.Scene(body, field), integrator, DT * s)
        result.step(50)
        return result

    assert np.array_equal(run(m, s).positions, run(1.0, 1.0).positions * m)
    assert np.array_equal(run(m, s).velocities, run(1.0, 1.0).velocities * (m / s))


@pytest.mark.parametrize("precision", ["f64", "f32"])
@given(length=EXPONENTS, time=EXPONENTS, seed=st.integers(0, 2**32 - 1))
def test_other_units_change_no_bit_of_a_bounce(precision, length, time, seed):
    """Impacts, friction and sliding have no scale of their own."""
    m, s = 2.0**length, 2.0**time
    rng = np.random.default_rng(seed)
    positions, velocities = rng.uniform(-0.5, 0.5, (8, 2)), rng.uniform(-3.0, 3.0, (8, 2))

    def run(m: float, s: float) -> pc.Simulation:
        body = pc.Particles(positions * m, velocities * (m / s), radius=0.05 * m)
        box = pc.Box((-m, -m), (m, m), restitution=0.7, friction=0.2)
        bowl = pc.Sphere((0.0, 0.0), 1.125 * m, inside=True, restitution=0.8, friction=0.1)
        result = simulation(
            pc.Scene(body, pc.Gravity((0.0, -10.0 * m / s**2)), box, bowl),
            pc.VelocityVerlet(),
            0.01 * s,
            precision=precision,
        )
        result.step(200)
        return result

    plain, scaled = run(1.0, 1.0), run(m, s)
    assert plain.energy().dissipated > 0.0
    assert np.array_equal(scaled.positions, plain.positions * m)
    assert np.array_equal(scaled.velocities, plain.velocities * (m / s))
    assert scaled.energy().dissipated == plain.energy().dissipated * (m / s) ** 2


@pytest.mark.parametrize("integrator", ALL, ids=name)
@given(orbit=orbits())
def test_two_dimensions_are_three_with_one_left_out(integrator, orbit):
    """A motion in the plane z = 0 has the same bits in 2D and in 3D: a zero adds nothing."""
    flat = Orbit(orbit.exponent, orbit.softening, orbit.positions[:, :2], orbit.velocities[:, :2])
    zero = np.zeros((1, 1))
    deep = Orbit(orbit.exponent, orbit.softening, np.hstack([flat.positions, zero]), np.hstack([flat.velocities, zero]))
    assert np.array_equal(moved(deep.scene(), integrator)[..., :2], moved(flat.scene(), integrator))
