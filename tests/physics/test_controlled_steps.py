"""Steps that follow the estimate of their error: it follows the tolerance, and what is rejected leaves no trace."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.integrators import INTEGRATORS, Integrator
from physics.laboratory import Array, name

PAIRS = [kind() for kind in INTEGRATORS if kind.embedded and kind.advances("Wave")]
each_pair = pytest.mark.parametrize("pair", PAIRS, ids=name)


def pendulum() -> pc.Scene:
    """A swing on a spring through air, which comes to rest."""
    swing = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 50.0, damping=0.5, fixed=[0])
    return pc.Scene(swing, pc.Gravity((0.0, -9.81)), pc.Drag(linear=0.2, quadratic=0.1))


def comet() -> pc.Scene:
    """A fall past a center, through air."""
    body = pc.Particles([[1.9, 0.0]], [[0.0, 0.25]])
    return pc.Scene(body, pc.CentralForce((0.0, 0.0), 1.0), pc.Drag(linear=0.05))


def folded() -> pc.Scene:
    well = pc.CentralForce((0.1, 0.0), 4.0, exponent=1.0)
    return pc.Scene(pc.Particles([[1.0, 0.0], [0.0, 1.3]], [[0.1, 0.9], [-0.8, 0.2]]), well, pc.Drag(0.4))


SCENES = {"pendulum": pendulum, "comet": comet, "folded": folded}


def state(run: pc.Simulation) -> Array:
    return np.stack([run.positions, run.velocities])


def controlled(scene: str, pair: Integrator, tolerance: float, **numerics) -> pc.Simulation:
    return pc.Simulation(SCENES[scene](), pair, pc.AdaptiveStep(tolerance=tolerance), **numerics)


@each_pair
@pytest.mark.parametrize("scene", SCENES)
def test_the_error_is_proportional_to_the_tolerance(scene, pair, record_property):
    """The estimate of a pair of order k shrinks like hᵏ, so the tolerance sets hᵏ. The result is of order k: its error,
    after a given time, shrinks like hᵏ as well. Over four decades a line through the logarithms has the slope 1; single
    points scatter, since the steps end where the interval ends and errors of either sign may cancel: 0.1 is 0.4 of four
    decades.
    """
    exact = pc.Simulation(SCENES[scene](), pc.RungeKutta4(), dt=2e-5, threads=1)
    exact.run(3.0)
    tolerances = 10.0 ** -np.arange(4.0, 8.5, 0.5)
    errors = []
    for tolerance in tolerances:
        run = controlled(scene, pair, tolerance, threads=1)
        run.run(3.0)
        errors.append(np.abs(run.positions - exact.positions).max())
    slope = np.polyfit(np.log(tolerances), np.log(errors), 1)[0]
    record_property("slope", f"{slope:.3f}")
    record_property("error over tolerance", f"{np.exp(np.log(np.array(errors) / tolerances).mean()):.2g}")
    assert slope == pytest.approx(1.0, abs=0.1)


def driven() -> pc.Scene:
    """A stiffening spring that a force in time drives, through air."""

    def push(time: float, positions: Array, velocities: Array) -> Array:
        return np.stack([np.cos(3.0 * time) + 0.0 * positions[:, 0], -(positions[:, 1] ** 3)], axis=1)

    well = pc.CentralForce((0.0, 0.0), 4.0, exponent=1.0)
    return pc.Scene(pc.Particles([[1.0, 0.5]]), well, pc.Drag(linear=0.3, quadratic=0.2), pc.CustomForce(push))


def spent(run: pc.Simulation) -> int:
    """Evaluations of the forces, with those of the steps that were taken back."""
    rejected = int(run.plan.notes[-1].rsplit(", ", 1)[1].split()[0])
    return (run.steps + rejected) * run.plan.evaluations


@pytest.mark.parametrize("scene", [pendulum, comet, driven], ids=lambda scene: scene.__name__)
def test_each_digit_costs_the_pair_of_order_five_less(scene, record_property):
    """They grow like 10^(1/k) per digit, 2.15 times at order 3 and 1.58 times at order 5, up to the scatter of single
    errors, whose signs may cancel.
    """
    exact = pc.Simulation(scene(), pc.DormandPrince5(), dt=5e-4, threads=1)
    exact.run(6.0)
    at_six, factors = {}, {}
    for pair in PAIRS:
        found = []
        for tolerance in 10.0 ** -np.arange(2.0, 11.0):
            run = pc.Simulation(scene(), pair, pc.AdaptiveStep(tolerance=tolerance), threads=1)
            run.run(6.0)
            found.append((np.abs(run.positions - exact.positions).max(), spent(run)))
        errors, evaluations = np.array(found).T
        fitted = (errors < 1e-3) & (errors > 1e-9)
        line = np.polyfit(-np.log10(errors[fitted]), np.log10(evaluations[fitted]), 1)
        factors[pair.order] = 10.0 ** line[0]
        at_six[pair.order] = 10.0 ** np.polyval(line, 6.0)
        record_property(f"{name(pair)}: times per digit", f"{factors[pair.order]:.3f}")
        record_property(f"{name(pair)}: evaluations for 1e-6", f"{at_six[pair.order]:.0f}")
    assert factors[5] < factors[3]
    assert at_six[5] < at_six[3] / 3.0


@each_pair
def test_the_steps_are_small_where_the_motion_is_fast(pair):
    recording = pc.simulate(comet(), duration=3.0, fps=1.0, integrator=pair, dt=pc.AdaptiveStep(tolerance=1e-8))
    (note,) = (note for note in recording.plan.notes if note.startswith("adaptive steps"))
    assert "keep their error within 1e-08 m" in note
    smallest, largest = (float(word) for word in note.split(" from ")[1].replace(",", "").split()[0:4:3])
    assert 5.0 * smallest < largest


@each_pair
@pytest.mark.parametrize("scene", SCENES)
def test_a_rejected_step_leaves_no_trace(scene, pair):
    """An interval that is too long for one step is tried and rejected; what follows are steps like any others."""
    free = controlled(scene, pair, 1e3, threads=1)
    free.run(1.0 / 120.0)
    assert free.steps == 1  # at such a tolerance every step is good enough
    tolerance, interval = {3: (1e-10, 1e-2), 5: (1e-13, 0.2)}[pair.order]
    run = controlled(scene, pair, tolerance, threads=1)
    run.run(interval)
    assert "0 tried and taken back" not in run.plan.notes[-1]
    exact = pc.Simulation(SCENES[scene](), pc.RungeKutta4(), dt=1e-5, threads=1)
    exact.run(interval)
    # Each step errs by less than the tolerance.
    assert np.abs(run.positions - exact.positions).max() < run.steps * tolerance
    budget = abs(run.energy().balance - exact.energy().balance)
    assert budget < 1e-6 * abs(exact.energy().kinetic + 1.0)


@each_pair
def test_the_budget_closes(pair):
    """What drag takes is integrated with the same stages: to the accuracy of the steps."""
    recording = pc.simulate(pendulum(), duration=3.0, fps=20.0, integrator=pair, dt=pc.AdaptiveStep(tolerance=1e-9))
    assert np.abs(recording.energy.drift).max() < 1e-5
    assert recording.energy.dissipated[-1] > 0.1


@each_pair
def test_a_pair_runs_with_steps_of_a_given_length_too(pair):
    run = pc.Simulation(pendulum(), pair, dt=1e-3)
    run.step(100)
    assert (run.steps, run.dt) == (100, 1e-3)
    run = pc.Simulation(pendulum(), pair, dt=pc.AdaptiveStep())
    run.run(0.1)
    assert run.time == pytest.approx(0.1, rel=1e-14)
