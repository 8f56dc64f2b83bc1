"""Rods: constant lengths, order, reversibility, conservation and tensions of RATTLE, and what it refuses."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

import physcore as pc
from physcore.integrators import INTEGRATORS
from physics.laboratory import EPSILON, Array, state

INF = math.inf


def network(seed: int, dimension: int, *, fixed: bool, elastic: bool, redundant: bool = False) -> pc.SpringNetwork:
    """A random tree of rods, with some more that close loops, or springs instead; in f64 a quarter of its nodes' size
    apart at least. All that is redundant is a rod given twice.
    """
    rng = np.random.default_rng(seed)
    nodes = int(rng.integers(3, 9))
    sites = np.stack(np.meshgrid(*[np.arange(4)] * dimension, indexing="ij"), -1).reshape(-1, dimension)
    positions = rng.permutation(sites)[:nodes] + rng.uniform(-0.3, 0.3, (nodes, dimension))
    tree = [(int(rng.integers(node)), node) for node in range(1, nodes)]
    others = [(i, j) for j in range(nodes) for i in range(j) if (i, j) not in tree]
    chosen = [others[k] for k in rng.permutation(len(others))[: int(rng.integers(0, 3))]] if elastic else []
    pairs = [*tree, *chosen, *(tree[:1] if redundant else [])]
    stiffness = np.where(np.arange(len(pairs)) < len(tree), INF, 30.0)
    stiffness[len(tree) + len(chosen) :] = INF
    return pc.SpringNetwork(
        positions,
        pairs,
        stiffness,
        mass=rng.uniform(0.3, 3.0, nodes),
        velocities=rng.uniform(-1.0, 1.0, (nodes, dimension)),
        fixed=[0] if fixed else None,
    )


def still(body: pc.SpringNetwork) -> pc.SpringNetwork:
    """The same network with the first node at rest, as a fixed one has to be for its energy to be constant."""
    velocities = body.velocities.copy()
    velocities[0] = 0.0
    return pc.SpringNetwork(
        body.positions, body.pairs, body.stiffness, 0.0, body.rest_length, body.mass, body.fixed, velocities
    )


def missed(run: pc.Simulation, body: pc.SpringNetwork) -> tuple[float, float]:
    """The largest relative error of a rod's length, and the largest velocity along a rod."""
    ends = body.pairs[body.rods]
    arm = np.diff(run.positions[ends], axis=1)[:, 0]
    rate = np.diff(run.velocities[ends], axis=1)[:, 0]
    length = np.linalg.norm(arm, axis=1)
    return float(np.abs(length / body.rest_length[body.rods] - 1.0).max()), float(
        np.abs((arm * rate).sum(axis=1) / length).max()
    )


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    dimension=st.sampled_from([2, 3]),
    fixed=st.booleans(),
    elastic=st.booleans(),
    redundant=st.booleans(),
)
def test_any_network_keeps_its_lengths_and_goes_back(seed, dimension, fixed, elastic, redundant):
    """Coordinates are below 4 m and rods longer than 0.4 m: a rounding of both ends is 2 · 4 ε/2 of 0.4 m = 10 ε of the
    length, a little more for the other rods of a node. Backward errors of a hundred steps there and back are those of
    200 positions, amplified by a motion that is not yet chaotic: some 10³ of them, and 10 more as a margin.
    """
    body = still(network(seed, dimension, fixed=fixed, elastic=elastic, redundant=redundant))
    gravity = pc.Gravity(-9.81 * np.eye(dimension)[-1])
    run = pc.Simulation(pc.Scene(body, gravity), dt=1e-3)
    start, before = state(run), run.energy().balance
    run.step(100)
    lengths, along = missed(run, body)
    assert lengths < 100 * EPSILON
    assert along < 100 * EPSILON * (1.0 + np.abs(run.velocities).max())
    # Of order 2: (ω dt)² of the energies that are exchanged, with ω below 30/s.
    kinetic = 0.5 * body.mass @ (run.velocities**2).sum(axis=1)
    assert abs(run.energy().balance - before) < 1e-3 * (1.0 + kinetic)
    run.set(velocities=-run.velocities)
    run.step(100)
    back = state(run) * np.array([1.0, -1.0])[:, None, None]
    assert np.abs(back - start).max() < 1e4 * 4.0 * EPSILON


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), dimension=st.sampled_from([2, 3]), fixed=st.booleans(), redundant=st.booleans())
def test_steps_of_order_4_keep_lengths_and_energy_and_go_back(seed, dimension, fixed, redundant):
    """As those of order 2, whose five steps are up to 0.66 of a step long, with (ω dt)⁴ of the energy."""
    body = still(network(seed, dimension, fixed=fixed, elastic=True, redundant=redundant))
    run = pc.Simulation(pc.Scene(body, pc.Gravity(-9.81 * np.eye(dimension)[-1])), pc.RATTLE(4), dt=2e-3)
    start, before = state(run), run.energy().balance
    run.step(50)
    lengths, along = missed(run, body)
    assert lengths < 100 * EPSILON
    assert along < 100 * EPSILON * (1.0 + np.abs(run.velocities).max())
    kinetic = 0.5 * body.mass @ (run.velocities**2).sum(axis=1)
    assert abs(run.energy().balance - before) < 1e-5 * (1.0 + kinetic)
    run.set(velocities=-run.velocities)
    run.step(50)
    back = state(run) * np.array([1.0, -1.0])[:, None, None]
    assert np.abs(back - start).max() < 1e4 * 4.0 * EPSILON


