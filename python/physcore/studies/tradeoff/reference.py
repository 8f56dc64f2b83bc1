"""Reference solution: the best method with decreasing steps, extrapolated, and checked by another family."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from physcore.checks import FloatArray
from physcore.studies.tradeoff.budget import Budget
from physcore.studies.tradeoff.convergence import convergence
from physcore.studies.tradeoff.experiment import SAMPLES, Choice, Experiment, Trial
from physcore.studies.tradeoff.methods import DEEPEST, Method, halved, largest_step, other_family

START = 0.5
"""Largest first step, as a fraction of the limit."""
LEVELS = 3
"""Number of runs of an extrapolation: at dt, dt/2 and dt/4."""
AGREEMENT = 3.0
"""Largest distance of two methods, relative to the sum of their uncertainties, at which they agree."""


@dataclass(frozen=True, eq=False)
class Reference:
    """Reference solution, with its uncertainty."""

    samples: FloatArray
    """Values at the start and the end of each interval, shape (33, …)."""
    uncertainty: float
    """Bound on the distance from the exact solution [m], or in the unit of the observed values."""
    choice: Choice
    """The finest run."""
    order: float
    """Order observed in the last three runs; NaN if their differences do not decrease."""
    extrapolated: bool
    """Whether this is the order of the method, so that Richardson's extrapolation is valid."""
    check: Choice | None
    """The finest run of the method used as a check; None if no other family supports the scene."""
    disagreement: float
    """Distance of the two methods [m]; 0 without a check."""
    agrees: bool
    """Whether this distance is within the uncertainties."""


def find(experiment: Experiment, candidates: list[Method], budget: Budget, until: int = SAMPLES + 1) -> Reference:
    """Compute the best reference within a budget from the most accurate methods, for the first `until` samples.

    Source: L. F. Richardson, Phil. Trans. R. Soc. A 226, 299 (1927), for the extrapolation.

    Raises:
        PhyscoreError: every run diverged.
    """
    best = candidates[0]
    others = other_family(best, candidates)
    # Half of the budget for each: even a less accurate check finds errors.
    reference = _converge(experiment, best, candidates, budget.share(0.5 if others else 1.0), until)
    if not others:
        return reference
    check = _converge(experiment, others[0], candidates, budget, until)
    apart = float(experiment.distances(check.samples, reference.samples).max())
    agrees = apart <= AGREEMENT * (reference.uncertainty + check.uncertainty)
    uncertainty = reference.uncertainty if agrees else apart
    return replace(reference, uncertainty=uncertainty, check=check.choice, disagreement=apart, agrees=agrees)


def _converge(
    experiment: Experiment, method: Method, candidates: list[Method], budget: Budget, until: int
) -> Reference:
    """Halve the step until rounding dominates or the budget is spent, and return the result of the best three runs."""
    steps = experiment.steps_of(START * largest_step(method, candidates))
    choice = Choice(method.integrator, "f64", steps)
    runs: list[Trial] = []
    best: Reference | None = None
    worse = 0
    for _ in range(DEEPEST):
        reached, run = halved(experiment.completed, choice)
        runs = [*runs, run][-LEVELS:] if reached == choice else [run]
        choice = reached.finer()
        if len(runs) == LEVELS:
            latest = _extrapolate(experiment, method, runs, until)
            worse = worse + 1 if best is not None and latest.uncertainty > 0.5 * best.uncertainty else 0
            best = latest if best is None or latest.uncertainty < best.uncertainty else best
            if worse == 2 or 2.0 * run.seconds > budget.left():
                return best
    assert best is not None
    return best


def _extrapolate(experiment: Experiment, method: Method, runs: list[Trial], until: int) -> Reference:
    """The extrapolation of three runs, each with half the step of the previous one.

    With errors C dtᵖ, the difference of the last two runs is 2ᵖ − 1 times the error of the last one, which is
    subtracted. The uncertainty is the distance between the extrapolations of the first two and the last two runs, which
    is larger than the remaining error. If the differences do not decrease by 2ᵖ, nothing is subtracted, and the last
    difference is the uncertainty. The uncertainty is at least the rounding error.
    """
    coarse, middle, fine = (run.samples[:until] for run in runs)
    first, second = experiment.difference(middle, coarse), experiment.difference(fine, middle)
    before = float(experiment.distances(middle, coarse).max())
    after = float(experiment.distances(fine, middle).max())
    found = convergence([run.choice.steps for run in runs], [before, after], method.order)
    gain = float((1 << method.order) - 1)
    if found.asymptotic:
        samples = fine + second / gain
        left = experiment.distances(samples, middle + first / gain)
        uncertainty = float(left.max())
    else:
        samples, uncertainty = fine, max(after, before if after > before else 0.0)
    rounding = runs[-1].rounding * float(np.abs(samples).max())
    return Reference(
        samples, max(uncertainty, rounding), runs[-1].choice, found.order, found.asymptotic, None, 0.0, True
    )
