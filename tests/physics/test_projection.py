"""Extended position-based and projective dynamics: what they converge to, what they keep, and what they refuse."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import EPSILON, Array, state

METHODS = [pc.XPBD(substeps=4, iterations=2), pc.ProjectiveDynamics(iterations=8)]


def spring(**more: Any) -> pc.SpringNetwork:
    return pc.SpringNetwork([[0.0, 0.0], [1.2, 0.0]], [[0, 1]], 800.0, rest_length=1.0, mass=2.0, fixed=[0], **more)


def sheet(
    side: int = 7, stiffness: float = 3000.0, damping: float = 0.0, dimension: int = 3, rest: float = 1.0
) -> pc.SpringNetwork:
    rng = np.random.default_rng(1)
    cloth = pc.cloth(
        (side, side), 0.1, stiffness, damping, mass=0.01, pinned="top corners", axes=((1, 0, 0), (0, 1, 0))
    )
    positions = cloth.positions + rng.uniform(-0.01, 0.01, cloth.positions.shape)
    return pc.SpringNetwork(
        positions[:, :dimension],
        cloth.pairs,
        cloth.stiffness,
        cloth.damping,
        rest * cloth.rest_length,
        cloth.mass,
        cloth.fixed,
        rng.uniform(-0.5, 0.5, (side * side, dimension)) * ~cloth.fixed[:, None],
    )


def euler(body: pc.SpringNetwork, h: float, gravity: Array) -> tuple[Array, Array]:
    """A step of backward Euler by Newton's method with exact derivatives: M (u − h v − h² g) = h² F(x + u, u/h)."""
    free, (one, other) = np.flatnonzero(~body.fixed), body.pairs.T
    count, size = len(body), body.dimension
    x, v = body.positions, body.velocities
    y, u = h * v + h * h * gravity, h * v
    y[body.fixed] = h * v[body.fixed]
    for _ in range(30):
        arm = (x + u)[other] - (x + u)[one]
        length = np.linalg.norm(arm, axis=1)
        n = arm / length[:, None]
        rate = (((u[other] - u[one]) / h) * n).sum(axis=1)
        pull = body.stiffness * (length - body.rest_length) + body.damping * rate
        force, matrix = np.zeros((count, size)), np.zeros((count, size, count, size))
        np.add.at(force, one, pull[:, None] * n)
        np.add.at(force, other, -pull[:, None] * n)
        across = np.eye(size) - n[:, :, None] * n[:, None, :]
        relative = (u[other] - u[one]) / h
        turning = (
            body.damping[:, None, None]
            * n[:, :, None]
            * (across * relative[:, None, :]).sum(axis=2)[:, None, :]
            / length[:, None, None]
        )
        block = (
            (body.stiffness + body.damping / h)[:, None, None] * n[:, :, None] * n[:, None, :]
            + (pull / length)[:, None, None] * across
            + turning
        )
        for (i, j), part in zip(body.pairs, block, strict=True):
            matrix[i, :, i, :] += part
            matrix[j, :, j, :] += part
            matrix[i, :, j, :] -= part
            matrix[j, :, i, :] -= part
        residual = body.mass[:, None] * (u - y) - h * h * force
        hessian = h * h * matrix + np.einsum("i,ij,ab->iajb", body.mass, np.eye(count), np.eye(size))
        k = len(free) * size
        change = np.linalg.solve(hessian[free][:, :, free].reshape(k, k), residual[free].reshape(k))
        u[free] -= change.reshape(-1, size)
        if np.abs(change).max() < 1e-15:
            break
    return x + u, u / h


GRAVITY = np.array([0.0, 0.0, -9.81])


def missed(integrator: pc.Integrator, h: float, damping: float) -> float:
    """The distance of a step from that of backward Euler [m]."""
    body = sheet(5, 300.0, damping, rest=0.8)
    run = pc.Simulation(pc.Scene(body, pc.Gravity(tuple(GRAVITY))), integrator, dt=h)
    run.step()
    x, v = euler(body, h, GRAVITY)
    assert np.abs(run.velocities - v).max() == pytest.approx(np.abs(run.positions - x).max() / h, rel=0.01, abs=1e-9)
    return float(np.abs(run.positions - x).max())


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_projective_dynamics_converges_to_backward_euler(damping):
    """Linearly, and then nothing is left but rounding of coordinates below a meter."""
    errors = [missed(pc.ProjectiveDynamics(iterations), 0.01, damping) for iterations in (20, 40, 2000)]
    assert errors[1] < 0.7 * errors[0]
    assert errors[2] < 10 * EPSILON