def truss(side: int, dimension: int) -> pc.SpringNetwork:
    """A braced lattice, of whose rods many are redundant, in rotation and on its way."""
    rng = np.random.default_rng(side)
    nodes = np.stack(np.meshgrid(*[np.arange(side)] * dimension, indexing="ij"), -1).reshape(-1, dimension) * 0.5
    pairs = [[i, j] for j in range(len(nodes)) for i in range(j) if np.linalg.norm(nodes[i] - nodes[j]) < 0.9]
    turn = np.column_stack([-nodes[:, 1], nodes[:, 0], *(0.0 * nodes[:, 2:].T)])
    return pc.SpringNetwork(nodes, pairs, INF, mass=rng.uniform(0.2, 2.0, len(nodes)), velocities=1.3 * turn + 0.4)


@pytest.mark.parametrize("order", [2, 4])
@pytest.mark.parametrize(("side", "dimension"), [(2, 2), (4, 2), (2, 3), (3, 3)])
def test_trusses_are_rigid_and_keep_energy_and_momentum(order, side, dimension):
    """A rigid body in free rotation in a plane keeps its energy to rounding, by either order, and goes back."""
    body = truss(side, dimension)
    run = pc.Simulation(pc.Scene(body), pc.RATTLE(order), dt=5e-3)
    start, energy, spin = state(run), run.energy().total, run.angular_momentum()
    run.step(40)
    lengths, _ = missed(run, body)
    assert lengths < 1e3 * EPSILON
    assert run.energy().total == pytest.approx(energy, rel=1e-12)
    np.testing.assert_allclose(run.angular_momentum(), spin, atol=1e-12 * float(body.mass.sum()) * 10.0)
    run.set(velocities=-run.velocities)
    run.step(40)
    back = state(run) * np.array([1.0, -1.0])[:, None, None]
    assert np.abs(back - start).max() < 1e5 * EPSILON


@pytest.mark.parametrize("dimension", [2, 3])
def test_free_networks_keep_momentum_and_angular_momentum(dimension):
    """Impulses along rods are equal and opposite: what is left is rounding, of 500 steps and 8 nodes, at random."""
    body = network(5, dimension, fixed=False, elastic=True)
    recording = pc.simulate(pc.Scene(body), 1.0, fps=20, dt=2e-3)
    scale = 4.0 * float(body.mass @ np.linalg.norm(body.velocities, axis=1))
    for conserved in (recording.momentum, recording.angular_momentum):
        assert np.abs(conserved - conserved[0]).max() < math.sqrt(500 * 8) * EPSILON * scale


