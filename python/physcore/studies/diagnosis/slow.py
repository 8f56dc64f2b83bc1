"""Symptom "slow": a run takes more steps or more time than is probably intended."""

from __future__ import annotations

from collections.abc import Iterator

from physcore.simulation.effort import MOST_STEPS, remedy
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding
from physcore.studies.forecast import forecast, words

LONGEST = 600.0
"""Longest duration of a run without a finding [s]: ten minutes, as all demos together."""


def slow(case: Case) -> Iterator[Finding]:
    """Check the number of steps ahead, and their time, estimated from a few steps of a copy."""
    if case.simulation is None or case.duration is None:
        return
    simulation = case.simulation
    ahead = forecast(simulation, case.duration)
    steps = ahead.steps
    if steps is None or (steps <= MOST_STEPS and ahead.seconds <= LONGEST):
        return
    plan = case.plan
    given = simulation._stepper.fixed is not None
    what = "as it was given" if given else f"because of {plan.limit_term}" if plan.limit_term else "the largest"
    second = plan.units.suffix("s")
    run = f"{case.duration:g}{second} are {steps:.1e} steps of {ahead.dt:.2g}{second}"
    cause = f"{run}, {what}, about {words(ahead.seconds)}"
    yield Finding("slow", cause, remedy(plan.limit_term, given), float(steps))
