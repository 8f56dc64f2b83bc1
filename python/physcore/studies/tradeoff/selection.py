"""Search for the cheapest method and time step that meet a target, with a proof.

Each candidate makes a short test run at its limit. The ratio of its error to the target, and the order of the method,
give the approximate number of steps required, and hence the cost. The cheapest candidate then makes runs of the whole
duration, with a quarter, a half and all of these steps. Each run corrects their number. If another candidate becomes
cheaper meanwhile, that one continues. The first run that is proven to meet the target ends the search.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from physcore.arithmetic import power
from physcore.errors import SimulationDiverged
from physcore.studies.tradeoff.experiment import EPSILON, Choice, Experiment, Precision, Trial
from physcore.studies.tradeoff.methods import DEEPEST, Method, halved
from physcore.studies.tradeoff.refinement import Refinement, Target

PROBE = 16
"""Ratio of the whole duration to that of a test run."""
LEAP = 4
"""Largest factor of the number of steps, as long as the order has not been measured."""


class Candidate:
    """Candidate: a method, and its runs toward the steps that meet the target.

    Args:
        experiment: the experiment.
        method: the method.
        precision: "f32" or "f64".
        target: the target.
        coarsest: number of steps per interval at the method's limit.
        record: runs a choice with a recording.
    """

    def __init__(
        self,
        experiment: Experiment,
        method: Method,
        precision: Precision,
        target: Target,
        coarsest: int,
        record: Callable[[Choice], Trial],
    ) -> None:
        self.experiment = experiment
        self.method = method
        self.target = target
        self.refinement = Refinement(experiment, method.order, target)
        self.probed = False
        self._precision: Precision = precision
        self._coarsest = coarsest
        self._excess = 0.0
        self._record = record

    def probe(self) -> None:
        """Measure the ratio to the target after a short time, at about the limit.

        Raises:
            SimulationDiverged: the method diverges at every step.
        """
        self.probed = True
        parts, experiment = _short(self.experiment)
        runs = Refinement(experiment, self.method.order, self.target)
        choice = self._choice(-(-self._coarsest // parts))
        for _ in (1, 2) if self.target.compares else (1,):
            choice, trial = halved(experiment.completed, choice)
            runs.add(trial)
            choice = choice.finer()
        # The error of the coarser run is about the distance of the two runs.
        error = runs.changes[-1] if self.target.compares else 0.0
        excess = max(EPSILON[self._precision], runs.goal.excess(error, runs.drifts[0]))
        self._excess = excess * float(power(parts * runs.steps[0] / self._coarsest, self.method.order))

    def expected(self, growth: float) -> float:
        """The ratio to the target at the limit after the whole duration, if errors grow by the factor `growth` after
        the test run.
        """
        return growth * self._excess

    def observed(self) -> float:
        """The ratio to the target at the limit, from the last run and the order of the method."""
        steps = self.refinement.steps[-1] / self._coarsest
        return self.refinement.excess() * float(power(steps, self.method.order))

    def needed(self, growth: float) -> int:
        """The estimated number of steps per interval that meet the target."""
        most = float(self._coarsest << DEEPEST)
        if self.refinement.estimated:
            return math.ceil(min(self.refinement.steps[-1] * self.refinement.factor(), most))
        factor = float(power(self.expected(growth), 1.0 / self.method.order))
        return max(self._coarsest, math.ceil(min(self._coarsest * factor, most)))

    def cost(self, growth: float) -> float:
        """The number of force evaluations per interval of a run that meets the target."""
        return float(self.method.evaluations * max(self._coarsest, self.needed(growth)))

    def price(self, growth: float) -> float:
        """The number of force evaluations per interval, including those of the runs before it."""
        last = self.refinement.steps[-1] if self.refinement.trials else 0
        return self.cost(growth) * sum(
            1.0 / part for part in (1, 2, 4) if part == 1 or self.needed(growth) > part * last
        )

    def next_cost(self, growth: float) -> int:
        """The number of force evaluations per interval of the next run."""
        return self.method.evaluations * self._next(growth)

    def exhausted(self) -> bool:
        """Whether smaller steps do not help, or their number is at its limit."""
        return self.refinement.stagnant() or self.refinement.steps[-1] >= self._coarsest << DEEPEST

    def advance(self, growth: float) -> None:
        """Make the next run.

        Raises:
            SimulationDiverged: the method diverges at every step.
        """
        steps, runs = self._next(growth), self.refinement
        if runs.trials and steps < runs.steps[0]:
            trial = self.experiment.attempt(self._choice(steps))
            if trial.complete:
                runs.add(trial)
            else:
                self._coarsest = runs.steps[0]
            return
        # With about the required number of steps, the run may be the final one and is recorded.
        run = self._record if 2 * steps >= self.needed(growth) else self.experiment.completed
        choice, trial = halved(run, self._choice(steps))
        if choice.steps > steps:
            runs.clear()
            self._coarsest = choice.steps
        runs.add(trial)

    def _next(self, growth: float) -> int:
        """The number of steps per interval of the next run."""
        needed, runs = self.needed(growth), self.refinement
        if not runs.trials:
            return max(self._coarsest, math.ceil(needed / 4))
        last = runs.steps[-1]
        least = math.ceil(last * float(power(2.0, 1.0 / self.method.order)))
        if not self.target.compares:
            return max(least, min(needed, LEAP * last))
        if not runs.estimated or not runs.asymptotic:
            return 2 * last
        if needed <= last:
            # The steps seem sufficient, but the order is unknown: a coarser run measures it at a lower cost.
            coarser = runs.steps[0] // 2
            return coarser if len(runs.trials) == 2 and coarser >= self._coarsest else 2 * last
        # The three runs of a proof have similar numbers of steps, however different from earlier runs.
        part = 1 if needed <= 2 * last else 2 if needed <= 4 * last else 4
        most = LEAP * last if len(runs.trials) == 2 else needed
        return max(least, min(math.ceil(needed / part), most))

    def _choice(self, steps: int) -> Choice:
        return Choice(self.method.integrator, self._precision, steps)


@dataclass(frozen=True)
class Selection:
    """Result of the search."""

    candidate: Candidate
    trial: Trial
    """The run that meets the target, or the nearest one."""
    error: float
    """Bound on the error of that run [m]; inf if no runs were compared."""
    proven: bool
    """Whether the run is proven to meet the target."""

    @property
    def drift(self) -> float:
        """Drift of the energy balance of the run."""
        return self.trial.energy_drift

    @property
    def excess(self) -> float:
        """The ratio of the error or the drift to the target, whichever is larger."""
        return self.candidate.target.excess(self.error, self.drift)


def select(candidates: list[Candidate]) -> Selection | None:
    """The first run that is proven to meet the target; otherwise the nearest one, or None if all diverge."""
    experiment = candidates[0].experiment
    # Until the first run of the whole duration, errors are assumed to grow linearly with time.
    growth = experiment.duration / _short(experiment)[1].duration
    best: Selection | None = None
    left, affordable = list(candidates), math.inf
    while left := [each for each in left if each.cost(growth) <= affordable]:
        cheapest = min(left, key=lambda each: each.price(growth))
        doubtful = [each for each in left if each.refinement.doubtful()]
        candidate = min(cheapest, *doubtful, key=lambda each: each.next_cost(growth)) if doubtful else cheapest
        runs, known = candidate.refinement, candidate.refinement.estimated
        try:
            if not candidate.probed and len(left) > 1:
                candidate.probe()
                continue
            candidate.advance(growth)
        except SimulationDiverged:
            left.remove(candidate)
            continue
        if (found := runs.proven()) is not None:
            return Selection(candidate, *found, proven=True)
        if runs.estimated and not known and candidate.probed and 0.0 < candidate.observed() < math.inf:
            growth *= candidate.observed() / candidate.expected(growth)
        error = runs.convergence.finer if runs.convergence else math.inf
        latest = Selection(candidate, runs.trials[-1], error, proven=False)
        best = min((best or latest, latest), key=lambda each: each.excess)
        if candidate.exhausted():
            # Rounding errors grow with the evaluations, so methods with more of them are no better.
            left.remove(candidate)
            affordable = min(affordable, float(candidate.method.evaluations * runs.steps[-1]))
    return best


def _short(experiment: Experiment) -> tuple[int, Experiment]:
    """A short experiment of at most a sixteenth, and the number of its intervals in one of the whole."""
    parts = -(-PROBE // experiment.intervals)
    intervals = max(1, experiment.intervals // PROBE)
    return parts, replace(experiment, duration=experiment.interval * intervals / parts, intervals=intervals)
