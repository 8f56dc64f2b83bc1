"""Methods that support a scene, with their order there and the largest step to try."""

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
"""Largest step to try, as a fraction of the limit."""
SHORT = 1 << 40
"""Number of steps per interval for a plan only, so large that stability is not checked."""
BEYOND = 16.0
"""Factor beyond a limit of accuracy up to which steps are tried."""
HOPELESS = 1e-2
"""Ratio to the best limit below which a limit is not used, such as that of explicit Euler in a damped network."""
DEEPEST = 24
"""Number of halvings of the time step after which a method is abandoned."""

Result = TypeVar("Result")


@dataclass(frozen=True)
class Method:
    """Integrator in a given scene."""

    integrator: Integrator
    order: int
    """Order p in the scene."""
    limit: float
    """Largest step to try [s]: inf without a limit, 0 if no step is stable. A limit of accuracy alone is not binding,
    because some methods are accurate where others fail.
    """
    accurate: float
    """Largest step according to the plan [s]."""
    evaluations: int
    """Number of force evaluations per step."""


def methods(
    experiment: Experiment, integrators: Iterable[Integrator] | None = None, precision: Precision = "f64"
) -> list[Method]:
    """The integrators (by default all) that support the scene, the most accurate first.

    Raises:
        SceneError: there is none; the message is that of the last one.
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
            stable = stability_limit(
                experiment.scene, integrator, fluids=experiment.fluids, contacts=experiment.contacts
            )
            limit = min(stable, BEYOND * limit)
        found.append(Method(integrator, plan.order, limit, plan.dt_limit, plan.evaluations))
    if not found:
        raise refusal
    reach = {method: min(method.limit, experiment.interval) / method.evaluations for method in found}
    return sorted(found, key=lambda method: (method.order, reach[method]), reverse=True)


def other_family(method: Method, candidates: list[Method]) -> list[Method]:
    """The methods of the other family, symplectic or not, the most accurate first."""
    return [other for other in candidates if other.integrator.symplectic != method.integrator.symplectic]


def largest_step(method: Method, candidates: list[Method]) -> float:
    """The limit of a method [s]. If this is too small, the best limit of the others, to show that the method fails
    there.
    """
    best = max((other.limit for other in candidates if 0.0 < other.limit < math.inf), default=math.inf)
    hopeless = method.limit == 0.0 or method.limit < HOPELESS * best < math.inf
    return best if hopeless else method.limit


def halved(run: Callable[[Choice], Result], choice: Choice) -> tuple[Choice, Result]:
    """Run a choice, halving its step after each divergence. Returns the first choice that succeeds, and its result.

    Raises:
        SimulationDiverged: the run diverges at all steps down to 2⁻²⁴ of the first.
    """
    for _ in range(DEEPEST):
        try:
            return choice, run(choice)
        except SimulationDiverged:
            choice = choice.finer()
    return choice, run(choice)