def test_few_iterations_keep_the_motion_of_stiff_cloth():
    """A cloth that swings from 30° off the vertical, in steps of sixteen times Verlet's limit, is where backward Euler
    leads it: iterations start from the displacements that keep the velocities. From none it would hang in the air.
    """
    cloth = pc.cloth(
        (12, 10), 0.05, 2e4, 0.5, mass=0.004, axes=((1.0, 0.0, 0.0), (0.0, 0.5, 0.8660254037844386)), pinned="top"
    )
    scene = pc.Scene(cloth, pc.Gravity((0.0, 0.0, -9.81)), pc.Drag(2e-3))

    def end(integrator: pc.Integrator) -> Array:
        run = pc.Simulation(scene, integrator, dt=1.0 / 256)
        run.run(0.5)
        return run.positions

    exact = end(pc.BackwardEuler(1e-8))
    moved = float(np.abs(exact - cloth.positions).max())
    off = [float(np.abs(end(pc.ProjectiveDynamics(count)) - exact).max()) / moved for count in (5, 20, 80)]
    assert np.all(np.less(off, [0.5, 0.1, 0.02])), off


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_sweeps_converge_to_backward_euler_as_steps_become_small(damping):
    """Impulses of earlier sweeps keep the directions that springs had then. These turn by (Δv/l) h, the impulses move
    ends by (F/m) h², and what is left of both is of third order in h.
    """
    errors = [missed(pc.XPBD(1, 300), h, damping) for h in (1e-3, 5e-4, 2.5e-4)]
    assert math.log2(errors[0] / errors[1]) > 2.4
    assert math.log2(errors[1] / errors[2]) > 2.6


@pytest.mark.parametrize("integrator", METHODS, ids=lambda i: type(i).__name__)
@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_damped_driven_network_is_solved_to_order_1(integrator, precision, dimension):
    """Against Runge and Kutta's method; f32 is off by its rounding besides."""

    def after(count: int, kind: pc.Integrator, precision: Any) -> Array:
        body = sheet(5, 10.0, 0.002, dimension)
        scene = pc.Scene(body, pc.Gravity(-9.81 * np.eye(dimension)[-1]), pc.Drag(0.01))
        run = pc.Simulation(scene, kind, dt=0.2 / count, precision=precision)
        run.step(count)
        return run.positions

    exact = after(2000, pc.RungeKutta4(), "f64")
    errors = [np.abs(after(count, integrator, precision) - exact).max() for count in (200, 400)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.25)
    assert pc.Simulation(pc.Scene(sheet()), integrator, dt=0.01).plan.order == 1


@pytest.mark.parametrize("integrator", METHODS, ids=lambda i: type(i).__name__)
def test_momentum_is_kept(integrator):
    """Impulses of springs are equal and opposite; those of the factorized matrix in sum, to its rounding."""
    body = sheet(6, damping=0.1)
    free = pc.SpringNetwork(body.positions, body.pairs, body.stiffness, body.damping, velocities=body.velocities)
    recording = pc.simulate(pc.Scene(free), 1.0, fps=10, dt=0.01, integrator=integrator)
    scale = float(free.mass @ np.linalg.norm(free.velocities, axis=1))
    assert np.abs(recording.momentum - recording.momentum[0]).max() < 1e5 * EPSILON * scale


@pytest.mark.parametrize("integrator", METHODS, ids=lambda i: type(i).__name__)
def test_drag_and_damping_are_metered_and_the_rest_is_drift(integrator):
    """The dissipation converges to that of the motion; what the method damps beside is in the balance, and vanishes."""
    body = sheet(5, 10.0, 0.002)
    scene = pc.Scene(body, pc.Gravity((0.0, 0.0, -9.81)), pc.Drag(0.01))
    exact = pc.Simulation(scene, pc.RungeKutta4(), dt=1e-4)
    exact.run(0.3)
    errors, drifts = [], []
    for dt in (2e-3, 1e-3):
        run = pc.Simulation(scene, integrator, dt=dt)
        start = run.energy().balance
        run.run(0.3)
        errors.append(abs(run.energy().dissipated - exact.energy().dissipated))
        drifts.append(run.energy().balance - start)
    assert errors[1] < 0.15 * exact.energy().dissipated
    assert errors[1] < 0.7 * errors[0]
    assert drifts[0] < drifts[1] < 0.0


