"""Functions of the user's: whenever they are called, whatever they give back, and however they fail."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc


@pytest.mark.parametrize(
    "integrator", [pc.VelocityVerlet(), pc.RungeKutta4(), pc.PEFRL()], ids=lambda i: type(i).__name__
)
def test_a_force_of_time_gives_the_same_bits_however_the_steps_are_asked_for(integrator):
    """The time of a stage is start + (n + node)·dt with one n, not a sum over pieces."""
    ball = pc.Particles([[1.0, 0.0]])
    hashes = set()
    for pieces in ([200], [1] * 200, [7] * 28 + [4]):
        force = pc.CustomForce(lambda time, x, v: np.sin(37.0 * time) - x)
        run = pc.Simulation(pc.Scene(ball, force), integrator=integrator, dt=0.1)
        for piece in pieces:
            run.step(piece)
        hashes.add(run.state_hash())
    assert len(hashes) == 1


@pytest.mark.parametrize("give", [lambda x: (-x).tolist(), lambda x: (-x).astype(np.float32), lambda x: -x])
def test_whatever_numpy_takes_for_an_array_will_do(give):
    run = pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(lambda time, x, v: give(x))), dt=0.5)
    run.step(1)
    assert run.positions[0, 0] == 1.0 - 0.5**2 / 2


def test_a_force_of_the_wrong_shape_is_refused_with_both_shapes():
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(lambda time, x, v: np.zeros((1, 3))))
    with pytest.raises(pc.SceneError, match=r"^forces\[0\]\.function: must give forces of shape \(1, 2\), .*\[1, 3\]$"):
        pc.Simulation(scene, dt=0.1)


def test_a_failing_function_leaves_the_state_before_set():
    """The new state is never seen: neither positions nor energy nor what the integrator carries."""

    def force(time, x, v):
        if abs(x).max() > 10.0:
            raise RuntimeError("too far")
        return -x

    run = pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(force)), dt=0.1)
    run.step(3)
    before = run.state_hash(), run.energy().work
    with pytest.raises(pc.SceneError, match="too far"):
        run.set(positions=[[50.0, 0.0]])
    assert (run.state_hash(), run.energy().work) == before
    run.step(1)


def test_what_holds_a_driven_particle_against_a_potential_does_work():
    """U = d²/2 between a driven and a free particle: total − work is constant to the order of Verlet."""

    def spring(time, x, v):
        pull = x[1] - x[0]
        return np.array([pull, -pull])

    pair = pc.Particles([[0.0, 0.0], [1.0, 0.0]], velocities=[[1.0, 0.0], [0.0, 0.0]], fixed=[0])
    scene = pc.Scene(pair, pc.CustomForce(spring, potential=lambda x: 0.5 * float(((x[1] - x[0]) ** 2).sum())))
    drifts = []
    for dt in (2e-2, 1e-2):
        run = pc.Simulation(scene, dt=dt)
        balance = run.energy().balance
        run.step(round(4.0 / dt))
        assert abs(run.energy().work) > 0.1
        drifts.append(abs(run.energy().balance - balance))
    assert np.log2(drifts[0] / drifts[1]) == pytest.approx(2.0, abs=0.1)


def test_double_precision_takes_springs_of_any_length():
    """f32 is refused: it is relative to the middle of the scene, and 1 m from there positions are 1e-7 m apart."""
    pair = pc.SpringNetwork([[1.0, 0.0], [1.0 + 1e-9, 0.0]], pairs=[[0, 1]], stiffness=1.0)
    scene = pc.Scene(pair, pc.Particles([[-1.0, 0.0]]))
    pc.Simulation(scene, precision="f64").step(1)
    with pytest.raises(pc.SceneError, match="precision"):
        pc.Simulation(scene, precision="f32")


def test_a_state_out_of_range_is_never_taken_for_good():
    """With the alarm for runaways off, the first value that is not finite still ends the run."""
    away = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), -1.0, exponent=3.0))
    run = pc.Simulation(away, integrator=pc.RungeKutta4(), dt=0.1, on_divergence="ignore")

    def one_by_one():
        for _ in range(1000):
            run.step(1)

    with pytest.raises(pc.SimulationDiverged, match="not finite"):
        one_by_one()
    assert np.isfinite(run.positions).all()
    assert np.isfinite(run.velocities).all()
