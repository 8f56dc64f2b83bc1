"""Slow: a run that takes more steps, or more time, than anyone means to wait for."""

from __future__ import annotations

import copy
import math
import time
import warnings
from collections.abc import Iterator

from physcore.errors import SimulationDiverged
from physcore.simulation.effort import MOST_STEPS, remedy
from physcore.simulation.simulation import Simulation
from physcore.simulation.stepper import unwarned
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding

LONGEST = 600.0
"""The longest time that a run may take without a word [s]: ten minutes, that of all demos together."""
TRIAL = 0.05
"""How long the steps are timed [s]: some thousand calls of the clock."""


def slow(case: Case) -> Iterator[Finding]:
    """The number of steps that are ahead; their time is estimated from a few that a copy takes."""
    if case.simulation is None or case.duration is None:
        return
    simulation = case.simulation
    steps = math.ceil(case.duration / simulation.dt)
    seconds = steps * _seconds_per_step(simulation)
    if steps <= MOST_STEPS and seconds <= LONGEST:
        return
    plan = case.plan
    given = plan.dt < 0.25 * plan.dt_limit
    what = "as it was given" if given else f"because of {plan.limit_term}" if plan.limit_term else "the largest"
    cause = f"{case.duration:g} s are {steps:.1e} steps of {simulation.dt:.2g} s, {what}, about {_words(seconds)}"
    yield Finding("slow", cause, remedy(plan.limit_term, given), float(steps))


def _seconds_per_step(simulation: Simulation) -> float:
    """The time of a step [s], of a copy that takes more and more of them; 0 where it blows up."""
    trial, steps, taken = copy.copy(simulation), 1, 0.0
    with unwarned(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            trial.run(trial.dt)  # The first step builds lists of neighbors.
            while taken < TRIAL:
                begun, before = time.perf_counter(), trial.steps
                trial.run(steps * trial.dt)
                taken, steps = time.perf_counter() - begun, 2 * steps
        except SimulationDiverged:
            return 0.0
    return taken / max(trial.steps - before, 1)


def _words(seconds: float) -> str:
    """A time as people write it."""
    for unit, length in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds:.0f} s"
