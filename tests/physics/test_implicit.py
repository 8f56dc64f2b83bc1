"""Implicit methods: their factors on an oscillator, orders, what they keep, what they meter, and what they refuse."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import EPSILON, Array, state
from physics.test_projection import euler, sheet

METHODS = [pc.BackwardEuler(), pc.ImplicitMidpoint(), pc.BDF2()]
GRAVITY = np.array([0.0, 0.0, -9.81])


def name(value: object) -> str:
    return type(value).__name__


@settings(max_examples=40, deadline=None)
@given(z=st.floats(0.01, 1000.0), damping=st.floats(0.0, 2.0))
def test_a_damped_oscillator_takes_the_exact_factors(z, damping):
    """x″ = −ω²(x − 1) − 2ξω x′ along the spring: each step is a rational function of the matrix A of the system. The
    tolerance of the equation is 1e-10 of the largest force.
    """
    omega, mass = 20.0, 2.0
    body = pc.SpringNetwork(
        [[0.0, 0.0], [1.2, 0.0]],
        [[0, 1]],
        mass * omega**2,
        2 * damping * omega * mass,
        rest_length=1.0,
        mass=mass,
        fixed=[0],
    )
    h = z / omega
    matrix, one = h * np.array([[0.0, 1.0], [-(omega**2), -2 * damping * omega]]), np.eye(2)
    factors = {
        pc.BackwardEuler(): np.linalg.inv(one - matrix),
        pc.ImplicitMidpoint(): np.linalg.solve(one - 0.5 * matrix, one + 0.5 * matrix),
    }
    for integrator, factor in factors.items():
        run = pc.Simulation(pc.Scene(body), integrator, dt=h)
        expected = np.array([0.2, 0.0])
        for _ in range(4):
            run.step()
            expected = factor @ expected
            found = np.array([run.positions[1, 0] - 1.0, run.velocities[1, 0]])
            assert np.abs((found - expected) / [0.2, 0.2 * omega]).max() < 1e-8


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_backward_euler_solves_its_equation(damping):
    """Beside Newton's method with dense matrices, written down apart from it; forces are balanced to 1e-10 of some
    100 N, over a stiffness of 300 N/m.
    """
    body = sheet(5, 300.0, damping, rest=0.8)
    run = pc.Simulation(pc.Scene(body, pc.Gravity(tuple(GRAVITY))), pc.BackwardEuler(), dt=0.01)
    run.step()
    x, v = euler(body, 0.01, GRAVITY)
    assert np.abs(run.positions - x).max() < 1e-10
    assert np.abs(run.velocities - v).max() < 1e-8


@pytest.mark.parametrize("integrator", METHODS, ids=name)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_damped_network_is_solved_to_its_order(integrator, dimension):
    def after(count: int, kind: pc.Integrator) -> Array:
        body = sheet(5, 10.0, 0.002, dimension)
        scene = pc.Scene(body, pc.Gravity(-9.81 * np.eye(dimension)[-1]), pc.Drag(0.01))
        run = pc.Simulation(scene, kind, dt=0.2 / count)
        run.step(count)
        assert run.plan.order == kind.order
        return run.positions

    exact = after(2000, pc.RungeKutta4())
    errors = [np.abs(after(count, integrator) - exact).max() for count in (200, 400)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(integrator.order, abs=0.25)


def test_the_midpoint_rule_goes_back_and_keeps_momentum_and_angular_momentum():
    """Forces are balanced to 1e-10 of the largest in each of 100 steps; there and back the motion is not yet chaotic.
    What is left over of the forces adds to momentum at random.
    """
    body = sheet(5, 300.0)
    free = pc.SpringNetwork(body.positions, body.pairs, body.stiffness, mass=body.mass, velocities=body.velocities)
    run = pc.Simulation(pc.Scene(free), pc.ImplicitMidpoint(1e-13), dt=5e-3)
    start, momentum, spin = state(run), run.momentum(), run.angular_momentum()
    run.step(50)
    scale = float(free.mass @ np.linalg.norm(free.velocities, axis=1))
    assert np.abs(run.momentum() - momentum).max() < 1e-10 * scale
    assert np.abs(run.angular_momentum() - spin).max() < 1e-10 * scale
    run.set(velocities=-run.velocities)
    run.step(50)
    back = state(run) * np.array([1.0, -1.0])[:, None, None]
    assert np.abs(back - start).max() < 1e-8


@pytest.mark.parametrize("integrator", [pc.BackwardEuler(), pc.BDF2()], ids=name)
def test_what_a_method_damps_is_drift_and_downwards(integrator):
    """Nothing rubs: nothing is dissipated. The balance falls, and at steps of a frame most of a fast swing is gone."""
    cloth = pc.cloth((8, 8), 0.05, 1e4, mass=0.01, axes=((1, 0, 0), (0, 1, 0)), pinned="top corners")
    recording = pc.simulate(pc.Scene(cloth, pc.Gravity((0.0, 0.0, -9.81))), 2.0, fps=50, integrator=integrator, dt=0.02)
    assert not recording.energy.dissipated.any()
    assert recording.energy.drift.max() < 1e-6
    assert recording.energy.drift[-1] < -0.05


@pytest.mark.parametrize("integrator", METHODS, ids=name)
def test_dissipation_is_metered_to_the_order_of_the_method(integrator):
    body = sheet(5, 10.0, 0.002)
    scene = pc.Scene(body, pc.Gravity(tuple(GRAVITY)), pc.Drag(0.01))
    exact = pc.Simulation(scene, pc.RungeKutta4(), dt=1e-4)
    exact.run(0.3)
    errors = []
    for dt in (1e-3, 5e-4):
        run = pc.Simulation(scene, integrator, dt=dt)
        run.run(0.3)
        errors.append(abs(run.energy().dissipated / exact.energy().dissipated - 1.0))
    assert errors[1] < (0.1 if integrator.order == 1 else 2e-3)
    assert math.log2(errors[0] / errors[1]) == pytest.approx(integrator.order, abs=0.4)


@pytest.mark.parametrize("integrator", METHODS, ids=name)
def test_a_moving_end_does_the_work(integrator):
    body = pc.SpringNetwork(
        [[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 50.0, 1.0, fixed=[0], velocities=[[0.3, 0.1], [0.0, 0.0]]
    )
    balances = []
    for dt in (4e-3, 2e-3):
        run = pc.Simulation(pc.Scene(body), integrator, dt=dt)
        start = run.energy().balance
        run.run(2.0)
        assert abs(run.energy().work) > 0.01
        np.testing.assert_array_equal(run.velocities[0], [0.3, 0.1])
        balances.append(abs(run.energy().balance - start))
    assert math.log2(balances[0] / balances[1]) > integrator.order - 0.4


@pytest.mark.parametrize("integrator", METHODS, ids=name)
def test_a_stiff_cloth_rests_on_a_ball_in_steps_of_a_frame(integrator):
    cloth = pc.cloth((10, 10), 0.05, 1e4, 0.1, mass=0.005, axes=((1, 0, 0), (0, 1, 0)), origin=(-0.225, -0.225, 0.26))
    ball = pc.Sphere((0.0, 0.0, 0.0), 0.2, inside=False, restitution=0.0, friction=0.5)
    recording = pc.simulate(
        pc.Scene(cloth, pc.Gravity(tuple(GRAVITY)), ball), 0.6, fps=50, integrator=integrator, dt=1 / 100
    )
    assert np.linalg.norm(recording.positions, axis=2).min() > 0.2 - 1e-9
    assert recording.energy.dissipated_by["contacts"][-1] > 0.0


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_twelve_decades_of_stiffness_are_borne(precision):
    """Without being told apart: a chain whose links are from soft to as good as rigid."""
    stiffness = 10.0 ** np.arange(0, 13, 2)
    nodes = np.column_stack([np.arange(8.0), np.zeros(8)])
    body = pc.SpringNetwork(nodes, np.column_stack([np.arange(7), np.arange(1, 8)]), stiffness, mass=0.1, fixed=[0])
    run = pc.Simulation(
        pc.Scene(body, pc.Gravity((0.0, -9.81))), pc.BackwardEuler(1e-6), dt=1 / 60, precision=precision
    )
    run.step(60)
    lengths = np.linalg.norm(np.diff(run.positions, axis=0), axis=1)
    assert np.abs(lengths[2:] - 1.0).max() < 0.01
    assert np.isfinite(state(run)).all()


def test_an_equation_that_is_not_solved_is_no_step():
    """Sixty particles, all pairs of which push each other apart in steps of a thousand periods: there are very many
    equilibria, and Newton's method wanders among them. Nothing is lost, and the error says what is left.
    """
    rng = np.random.default_rng(0)
    rng.uniform(-1, 1, 3000)
    places, pairs = rng.uniform(-1, 1, (60, 3)), [(i, j) for i in range(60) for j in range(i)]
    body = pc.SpringNetwork(places, pairs, 1e6, rest_length=3.0, velocities=rng.normal(size=(60, 3)))
    run = pc.Simulation(pc.Scene(body), pc.BackwardEuler(), dt=10.0)
    before = state(run)
    message = (
        r"step 1 .* was not found in 200 iterations of Newton's method: .* of the forces is left unbalanced; .*try dt"
    )
    with pytest.raises(pc.SimulationDiverged, match=message):
        run.step(3)
    np.testing.assert_array_equal(state(run), before)
    assert run.steps == 0


def test_the_plan_says_how_much_work_a_step_was():
    run = pc.Simulation(pc.Scene(sheet(5), pc.Gravity(tuple(GRAVITY))), pc.BDF2(), dt=0.01)
    run.step(5)
    assert any("iterations of Newton's method per step" in note for note in run.plan.notes)
    assert math.isinf(run.plan.dt_limit)


@pytest.mark.parametrize("integrator", METHODS, ids=name)
@pytest.mark.parametrize(
    "item",
    [
        pc.CustomForce(lambda time, positions, velocities: -positions),
        pc.Gravitation(1.0, softening=0.1, opening_angle=0.5),
    ],
    ids=name,
)
def test_forces_without_derivatives_are_refused_by_name(integrator, item):
    match = f"integrator: expected .* for a {type(item).__name__}, got {type(integrator).__name__} .*derivatives"
    with pytest.raises(pc.SceneError, match=match):
        pc.Simulation(pc.Scene(sheet(3), item), integrator)


def crowd(*items: Any, dimension: int = 3, charge: bool = False) -> pc.Scene:
    """Particles on a jittered lattice, 1.2 spacings in diameter, in slow motion; with charges of ±1 C if wished."""
    rng = np.random.default_rng(4)
    sites = pc.block((0.0,) * dimension, (3.0,) * dimension, 1.0)
    places = sites + rng.uniform(-0.1, 0.1, sites.shape)
    speeds, masses = rng.uniform(-0.2, 0.2, sites.shape), rng.uniform(0.5, 1.5, len(sites))
    charges = rng.choice([-1.0, 1.0], len(sites)) if charge else 0.0
    return pc.Scene(pc.Particles(places, speeds, mass=masses, radius=0.6, charge=charges), *items)


def sources() -> pc.Scene:
    """Two masses in free motion that attract others and do not feel them."""
    heavy = pc.Particles([[-1.0, 1.0, 1.0], [3.5, 2.0, 1.0]], [[0.0, 0.3, 0.0], [-0.2, 0.0, 0.1]], mass=20.0)
    return pc.Scene(heavy, *crowd().bodies, pc.Gravitation(0.2, softening=0.2, sources=heavy))


def bent(*items: Any, damping: float = 1e-4) -> pc.Scene:
    """A dented sheet, with its hinges, that two corners hold."""
    rng = np.random.default_rng(3)
    cloth = pc.cloth((4, 4), 0.1, 20.0, 0.02, mass=0.01, origin=(0.0, 0.0, 0.0))
    dented = cloth.positions + rng.uniform(-0.015, 0.015, cloth.positions.shape)
    body = pc.SpringNetwork(dented, cloth.pairs, 20.0, 0.02, mass=0.01, fixed=[0, 3], faces=cloth.faces)
    return pc.Scene(body, pc.Gravity((0.0, 0.0, -9.81)), pc.Dihedral(body, 0.02, damping), *items)


SMOOTH = {
    "atoms": lambda: crowd(pc.LennardJones(1.0, 0.9)),
    "atoms in 2D": lambda: crowd(pc.LennardJones(1.0, 0.9), dimension=2),
    "spheres that overlap": lambda: crowd(pc.SoftSpheres(20.0, 0.3, friction=10.0, tangential_damping=0.2)),
    "masses that attract": lambda: crowd(pc.Gravitation(0.5, softening=0.3)),
    "masses in two heavy ones": sources,
    "charges": lambda: crowd(pc.Coulomb(0.1), charge=True),
    "an attracting center": lambda: crowd(pc.CentralForce((1.0, 1.0, 4.0), 2.0, softening=0.3)),
    "drag that grows with the speed": lambda: crowd(
        pc.Drag(0.1, 0.5, wind=(1.0, 0.0, 0.5)), pc.Gravity((0.0, 0.0, -2.0))
    ),
    "drag in two winds": lambda: crowd(pc.Drag(0.3, wind=(1.0, 0.0, 0.0)), pc.Drag(0.2, wind=(0.0, 1.0, 0.0))),
    "hinges": bent,
    "hinges in the wind": lambda: bent(pc.Wind((1.0, -0.5, 2.0), 1.2)),
}


@pytest.mark.parametrize("integrator", METHODS, ids=name)
@pytest.mark.parametrize("make", SMOOTH.values(), ids=SMOOTH)
def test_all_forces_with_derivatives_are_followed_to_the_order(integrator, make):
    """Half the step leaves 2^−p of the error; soft spheres gain and lose neighbors, where their force has a kink."""

    def after(count: int, kind: pc.Integrator) -> Array:
        run = pc.Simulation(make(), kind, dt=0.1 / count)
        run.step(count)
        return run.positions

    exact = after(200, pc.RungeKutta4())
    errors = [float(np.abs(after(count, integrator) - exact).max()) for count in (10, 20, 40)]
    assert math.log2(errors[1] / errors[2]) == pytest.approx(integrator.order, abs=0.3), errors


def test_the_midpoint_rule_keeps_the_energy_of_all_potentials():
    """Symmetric: no drift, and an error of order dt², of energies exchanged of some 1 J and 1e-3 J."""
    for make, dt, size in ((SMOOTH["atoms"], 0.01, 1.0), (lambda: bent(damping=0.0), 2e-3, 1e-3)):
        scene = make()
        errors = []
        for step in (dt, dt / 2.0):
            run = pc.Simulation(scene, pc.ImplicitMidpoint(), dt=step)
            start = run.energy().balance
            run.run(60 * dt)
            errors.append(abs(run.energy().balance - start))
        assert errors[0] < 0.05 * size or errors[1] < 0.3 * errors[0], errors


def test_stiff_bending_takes_long_steps():
    """A plate of 5 J, which Verlet could not step by 1/200 s, comes to rest where it does in short ones."""
    cloth = pc.cloth((6, 3), 0.1, 2000.0, 1.0, mass=0.01, origin=(0.0, 0.0, 0.0), pinned="left")
    body = pc.SpringNetwork(
        cloth.positions, cloth.pairs, 2000.0, 1.0, mass=0.01, fixed=cloth.positions[:, 0] < 0.15, faces=cloth.faces
    )
    scene = pc.Scene(body, pc.Gravity((0.0, 0.0, -9.81)), pc.Dihedral(body, 5.0, 0.02), pc.Drag(0.5))
    assert pc.stability_limit(scene, pc.VelocityVerlet()) < 5e-4
    rests = []
    for integrator, dt in ((pc.BackwardEuler(), 0.05), (pc.BDF2(), 0.01)):
        run = pc.Simulation(scene, integrator, dt=dt)
        run.run(4.0)
        assert np.abs(run.velocities).max() < 1e-6
        rests.append(run.positions)
    assert rests[0][:, 2].min() < -1e-4
    assert np.abs(rests[0] - rests[1]).max() < 1e-7


@pytest.mark.parametrize("kind", [pc.BackwardEuler, pc.ImplicitMidpoint, pc.BDF2])
def test_a_tolerance_out_of_range_is_refused(kind: Any):
    for tolerance in (0.0, -1.0, math.nan, "small"):
        with pytest.raises(pc.SceneError, match=rf"{kind.__name__}\.tolerance"):
            kind(tolerance)


def test_rods_are_refused():
    rod = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], math.inf)
    with pytest.raises(pc.SceneError, match=r"RATTLE\(\) or XPBD\(\) for rods, got BDF2"):
        pc.Simulation(pc.Scene(rod), pc.BDF2())


def test_rounding_is_all_that_is_left_of_rest():
    """A hanging chain at rest stays there, whatever the step: the residual is a few roundings of k r."""
    lengths = 0.1 + 0.1 * 9.81 * np.arange(5, 0, -1) / 500.0
    nodes = np.column_stack([np.zeros(6), -np.concatenate([[0.0], np.cumsum(lengths)])])
    body = pc.SpringNetwork(
        nodes, np.column_stack([np.arange(5), np.arange(1, 6)]), 500.0, rest_length=0.1, mass=0.1, fixed=[0]
    )
    for integrator in METHODS:
        run = pc.Simulation(pc.Scene(body, pc.Gravity((0.0, -9.81))), integrator, dt=0.1)
        run.step(50)
        assert np.abs(run.positions - nodes).max() < 1e4 * EPSILON


@pytest.mark.parametrize("method", [pc.BackwardEuler(), pc.ImplicitMidpoint(), pc.BDF2()], ids=repr)
@pytest.mark.parametrize(
    "forces",
    [
        (pc.Gravity((0.0, -9.81)), pc.Drag(linear=1e3)),
        (pc.Gravity((0.0, -9.81)), pc.Drag(linear=50.0, wind=(3.0, 9.0))),
        (pc.CentralForce((40.0, 30.0), 1e4, exponent=1.0), pc.Drag(linear=1e3)),
    ],
    ids=["terminal velocity", "terminal velocity in wind", "the bottom of a well"],
)
def test_forces_that_balance_leave_no_residual_but_rounding(method, forces):
    """At the end the net force is far below its terms: its rounding is not held against the solution."""
    scene = pc.Scene(pc.Particles([[0.1, 0.2], [39.0, 31.0]]), *forces)
    run = pc.Simulation(scene, method, dt=0.05)
    run.run(40.0)
    drag = forces[1]
    wind = np.array(drag.wind or (0.0, 0.0))
    if isinstance(forces[0], pc.Gravity):
        expected = np.broadcast_to(wind + np.array([0.0, -9.81 / drag.linear]), (2, 2))
        np.testing.assert_allclose(run.velocities, expected, rtol=1e-9, atol=1e-12)
    else:
        np.testing.assert_allclose(run.positions, np.broadcast_to((40.0, 30.0), (2, 2)), rtol=1e-12)