@pytest.mark.parametrize("integrator", METHODS, ids=lambda i: type(i).__name__)
def test_a_cloth_rests_on_a_ball_and_stays_outside(integrator):
    cloth = pc.cloth((12, 12), 0.05, 5000.0, mass=0.005, axes=((1, 0, 0), (0, 1, 0)), origin=(-0.275, -0.275, 0.26))
    ball = pc.Sphere((0.0, 0.0, 0.0), 0.2, inside=False, restitution=0.0, friction=0.5)
    recording = pc.simulate(
        pc.Scene(cloth, pc.Gravity((0.0, 0.0, -9.81)), ball), 1.0, fps=50, dt=0.01, integrator=integrator
    )
    assert np.linalg.norm(recording.positions, axis=2).min() > 0.2 - 1e-9
    assert recording.energy.dissipated_by["contacts"][-1] > 0.0


@pytest.mark.parametrize("integrator", METHODS, ids=lambda i: type(i).__name__)
def test_held_particles_that_move_keep_their_velocities(integrator):
    body = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 50.0, fixed=[0], velocities=[[0.3, 0.1], [0.0, 0.0]])
    run = pc.Simulation(pc.Scene(body), integrator, dt=0.01)
    run.step(100)
    np.testing.assert_array_equal(run.velocities[0], [0.3, 0.1])
    np.testing.assert_allclose(run.positions[0], [0.3, 0.1], rtol=1e-14)


def test_springs_without_length_stiffness_or_separation_are_no_trouble():
    """A spring of rest length 0 whose ends meet, one of stiffness 0, and one given twice."""
    body = pc.SpringNetwork(
        [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]],
        [[0, 1], [1, 2], [2, 1], [0, 2]],
        [100.0, 5.0, 5.0, 0.0],
        [0, 0, 0, 0.1],
        rest_length=[0.0, 1.0, 1.0, 0.5],
    )
    for integrator in METHODS:
        run = pc.Simulation(pc.Scene(body), integrator, dt=0.05)
        run.step(50)
        assert np.isfinite(state(run)).all()


def test_limits_are_those_of_other_forces():
    """Drag is explicit: m/c is its time constant, which a part of a step must not exceed twice."""
    assert math.isinf(pc.stability_limit(pc.Scene(sheet()), pc.XPBD()))
    assert math.isinf(pc.stability_limit(pc.Scene(sheet()), pc.ProjectiveDynamics()))
    one = pc.stability_limit(pc.Scene(sheet(), pc.Drag(0.1)), pc.ProjectiveDynamics())
    assert pc.stability_limit(pc.Scene(sheet(), pc.Drag(0.1)), pc.XPBD(5)) == pytest.approx(5 * one)
    assert 0.0 < one <= 2 * 0.01 / 0.1


@pytest.mark.parametrize("integrator", METHODS, ids=lambda i: type(i).__name__)
@pytest.mark.parametrize(
    "item",
    [
        pc.LennardJones(epsilon=1.0, sigma=0.1, cutoff=0.25),
        pc.CustomForce(lambda time, positions, velocities: -positions),
        pc.Gravitation(1.0, softening=0.1),
    ],
    ids=lambda item: type(item).__name__,
)
def test_forces_without_a_projection_are_refused_by_name(integrator, item):
    with pytest.raises(
        pc.SceneError, match=f"integrator: expected .* for a {type(item).__name__}, got {type(integrator).__name__}"
    ):
        pc.Simulation(pc.Scene(spring(), item), integrator)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pc.XPBD(0), r"XPBD\.substeps: must be ≥ 1"),
        (lambda: pc.XPBD(2, 0), r"XPBD\.iterations: must be ≥ 1"),
        (lambda: pc.ProjectiveDynamics(0), r"ProjectiveDynamics\.iterations: must be ≥ 1"),
        (
            lambda: pc.Simulation(
                pc.Scene(pc.SpringNetwork([[0, 0], [1, 0]], [[0, 1]], math.inf)), pc.ProjectiveDynamics()
            ),
            r"for rods, got ProjectiveDynamics",
        ),
        (
            lambda: pc.Simulation(
                pc.Scene(pc.Fluid(pc.block((0, 0), (0.5, 0.5), 0.1), 0.1)),
                pc.XPBD(),
                dt=1e-3,
                fluids=pc.WeaklyCompressible(sound_speed=10.0),
            ),
            r"for a Fluid, got XPBD",
        ),
    ],
)
def test_what_is_out_of_range_is_refused(make, message):
    with pytest.raises(pc.SceneError, match=message):
        make()