def double_pendulum(**more: Any) -> pc.Scene:
    nodes = np.array([[0.0, 0.0], [0.9, -0.4], [1.2, -1.0]])
    body = pc.SpringNetwork(nodes, [[0, 1], [1, 2]], INF, mass=[1.0, 1.0, 0.5], fixed=[0], **more)
    return pc.Scene(body, pc.Gravity((0.0, -9.81)))


@pytest.mark.parametrize(("order", "steps"), [(2, (500, 1000, 2000)), (4, (60, 120, 240))])
def test_the_order_is_that_of_the_integrator(order, steps, record_property):
    (exact := pc.Simulation(double_pendulum(), pc.RATTLE(4), dt=1.0 / 4000)).step(4000)
    errors = []
    for count in steps:
        (run := pc.Simulation(double_pendulum(), pc.RATTLE(order), dt=1.0 / count)).step(count)
        assert run.plan.order == order
        errors.append(float(np.abs(state(run) - state(exact)).max()))
    record_property("errors", errors)
    assert math.log2(errors[1] / errors[2]) == pytest.approx(order, abs=0.1)


def test_drag_and_springs_leave_order_2():
    def after(count: int) -> Array:
        nodes = [[0.0, 0.0], [1.0, 0.0], [1.5, 0.5], [2.0, 0.0]]
        body = pc.SpringNetwork(nodes, [[0, 1], [1, 2], [2, 3]], [INF, 40.0, INF], 0.2, fixed=[0])
        scene = pc.Scene(body, pc.Gravity((0.0, -9.81)), pc.Drag(linear=0.3, quadratic=0.1))
        (run := pc.Simulation(scene, pc.RATTLE(), dt=1.0 / count)).step(count)
        assert run.energy().dissipated > 0.1
        return state(run)

    exact = after(8000)
    errors = [np.abs(after(count) - exact).max() for count in (250, 500, 1000)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)
    assert math.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.15)


def test_without_rods_it_is_velocity_verlet():
    body = pc.rope(8, 1.0, stiffness=100.0, damping=0.1, mass=0.1)
    runs = [
        pc.Simulation(pc.Scene(body, pc.Gravity((0.0, -1.0))), kind, dt=1e-3) for kind in (pc.RATTLE(), None) if kind
    ]
    runs.append(pc.Simulation(pc.Scene(body, pc.Gravity((0.0, -1.0))), pc.VelocityVerlet(), dt=1e-3))
    for run in runs:
        run.step(200)
    np.testing.assert_array_equal(state(runs[0]), state(runs[1]))


def tensions(positions: ArrayLike, pairs: ArrayLike, *forces: pc.Force, **more: Any) -> Array:
    body = pc.SpringNetwork(positions, pairs, INF, **more)
    return pc.Simulation(pc.Scene(body, *forces), dt=1e-4)[body].tensions


def test_tensions_bear_weights_and_turn_velocities():
    """A hanging chain carries what is below; a rod that turns μ ω² L; a pendulum m g cos θ + m v²/L."""
    hanging = tensions(
        [[0.0, 0.0], [0.0, -1.0], [0.0, -1.5]], [[0, 1], [1, 2]], pc.Gravity((0.0, -10.0)), mass=2.0, fixed=[0]
    )
    np.testing.assert_allclose(hanging, [40.0, 20.0], rtol=1e-12)
    turning = tensions([[0.0, 0.0], [2.0, 0.0]], [[0, 1]], mass=[1.0, 3.0], velocities=[[0.0, -4.5], [0.0, 1.5]])
    np.testing.assert_allclose(turning, [0.75 * 9.0 * 2.0], rtol=1e-12)
    arm = 2.0 * np.array([math.sin(0.3), -math.cos(0.3)])
    swinging = tensions(
        [[0.0, 0.0], arm], [[0, 1]], pc.Gravity((0.0, -10.0)), fixed=[0], velocities=[[0, 0], [-3 * arm[1], 3 * arm[0]]]
    )
    np.testing.assert_allclose(swinging, [10.0 * math.cos(0.3) + 9.0 * 2.0], rtol=1e-12)


