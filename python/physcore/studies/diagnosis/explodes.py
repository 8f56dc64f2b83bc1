"""Symptom "explodes": the energy balance drifts, or will drift."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from physcore.simulation.effort import ENCOUNTER_CURE, is_encounter
from physcore.simulation.energy import FAIR_DRIFT, WRONG_DRIFT
from physcore.simulation.notes import material_drift
from physcore.simulation.recording import Recording
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding


def explodes(case: Case) -> Iterator[Finding]:
    """Check the energy balance of a recording, or the time step of a simulation against the limit of stability."""
    plan = case.plan
    dt = f"dt = {plan.dt:.3g}{plan.units.suffix('s')}"
    if case.recording is None:
        if plan.limit_kind == "stability" and plan.margin > 1.0:
            cause = f"{dt} is {plan.margin:.3g} times the limit of stability ({plan.limit_term})"
            yield Finding("explodes", cause, f'take dt={0.5 * plan.dt_limit:.2g}, or leave dt to "auto"', plan.margin)
        return
    drift = worst_drift(case.recording)
    if abs(drift) <= WRONG_DRIFT or is_loss(case, drift) or material_drift(case.recording) <= WRONG_DRIFT:
        return
    limit = f"; {dt} is {plan.margin:.0%} of its limit ({plan.limit_term})" if 0.0 < plan.dt_limit < math.inf else ""
    cause = f"the energy balance is off by {abs(drift):.2g} of the energy in motion{limit}"
    yield Finding("explodes", cause, _cure(case, abs(drift)), abs(drift))


def worst_drift(recording: Recording) -> float:
    """The drift of largest magnitude of the energy balance, with its sign."""
    drift = recording.energy.drift
    if not np.isfinite(drift).all():
        return math.inf
    return float(drift[np.argmax(np.abs(drift))])


def is_loss(case: Case, drift: float) -> bool:
    """Whether a drift is the energy loss of a method that is not symplectic, as opposed to divergence."""
    return drift < 0.0 and not case.integrator.symplectic


def _cure(case: Case, drift: float) -> str:
    """A remedy with a time step whose drift is fair, from drift ∝ dt^order."""
    if is_encounter(case.plan.limit_term, case.plan.limit_kind):
        return f"close encounters need smaller steps: {ENCOUNTER_CURE}"
    smaller = case.plan.dt * (FAIR_DRIFT / min(drift, 1.0)) ** (1.0 / max(case.plan.order, 1))
    return f"take a smaller time step, dt={smaller:.2g}"
