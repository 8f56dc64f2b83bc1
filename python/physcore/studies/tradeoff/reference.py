"""The reference: the best method at ever finer steps, extrapolated, and checked by a method of another family."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from physcore.checks import FloatArray
from physcore.studies.tradeoff.budget import Budget
from physcore.studies.tradeoff.convergence import convergence
from physcore.studies.tradeoff.experiment import SAMPLES, Choice, Experiment, Trial
from physcore.studies.tradeoff.methods import DEEPEST, Method, halved, largest_step, other_family

START = 0.5
"""The first step is at most this fraction of its limit."""
LEVELS = 3
"""Runs that an extrapolation takes: at dt, dt/2 and dt/4."""
AGREEMENT = 3.0
"""How many times their uncertainties two methods may be apart before the larger of the two counts for nothing."""


@dataclass(frozen=True, eq=False)
class Reference:
    """What is taken for the truth, and how far it can be trusted."""

    samples: FloatArray
    """At the start and the end of each interval, shape (33, …)."""
    uncertainty: float
    """The largest distance that it may have from the truth [m], or in the unit of what is observed."""
    choice: Choice
    """The finest run in it."""
    order: float
    """The order that was observed in its last three runs; not a number where their differences do not shrink."""
    extrapolated: bool
    """Whether that was the order of the method, so that Richardson's extrapolation was worth doing."""
    check: Choice | None
    """The finest run of the method that it was checked by; None where no other family can compute the scene."""
    disagreement: float
    """How far the two are apart [m]; 0 where there is no other."""
    agrees: bool
    """Whether that is within their uncertainties."""


def find(experiment: Experiment, candidates: list[Method], budget: Budget, until: int = SAMPLES + 1) -> Reference:
    """The best reference that some methods, the most accurate first, and a budget allow, of the first `until` samples.

    Source of the extrapolation: L. F. Richardson, Phil. Trans. R. Soc. A 226, 299 (1927).

    Raises:
        PhyscoreError: every run diverged.
    """
    best = candidates[0]
    others = other_family(best, candidates)
    # Half for each: a check that is worse than what it checks still finds what is wrong.
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
    """Halve the step until rounding, or the budget, ends it; give the best three runs."""
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
    """What three runs, each at half the step of the one before, say together.

    With errors C dtᵖ the difference of the last two is 2ᵖ − 1 times the error of the last, which is taken off. What is
    left is smaller than what the same correction changes from the first two runs to the last two: the uncertainty.
    Where the differences do not shrink by 2ᵖ nothing is taken off, and the last difference itself counts. No reference
    is better than rounding lets it be.
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
