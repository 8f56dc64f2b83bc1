"""Chaos against its converged solution, after the criterion of Brutus: what `tradeoff` reports of it is true.

T. Boekholt, S. Portegies Zwart, Comput. Astrophys. Cosmol. 2, 2 (2015).
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import physcore as pc
from physcore.studies.state import nudge
from physcore.studies.tradeoff.chaos import FAR, LOST, NUDGE, Chaos, judge
from physcore.studies.tradeoff.restarts import Windows
from physics.laboratory import EPSILON, Array
from validation.converged import Springs, trajectory

pytestmark = [pytest.mark.validation, pytest.mark.usefixtures("clock_of_work")]

GRAVITY = pc.Gravity((0.0, -9.81))
PENDULUM = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0, 1], [1, 2]], 64.0, fixed=[0])
"""Two masses of 1 kg on springs of 1 m, let go from beside and above the pivot."""
SCENE = pc.Scene(PENDULUM, GRAVITY)
DURATION = 18.0
TIMES = np.linspace(0.0, DURATION, 33)
STEPS = 96
"""Of a run that is as exact as double precision allows, in each of the 32 intervals."""
DIGITS = 22
OTHERWISE = 4.0
"""By how much the growth along one trajectory may differ from that along another, of the same chaos, which `tradeoff`
follows where its steps have left this one: the swings of the growth here are a factor of two to four."""


def solved(positions: Array, velocities: Array, times: Array, digits: int = DIGITS) -> Array:
    return trajectory(Springs.of(PENDULUM, GRAVITY), positions, velocities, times, digits)


@cache
def truth() -> Array:
    """Positions and velocities at the times that `tradeoff` looks at, shape (33, 2, 3, 2)."""
    return solved(PENDULUM.positions, PENDULUM.velocities, TIMES)


@cache
def measured() -> pc.Tradeoff:
    methods = [pc.VelocityVerlet(), pc.RungeKutta4(), pc.BlanesMoan6()]
    return pc.tradeoff(SCENE, DURATION, integrators=methods, precisions=["f64"], budget=6.0, progress=False)


def start(size: float) -> pc.Simulation:
    """A run that is as exact as double precision, with the nudge of `tradeoff`'s twin at another size [m/s]."""
    run = pc.Simulation(SCENE, pc.BlanesMoan6(), dt=DURATION / 32 / STEPS, threads=1)
    nudge(run, [size], measured().seed)
    return run


def states(run: pc.Simulation) -> Array:
    """At the same times as the truth."""
    found = [np.stack([run.positions, run.velocities])]
    for _ in TIMES[1:]:
        run.step(STEPS)
        found.append(np.stack([run.positions, run.velocities]))
    return np.array(found)


def apart(one: Array, other: Array) -> Array:
    """The distance in phase space, in units of the motion's largest way and speed, as `tradeoff` takes it."""
    units = np.array([np.abs(truth()[:, 0] - truth()[0, 0]).max(), speed()])
    return np.sqrt((((one - other) / units[:, None, None]) ** 2).mean(axis=(2, 3)).sum(axis=1))


def speed() -> float:
    """The largest of the motion [m/s]."""
    return float(np.abs(truth()[:, 1]).max())


@cache
def twin() -> Chaos:
    """What a twin that starts where `tradeoff`'s does finds in converged solutions."""
    other = solved(PENDULUM.positions, start(NUDGE * speed()).velocities, TIMES)
    distances = apart(other, truth())
    growth = np.maximum.accumulate(distances / distances[0])
    return judge(TIMES, growth, FAR / distances[0])


def test_two_tolerances_and_two_word_lengths_agree_to_twelve_digits_at_the_end():
    """Brutus's criterion. Ten digits less do not meet it: what they leave out grows by seven orders of magnitude."""
    for digits, agree in ((DIGITS - 2, True), (DIGITS - 10, False)):
        other = solved(PENDULUM.positions, PENDULUM.velocities, TIMES, digits)
        assert (np.abs(other - truth()).max() < 1e-12) == agree


def test_the_growth_that_is_reported_is_that_of_the_converged_solution(record_property):
    """Up to half of the horizon the growth itself, but for the percent or two by which the large steps of `tradeoff`'s
    twin are off the motion there; and the exponent and the horizon up to what another trajectory may grow otherwise.
    """
    (reported,), found = measured().chaos, twin()
    record_property("exponent", f"{reported.exponent:.3f}/s, converged {found.exponent:.3f}/s")
    record_property("horizon", f"{reported.horizon:.4g} s, converged {found.horizon:.4g} s")
    assert reported.chaotic
    assert found.chaotic
    early = slice(0, int(0.5 * found.horizon / TIMES[1]))
    np.testing.assert_allclose(reported.growth[early], found.growth[early], rtol=0.05)
    otherwise = np.log(OTHERWISE)
    # A line is fitted to the last three quarters of the growth.
    assert reported.exponent == pytest.approx(found.exponent, abs=otherwise / (0.75 * found.horizon))
    interval = TIMES[1]
    assert reported.horizon == pytest.approx(found.horizon, abs=otherwise / found.exponent + interval)


def test_a_run_stays_with_the_converged_solution_until_the_horizon_and_leaves_it_after():
    """An error of 1e-6 of the motion grows like the twin while it is small, to 1e5 times itself at the horizon, and
    becomes as large as the motion. Without it there is rounding, by ε in each step with random signs, which grows too.
    """
    (reported,) = measured().chaos
    error = apart(states(start(1e-6 * speed())), truth())
    small = error < FAR
    np.testing.assert_allclose(
        (np.maximum.accumulate(error) / error[0])[small], twin().growth[small], rtol=FAR * OTHERWISE
    )
    after = int(reported.horizon / TIMES[1]) + 1
    assert error[:after].max() < OTHERWISE * LOST * error[0] < 0.2
    assert error[after:].max() > 0.5
    rounding = 5.0 * np.sqrt(32 * STEPS) * EPSILON
    assert (apart(states(start(0.0)), truth()) <= rounding * twin().growth).all()


def test_the_errors_after_restarts_are_those_against_the_converged_solution():
    """From the very starts that the reference had, each window solved anew: the reference is as near as it says, and
    so is the error of each row.
    """
    trade = measured()
    (windows,), (experiment,) = trade.references, trade.experiments
    assert isinstance(windows, Windows)
    span = np.array([0.0, experiment.interval / windows.parts])
    starts = [fields[None] for fields in windows.starts]
    ends = np.array([solved(begin["positions"], begin["velocities"], span, digits=18)[-1, 0] for begin in starts])
    assert experiment.distances(windows.ends, ends).max() <= windows.uncertainty
    judged = [row for row in trade.rows if row.status != "diverged"]
    assert len(judged) > 6
    for row in judged:
        run = pc.Simulation(SCENE, **row.numerics)
        found = []
        for begin in starts:
            run.set(**begin)
            run.step(round(span[1] / row.dt))
            found.append(run.positions)
        error = float(experiment.distances(np.array(found), ends).max())
        assert row.error == pytest.approx(error, rel=1e-12, abs=row.error_uncertainty)