def test_redundant_rods_share_the_load_by_least_norm():
    """A square with both diagonals turns: J M⁻¹ Jᵀ T = |Δv|²/L has many solutions, of which NumPy gives the least."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) - 0.5
    pairs = np.array([[i, j] for i in range(4) for j in range(i)])
    velocity = 3.0 * np.column_stack([-corners[:, 1], corners[:, 0]])
    arm = np.diff(corners[pairs], axis=1)[:, 0]
    length = np.linalg.norm(arm, axis=1)
    jacobian = np.zeros((6, 8))
    for row, (one, other) in enumerate(pairs):
        jacobian[row, 2 * one : 2 * one + 2], jacobian[row, 2 * other : 2 * other + 2] = (
            -arm[row] / length[row],
            arm[row] / length[row],
        )
    turning = (np.diff(velocity[pairs], axis=1)[:, 0] ** 2).sum(axis=1) / length
    least = np.linalg.lstsq(jacobian @ jacobian.T, turning, rcond=1e-9)[0]
    np.testing.assert_allclose(tensions(corners, pairs, velocities=velocity), least, rtol=1e-8)


def test_the_plan_says_how_many_rods_are_redundant_and_what_the_start_lost():
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    pairs = np.array([[i, j] for i in range(4) for j in range(i)])
    run = pc.Simulation(pc.Scene(pc.SpringNetwork(corners, pairs, INF)), dt=1e-3)
    assert any("1 of 6 are redundant" in note for note in run.plan.notes)
    stretched = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], INF, velocities=[[-1.0, 0.0], [1.0, 0.0]])
    run = pc.Simulation(pc.Scene(stretched), dt=1e-3)
    assert any("1.000e0 J of the kinetic energy" in note for note in run.plan.notes)
    assert run.energy().balance == pytest.approx(0.0, abs=1e-15)
    assert "rods" in run.plan.stages


def test_a_moving_end_does_work():
    """The suspension of a pendulum moves: with the work that it does the balance is constant, to order 2."""
    nodes = [[0.0, 0.0], [0.6, -0.8]]
    body = pc.SpringNetwork(nodes, [[0, 1]], INF, fixed=[0], velocities=[[0.7, 0.2], [0.7, 0.2]])
    drifts = []
    for dt in (4e-3, 2e-3, 1e-3):
        run = pc.Simulation(pc.Scene(body, pc.Gravity((0.0, -9.81))), dt=dt)
        start = run.energy().balance
        run.run(2.0)
        assert abs(run.energy().work) > 1.0
        drifts.append(abs(run.energy().balance - start))
    assert drifts[2] < 1e-4
    assert math.log2(drifts[0] / drifts[1]) == pytest.approx(2.0, abs=0.3)


def test_tensions_are_recorded_of_rods_and_springs_alike(tmp_path):
    """The springs of two networks; those of one are asked for by its body."""
    ball = pc.Particles([[5.0, 5.0]])
    chain = pc.SpringNetwork(
        [[0.0, 0.0], [0.0, -1.0], [0.0, -2.5]], [[0, 1], [1, 2]], [INF, 10.0], rest_length=[1.0, 1.0], fixed=[0, 1]
    )
    swing = pc.SpringNetwork([[2.0, 0.0], [2.0, -1.0]], [[0, 1]], INF, mass=3.0, fixed=[0], name="swing")
    scene = pc.Scene(ball, chain, swing, pc.Gravity((0.0, -10.0)))
    recording = pc.simulate(scene, 0.1, fps=50, dt=1e-3)
    assert recording.tensions.shape == (6, 3)
    np.testing.assert_allclose(recording[chain].tensions[0], [0.0, 5.0], atol=1e-12)  # both ends of the rod are held
    np.testing.assert_allclose(recording["swing"].tensions, 30.0, rtol=1e-9)
    recording.save(tmp_path / "swing.npz")
    again = pc.load(tmp_path / "swing.npz")
    np.testing.assert_array_equal(again["swing"].tensions, recording["swing"].tensions)
    assert "tensions" not in recording[ball].channels
    run = pc.Simulation(scene, dt=1e-3)
    assert run[ball].fields.keys() == {"positions", "velocities"}


def test_there_are_no_tensions_where_rods_are_projected():
    """XPBD moves the ends of rods, and has no forces of theirs: what asks for these is told so."""
    chain = pc.SpringNetwork([[0.0, 0.0], [0.0, -1.0], [0.0, -2.0]], [[0, 1], [1, 2]], INF, fixed=[0])
    scene, projected = pc.Scene(chain, pc.Gravity((0.0, -10.0))), {"integrator": pc.XPBD(), "dt": 1e-3}
    recording = pc.simulate(scene, 0.01, **projected)
    run = pc.Simulation(scene, **projected)
    assert recording[chain].channels.keys() == run[chain].fields.keys() == {"positions", "velocities"}
    for asked in (lambda: recording.tensions, lambda: recording[chain].tensions, lambda: run[chain].tensions):
        with pytest.raises(pc.SceneError, match=r"only networks with rods under RATTLE\(\) have them"):
            asked()
    with pytest.raises(pc.SceneError, match="channels: there are no tensions with this integrator: only networks"):
        pc.simulate(scene, 0.01, channels=("positions", "tensions"), **projected)


def test_single_precision_keeps_lengths_to_its_rounding():
    body = still(network(7, 3, fixed=True, elastic=False))
    run = pc.Simulation(pc.Scene(body, pc.Gravity((0.0, 0.0, -9.81))), dt=1e-3, precision="f32")
    run.step(500)
    lengths, along = missed(run, body)
    assert lengths < 1e-12  # positions carry their low-order parts
    assert along < 100 * float(np.finfo(np.float32).eps) * (1.0 + np.abs(run.velocities).max())


def test_dt_auto_counts_rotation_and_tension():
    """A rod that turns by ω takes half a radian in a step at the most; chains with a heavy end
    swing across with √(T/L (1/m + 1/m)).
    """
    turning = pc.SpringNetwork([[-0.5, 0.0], [0.5, 0.0]], [[0, 1]], INF, velocities=[[0.0, -5.0], [0.0, 5.0]])
    plan = pc.Simulation(pc.Scene(turning)).plan
    assert (plan.dt_limit, plan.limit_kind, plan.limit_term) == (pytest.approx(0.05, rel=1e-9), "accuracy", "rods")
    nodes = np.column_stack([np.zeros(11), -0.1 * np.arange(11)])
    chain = pc.SpringNetwork(
        nodes, np.column_stack([np.arange(10), np.arange(1, 11)]), INF, mass=[*[0.01] * 10, 5.0], fixed=[0]
    )
    limit = pc.stability_limit(pc.Scene(chain, pc.Gravity((0.0, -9.81))), pc.RATTLE())
    swings = math.sqrt(5.0 * 9.81 / 0.1 * 2.0 / 0.01)
    assert 1.2 / swings < limit < 2.0 / swings


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: pc.Simulation(double_pendulum(), pc.VelocityVerlet()),
            r"integrator: expected RATTLE\(\) or XPBD\(\) for rods, got VelocityVerlet",
        ),
        (
            lambda: pc.Simulation(pc.Scene(*double_pendulum().bodies, pc.Plane((0.0, -3.0), (0.0, 1.0))), pc.RATTLE(4)),
            r"integrator: expected .*boundaries, got RATTLE .*order=2",
        ),
        (
            lambda: pc.Simulation(pc.Scene(*double_pendulum().bodies, pc.Floor(-3.0, friction=0.2))),
            r"boundaries\[0\]\.friction: expected 0 with rods, got 0\.2",
        ),
        (
            lambda: double_pendulum(rest_length=[1.0, 1.0]),
            r"SpringNetwork\.rest_length\[0\]: a rod of 1 m, whose ends are 0\.98\d* m apart; leave rest_length out",
        ),
        (lambda: pc.SpringNetwork([[0.0, 0.0], [0.0, 0.0]], [[0, 1]], INF), r"rest_length\[0\]: a rod of 0 m"),
        (
            lambda: pc.Simulation(
                pc.Scene(
                    pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], INF, fixed=[0, 1], velocities=[[0, 0], [0, 1]])
                )
            ),
            r"a rod between the fixed particles 0 and 1, whose velocities differ",
        ),
        (
            lambda: pc.Simulation(double_pendulum()).set(positions=[[0, 0], [1, 0], [2, 0]]),
            r"set\.positions: expected ends of rod 0",
        ),
        (lambda: pc.RATTLE(3), r"RATTLE\.order: must be 2 or 4, got 3"),
        (lambda: pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], -INF), r"stiffness.*≥ 0"),
        (lambda: pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], math.nan), r"stiffness.*a number"),
    ],
)
def test_what_cannot_be_held_is_refused(make, message):
    with pytest.raises(pc.SceneError, match=message):
        make()


@pytest.mark.parametrize("kind", [kind for kind in INTEGRATORS if kind.advances("bodies") and not kind.holds_rods])
def test_who_cannot_hold_rods_names_those_who_can(kind):
    with pytest.raises(pc.SceneError, match=rf"integrator: .*RATTLE\(\) or XPBD\(\) for rods, got {kind.__name__}"):
        pc.Simulation(double_pendulum(), kind(), dt=1e-3)


def test_a_step_without_a_solution_diverges_and_says_why():
    """A rod that would turn by 20 radians in a step has no length along its old direction that brings it back."""
    body = pc.SpringNetwork([[-0.5, 0.0], [0.5, 0.0]], [[0, 1]], INF, velocities=[[0.0, -5.0], [0.0, 5.0]])
    with pytest.warns(pc.StabilityWarning):
        run = pc.Simulation(pc.Scene(body), dt=2.0)
    with pytest.raises(
        pc.SimulationDiverged, match=re.compile("step 1 .*does not satisfy its rods: they turn too far")
    ) as caught:
        run.step(3)
    assert caught.value.hint
    assert run.steps == 0
    with pytest.warns(pc.StabilityWarning):
        pc.Simulation(pc.Scene(body), dt=0.4, on_divergence="substep").run(2.0)


def test_sweeps_of_xpbd_approach_rods_as_steps_become_small():
    """Against RATTLE: of order 1 in the step, and rods that are as long as one sweep leaves them, to order 2."""
    chain = pc.SpringNetwork(
        [[0.1 * k, 0.0] for k in range(5)], [[k, k + 1] for k in range(4)], INF, mass=0.1, fixed=[0]
    )
    scene = pc.Scene(chain, pc.Gravity((0.0, -9.81)))
    (exact := pc.Simulation(scene, dt=1e-3)).run(0.3)
    errors, lengths = [], []
    for substeps in (20, 40, 80):
        (run := pc.Simulation(scene, pc.XPBD(substeps, 2), dt=0.01)).run(0.3)
        errors.append(float(np.abs(run.positions - exact.positions).max()))
        lengths.append(missed(run, chain)[0])
    assert math.log2(errors[1] / errors[2]) == pytest.approx(1.0, abs=0.15)
    assert math.log2(lengths[1] / lengths[2]) == pytest.approx(2.0, abs=0.3)
    assert lengths[2] < 1e-4


def test_a_rod_alone_is_held_by_xpbd_to_rounding():
    """The same as a spring of any stiffness, which one sweep satisfies, between fixed ends and in loops too."""
    body = pc.SpringNetwork(
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0, 1], [1, 2]], [INF, INF], mass=[1.0, 1.0, 2.0], fixed=[0, 1]
    )
    run = pc.Simulation(pc.Scene(body, pc.Gravity((0.0, -9.81))), pc.XPBD(10), dt=0.01)
    run.step(100)
    assert missed(run, body)[0] < 10 * EPSILON
    np.testing.assert_array_equal(run.positions[:2], body.positions[:2])
