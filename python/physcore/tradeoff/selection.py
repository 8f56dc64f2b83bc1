"""The search for the cheapest method and time step that meet a target, and the proof that they do.

Each candidate is priced by a short probe at its limit: what its error there says about the step that it needs, by its
order. The cheapest goes on with runs of the whole duration, at four times and twice the step that it needs, which say
better what that is, and at that step. Whenever another has become cheaper, that one goes on. The first run that is
proven to meet the target ends the search.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from physcore.errors import SimulationDiverged
from physcore.tradeoff.convergence import Convergence, convergence, order_between, stagnant
from physcore.tradeoff.experiment import Choice, Experiment, Precision, Trial
from physcore.tradeoff.methods import DEEPEST, SAFETY, Method, halved, largest_step

AIM = 0.7
"""The error that is aimed at, as a fraction of the target."""
PROBE = 16
"""A probe takes one part in so many of the duration, and one interval at least."""
EPSILON: dict[Precision, float] = {"f64": 2.0**-52, "f32": 2.0**-23}
"""The spacing of numbers at one."""
LEAP = 4
"""By which factor the number of steps grows at most, where the order has not been measured."""


@dataclass(frozen=True)
class Target:
    """What is asked for."""

    accuracy: float
    """The largest distance of any particle from where it should be, at the end of any interval [m]; inf: any."""
    energy_drift: float
    """The largest drift of the energy balance; inf: any."""

    @property
    def compares(self) -> bool:
        """Whether runs must be compared: a drift is seen in a run alone."""
        return math.isfinite(self.accuracy)

    def excess(self, error: float, drift: float) -> float:
        """The error or the drift over what was asked for, whichever is larger."""
        parts = [error / self.accuracy] * self.compares + [drift / self.energy_drift] * math.isfinite(self.energy_drift)
        return max(parts)


@dataclass
class Candidate:
    """A method, and its step-size series so far."""

    experiment: Experiment
    method: Method
    precision: Precision
    target: Target
    record: Callable[[Choice], Trial]
    coarsest: int
    """Steps per interval at the limit."""
    excess: float | None = None
    """Over the target, at the end of the probe; None before."""
    trials: list[Trial] = field(default_factory=list)
    """Of the whole duration, by rising number of steps: the last three at most."""
    changes: list[float] = field(default_factory=list)
    """The largest distance between each and the one before [m]."""
    drifts: list[float] = field(default_factory=list)
    """The largest drift of the energy balance of each."""

    def probe(self, intervals: int) -> None:
        """Run a short time at the limit, and at half of that where runs must be compared."""
        choice, coarse = halved(lambda each: self.experiment.completed(each, intervals), self._choice(self.coarsest))
        self.coarsest, error = choice.steps, 0.0
        if self.target.compares:
            finer, fine = halved(lambda each: self.experiment.completed(each, intervals), choice.finer())
            error = float(self.experiment.distances(fine.samples, coarse.samples).max())
        self.excess = self.target.excess(max(error, self._rounding(coarse)), coarse.energy_drift)

    def expected(self, steps: int, growth: float) -> float:
        """What the probe says about the excess with so many steps, where errors grow so much after its end."""
        return growth * (self.excess or 0.0) * (self.coarsest / steps) ** self.method.order

    def needed(self, growth: float) -> int:
        """Steps per interval that meet the target, as far as is known."""
        order = self.method.order
        if not self.trials:
            return max(self.coarsest, math.ceil(self.coarsest * (self.expected(self.coarsest, growth) / AIM) ** (1 / order)))
        last, least = self.trials[-1], 0.0
        if self.target.compares and self.changes:
            found = self.convergence
            measured = order if found.asymptotic or math.isnan(found.order) else min(max(found.order, 1.0), order)
            error = found.expected if found.asymptotic or len(self.changes) < 2 else found.finer
            # Beyond rounding no step helps.
            least = (error / max(AIM * self.target.accuracy, self._rounding(last))) ** (1.0 / measured)
        if math.isfinite(self.target.energy_drift):
            measured = order_between([trial.choice.steps for trial in self.trials], self.drifts[-len(self.trials) :], order)
            floor = float(EPSILON[self.precision])
            least = max(least, (last.energy_drift / max(AIM * self.target.energy_drift, floor)) ** (1.0 / measured))
        if self.target.compares and not self.changes:
            least = max(least, 2.0)
        return math.ceil(min(last.choice.steps * least, float(self.coarsest << DEEPEST) + 1.0))

    def next(self, growth: float) -> int:
        """Steps per interval of the next run."""
        needed, order = self.needed(growth), self.method.order
        if not self.trials:
            return max(self.coarsest, math.ceil(needed / 4))
        last = self.trials[-1].choice.steps
        if self.target.compares and len(self.trials) == 1:
            return 2 * last
        if needed <= last:
            coarser = self.trials[0].choice.steps // 2
            return coarser if len(self.trials) == 2 and coarser >= self.coarsest else 2 * last
        least = math.ceil(last * 2.0 ** (1.0 / order))
        if not self.target.compares:
            return max(least, min(needed, LEAP * last))
        if not (len(self.trials) < 3 or self.convergence.asymptotic):
            return 2 * last
        part = next(part for part in (1, 2, 4) if needed <= 2 * part * last or part == 4)
        return max(least, min(math.ceil(needed / part), LEAP * last) if len(self.trials) < 3 else math.ceil(needed / part))

    def price(self, growth: float) -> float:
        """The evaluations of the forces until it meets the target, about: of the run that does, and of those before."""
        needed = self.needed(growth)
        last = self.trials[-1].choice.steps if self.trials else 0
        runs = [needed / part for part in (1, 2, 4) if part == 1 or needed / part > last]
        return self.method.evaluations * sum(max(self.coarsest, steps) for steps in runs)

    def advance(self, growth: float) -> None:
        """Take the next run.

        Raises:
            PhyscoreError: it diverges at every step.
        """
        steps = self.next(growth)
        run = self.record if steps >= self.needed(growth) / 2 else self.experiment.completed
        if self.trials and steps < self.trials[0].choice.steps:
            self._verify(steps)
            return
        choice, trial = halved(run, self._choice(steps))
        if choice.steps > steps:
            self.coarsest = max(self.coarsest, choice.steps) if not self.trials else self.coarsest
            self.trials.clear()
            self.changes.clear()
            self.drifts.clear()
        if self.trials:
            self.changes.append(self._distance(self.trials[-1], trial))
        self.trials = [*self.trials, trial][-3:]
        self.drifts.append(trial.energy_drift)

    def proven(self) -> tuple[Trial, float] | None:
        """The longest step that is proven to meet the target, with the bound on its error; None if none is."""
        target = self.target
        if not self.trials:
            return None
        found = self.convergence if self.changes else None
        if not target.compares:
            last = self.trials[-1]
            error = math.inf if found is None else found.finer
            return (last, error) if last.energy_drift <= target.energy_drift else None
        if found is None:
            return None
        for trial, error in ((self.trials[-2], found.coarser), (self.trials[-1], found.finer)):
            if error <= target.accuracy and trial.energy_drift <= target.energy_drift:
                return trial, error
        return None

    @property
    def convergence(self) -> Convergence:
        """What the last two or three runs say."""
        steps = [trial.choice.steps for trial in self.trials]
        return convergence(steps, self.changes[-len(steps) + 1 :], self.method.order)

    @property
    def stagnant(self) -> bool:
        """Whether smaller steps have stopped to help."""
        if not self.trials or self.trials[-1].choice.steps > self.coarsest << DEEPEST:
            return bool(self.trials)
        samples = self.trials[-1].samples
        motion = float(self.experiment.distances(samples, samples[:1]).max())
        missed = self.drifts[-1] > self.target.energy_drift and stagnant(self.drifts, 1.0)
        return missed or (self.target.compares and stagnant(self.changes, motion))

    def _verify(self, steps: int) -> None:
        """Measure the order by a longer step than those so far."""
        trial = self.experiment.attempt(self._choice(steps))
        if not trial.complete:
            self.coarsest = steps + 1
            return
        self.changes.insert(0, self._distance(trial, self.trials[0]))
        self.trials.insert(0, trial)

    def _choice(self, steps: int) -> Choice:
        return Choice(self.method.integrator, self.precision, steps)

    def _distance(self, one: Trial, other: Trial) -> float:
        return float(self.experiment.distances(one.samples, other.samples).max())

    def _rounding(self, trial: Trial) -> float:
        """The spacing of numbers where particles are farthest out [m]."""
        return float(EPSILON[self.precision] * np.abs(trial.samples).max())


@dataclass(frozen=True)
class Selection:
    """What the search found."""

    candidate: Candidate
    trial: Trial | None
    """The run that meets the target; None: there is none, and the candidate is that which came closest."""
    error: float
    """Bound on the error of that run [m], or of the best one; inf where nothing was compared."""
    drift: float


def select(candidates: list[Candidate]) -> Selection | None:
    """The cheapest method and step that meet the target of some candidates; None where every one diverged."""
    left = list(candidates)
    intervals = left[0].experiment.intervals
    short = max(1, intervals // PROBE)
    growth = intervals / short
    best: Selection | None = None
    most = math.inf
    while left := [each for each in left if each.price(growth) < most]:
        candidate = min(left, key=lambda each: each.price(growth))
        try:
            if candidate.excess is None and len(left) > 1:
                candidate.probe(short)
                continue
            fresh = not candidate.changes if candidate.target.compares else not candidate.trials
            candidate.advance(growth)
        except SimulationDiverged:
            left.remove(candidate)
            continue
        if (found := candidate.proven()) is not None:
            return Selection(candidate, found[0], found[1], found[0].energy_drift)
        last, error = candidate.trials[-1], candidate.convergence.finer if candidate.changes else math.inf
        if fresh and candidate.excess and (candidate.changes or not candidate.target.compares):
            seen = candidate.convergence.expected if candidate.changes else 0.0
            measured = candidate.target.excess(seen, last.energy_drift)
            growth *= measured / candidate.expected(last.choice.steps, growth)
        if best is None or candidate.target.excess(error, last.energy_drift) < candidate.target.excess(best.error, best.drift):
            best = Selection(candidate, None, error, last.energy_drift)
        if candidate.stagnant:
            # Rounding adds up with evaluations: who takes more of them comes no closer.
            left.remove(candidate)
            most = min(most, float(candidate.method.evaluations * last.choice.steps))
    return best
