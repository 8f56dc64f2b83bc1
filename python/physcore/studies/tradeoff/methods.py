"""The methods that can compute a scene, with the order that holds there and the largest step worth trying."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeVar

from physcore.errors import SceneError, SimulationDiverged
from physcore.numerics.choices import suited
from physcore.numerics.integrators import Integrator
from physcore.studies.stability import stability_limit
from physcore.studies.tradeoff.experiment import Choice, Experiment, Precision

SAFETY = 0.95
"""The largest step that is tried, as a fraction of its limit."""
SHORT = 1 << 40
"""Steps per interval so many that nobody asks whether they are stable: a plan alone is asked for."""
BEYOND = 16.0
"""How far beyond a limit of accuracy steps are worth trying."""
HOPELESS = 1e-2
"""A limit below this fraction of the best one is none that anybody would keep: explicit Euler's in a damped net."""
DEEPEST = 24
"""Halvings of the time step after which a method is given up."""

Result = TypeVar("Result")


@dataclass(frozen=True)
class Method:
    """An integrator in a scene."""

    integrator: Integrator
    order: int
    """The order p that holds there."""
    limit: float
    """The largest step worth trying [s]: inf where nothing limits it, 0 where none is stable. A limit of accuracy alone
    is no reason not to: some methods are accurate where others are lost."""
    accurate: float
    """Its largest step by the plan [s]."""
    evaluations: int
    """Evaluations of the forces per step."""


def methods(
    experiment: Experiment, integrators: Iterable[Integrator] | None = None, precision: Precision = "f64"
) -> list[Method]:
    """The integrators, by default all, that can compute the scene, the most accurate first.

    Raises:
        SceneError: there is none; the reason of the last one.
    """
    found, refusal = [], SceneError("integrator: there is none")
    for integrator in (kind() for kind in suited(experiment.scene)) if integrators is None else integrators:
        try:
            plan = experiment.start(Choice(integrator, precision, SHORT)).plan
        except SceneError as error:
            refusal = error
            continue
        limit = plan.dt_limit
        if plan.limit_kind == "accuracy":
            limit = min(stability_limit(experiment.scene, integrator, fluids=experiment.fluids), BEYOND * limit)
        found.append(Method(integrator, plan.order, limit, plan.dt_limit, plan.evaluations))
    if not found:
        raise refusal
    reach = {method: min(method.limit, experiment.interval) / method.evaluations for method in found}
    return sorted(found, key=lambda method: (method.order, reach[method]), reverse=True)


def other_family(method: Method, candidates: list[Method]) -> list[Method]:
    """The methods that share no idea with one: splittings beside Runge–Kutta methods; the most accurate first."""
    return [other for other in candidates if other.integrator.symplectic != method.integrator.symplectic]


def largest_step(method: Method, candidates: list[Method]) -> float:
    """The limit of a method [s]; where no step worth taking is stable, that of the others: it shows how it fails."""
    best = max((other.limit for other in candidates if 0.0 < other.limit < math.inf), default=math.inf)
    hopeless = method.limit == 0.0 or method.limit < HOPELESS * best < math.inf
    return best if hopeless else method.limit


def halved(run: Callable[[Choice], Result], choice: Choice) -> tuple[Choice, Result]:
    """What a run gives with the first step, halved after each divergence, that comes to an end; and that choice.

    Raises:
        SimulationDiverged: it does so at every step, down to 2⁻²⁴ of the first.
    """
    for _ in range(DEEPEST):
        try:
            return choice, run(choice)
        except SimulationDiverged:
            choice = choice.finer()
    return choice, run(choice)
