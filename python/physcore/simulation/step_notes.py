"""Notes of the plan about steps: adaptive ones, limits that vary, and oscillations that steps do not resolve."""

from __future__ import annotations

import math

from physcore.arithmetic import power
from physcore.numerics.choices import AdaptiveStep, Limit, StepRule
from physcore.scene.records import Record
from physcore.simulation.step_size import StepSize

RESOLVED, NOTED = 0.005, 0.01
"""Errors of an oscillation after ten periods over its amplitude: of a resolved one, and of one that a note names."""

DAMPINGS = ("drag", "spring damping")
"""Terms that limit the step by a decay, and not by an oscillation."""

NEAR = 0.5
"""Ratio of a given time step to a limit that varies above which the plan has a note; AutoStep() keeps to half."""


def notes_on(size: StepSize, dt: float, limit: Limit) -> list[str]:
    """Notes on steps of a size; the present one is `dt` [s], and its limit is `limit`."""
    if size.adaptive is None:
        return _momentary(size, dt, limit) + _unresolved(size, dt, limit)
    return _following(size, size.adaptive)


def _following(size: StepSize, rule: AdaptiveStep) -> list[str]:
    """A note on steps that follow the motion."""
    by = (
        f"keep their last coefficient within {rule.tolerance:g} of the largest acceleration"
        if size.numerics.integrator.self_adaptive and rule.tolerance is not None
        else f"keep their error within {rule.tolerance:g} m"
        if rule.tolerance is not None
        else f"keep to {rule.safety:.0%} of the limit at both of their ends, in blocks of halves"
    )
    rejected, _, smallest, largest = size.world.adaptation()
    taken = (
        f"{size.world.steps} taken, from {smallest:.3g} s to {largest:.3g} s, {rejected} tried and taken back"
        if size.world.steps
        else "none taken so far"
    )
    return [f"adaptive steps {by}: {taken}"]


def _momentary(size: StepSize, dt: float, limit: Limit) -> list[str]:
    """A note on a given step near a limit that varies with the motion."""
    flows = bool(size.scene.fluids)
    if isinstance(size.numerics.dt, StepRule) or not size.varies or not (limit.kind == "accuracy" or flows):
        return []
    if not NEAR * limit.dt < dt <= limit.dt:
        return []
    return [
        f"the {limit.kind} limit of {limit.dt:.3g} s ({limit.term}) is that of the present state, and falls where "
        'the motion becomes faster; dt="auto" follows it'
    ]


def _unresolved(size: StepSize, dt: float, limit: Limit) -> list[str]:
    """A note on the fastest oscillation of bodies, if it is off by more than 1 % after ten periods."""
    integrator = size.numerics.integrator
    if not size.scene.bodies:
        return []
    if math.isinf(limit.dt) and any(Record.of(force).code for force in size.scene.forces):
        return [f"nothing limits the time step of {dt:.3g} s: make sure that it resolves the functions of time"]
    if limit.kind != "stability" or limit.stability == 0.0 or integrator.resolving == 1.0 or limit.term in DAMPINGS:
        return []
    ratio = dt / (integrator.resolving * limit.stability)
    slower = ratio * float(power(RESOLVED / NOTED, 1.0 / integrator.order))
    if slower <= 1.0:
        return []
    return [
        f"the fastest oscillations ({limit.term}) are not resolved; motion that is at least {slower:.2g} times "
        "slower is within 1 % of its amplitude after ten periods; dt=pc.AutoStep(resolve=True) resolves all, in "
        f"{ratio:.2g} times as many steps"
    ]
