"""Refinement: runs of one method with decreasing time steps, which prove the errors of each other."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from physcore.arithmetic import power
from physcore.checks import FloatArray
from physcore.studies.state import can_touch
from physcore.studies.tradeoff.convergence import Convergence, convergence, errors_of, order_between, stagnant
from physcore.studies.tradeoff.experiment import Experiment, Trial

AIM = 0.7
"""Intended error, as a fraction of the target."""


@dataclass(frozen=True)
class Target:
    """Target: the largest error and drift."""

    accuracy: float
    """Largest error of any particle's position at the end of any interval [m]; inf: no limit."""
    energy_drift: float
    """Largest drift of the energy balance; inf: no limit."""

    @property
    def compares(self) -> bool:
        """Whether runs must be compared with each other. A drift is known from a single run."""
        return math.isfinite(self.accuracy)

    def met_by(self, error: float, drift: float) -> bool:
        """Whether an error and a drift are within the target."""
        return (error <= self.accuracy or not self.compares) and drift <= self.energy_drift

    def excess(self, error: float, drift: float) -> float:
        """The ratio of the error or the drift to the target, whichever is larger."""
        return max(error / self.accuracy if self.compares else 0.0, drift / self.energy_drift)


@dataclass
class Refinement:
    """Runs of one method in one precision, by increasing number of steps."""

    experiment: Experiment
    order: int
    """Order p of the method."""
    target: Target
    trials: list[Trial] = field(default_factory=list)
    """The last three trials at most."""
    changes: list[float] = field(default_factory=list)
    """Largest distance between successive runs [m]."""
    drifts: list[float] = field(default_factory=list)
    """Largest drift of the energy balance of each run."""

    counts: list[int] = field(default_factory=list)
    """Number of steps per interval of each run."""

    def add(self, trial: Trial) -> None:
        """Add a run with more steps than all so far. A second run, for the order, may have fewer than the first."""
        coarser = bool(self.trials) and trial.choice.steps < self.counts[0]
        at = 0 if coarser else len(self.counts)
        if self.trials:
            self.changes.insert(at, self.distance(trial.samples, self.trials[0 if coarser else -1].samples))
        self.drifts.insert(at, trial.energy_drift)
        self.counts.insert(at, trial.choice.steps)
        self.trials = [trial, *self.trials] if coarser else [*self.trials, trial][-3:]

    def clear(self) -> None:
        """Remove all runs."""
        self.trials, self.changes, self.drifts, self.counts = [], [], [], []

    @property
    def steps(self) -> list[int]:
        """Numbers of steps per interval of the last three runs."""
        return self.counts[-3:]

    @property
    def certain(self) -> int | None:
        """The guaranteed order: 1 if bodies can hit something, 2 with forces that have a kink or a jump at their
        range, which is reached at any time within a step. None for smooth motion.
        """
        scene = self.experiment.scene
        if scene.boundaries or can_touch(scene):
            return 1
        kinked = scene.fluids or any(force.has_kink for force in scene.forces)
        return 2 if kinked and self.order > 2 else None

    @property
    def convergence(self) -> Convergence | None:
        """The convergence of the last two runs; None before there are two."""
        return convergence(self.counts, self.changes, self.order, self.certain) if self.changes else None

    @property
    def estimated(self) -> bool:
        """Whether the distance of the last run from the target is known."""
        return bool(self.changes if self.target.compares else self.trials)

    @property
    def asymptotic(self) -> bool:
        """Whether errors follow the order of the method. With fewer than three runs this is assumed."""
        found = self.convergence
        return found is None or found.asymptotic or math.isnan(found.order)

    def proven(self) -> tuple[Trial, float] | None:
        """The run with the longest step that is proven to meet the target, and the bound on its error [m]."""
        found = self.convergence
        if found is None:
            only = [] if self.target.compares else [(self.trials[-1], math.inf)]
        else:
            only = [(self.trials[-2], found.coarser), (self.trials[-1], found.finer)]
        return next((each for each in only if self.target.met_by(each[1], each[0].energy_drift)), None)

    @property
    def goal(self) -> Target:
        """The intended error and drift: somewhat less than the target, but at least the rounding error."""
        last = self.trials[-1]
        extent = float(abs(last.samples).max())
        return Target(
            max(AIM * self.target.accuracy, last.rounding * extent), max(AIM * self.target.energy_drift, last.rounding)
        )

    def excess(self) -> float:
        """The expected ratio of the last run to the goal, once the order is measured."""
        found = self.convergence
        return self.goal.excess(found.expected if found else 0.0, self.drifts[-1])

    def factor(self) -> float:
        """The factor of the number of steps, relative to the last run, that reaches the goal by the measured order.

        With x times as many steps, errors scale as x⁻ᵖ and rounding errors as √x. Steps beyond their crossing are
        useless.
        """
        found, goal = self.convergence, self.goal
        order = order_between(self.steps, self.drifts[-len(self.steps) :], self.order)
        pairs = [(self.drifts[-1], goal.energy_drift, self.target.energy_drift, order)]
        if found is not None and self.target.compares:
            order, error = float(self.order), found.expected
            if not self.asymptotic:
                order = min(max(found.order, 1.0), order)
                error = found.finer if math.isfinite(found.finer) else error
            pairs.append((error, goal.accuracy, self.target.accuracy, order))
        return max(
            float(power(value / reachable, 1.0 / (order if reachable < wanted else order + 0.5)))
            for value, reachable, wanted, order in pairs
        )

    def doubtful(self) -> bool:
        """Whether errors do not even follow order one, because of chaos or rounding."""
        found = self.convergence
        return self.certain != 1 and found is not None and found.order < 1.0

    def stagnant(self) -> bool:
        """Whether smaller steps no longer reduce the error or the drift that misses the target."""
        if not self.trials:
            return False
        drifts = self.drifts if self.drifts[-1] > self.target.energy_drift else []
        if stagnant(drifts, 1.0, self.counts):
            return True
        return self.target.compares and stagnant(errors_of(self.counts, self.changes), self._motion(), self.counts[1:])

    def distance(self, one: FloatArray, other: FloatArray) -> float:
        """The largest distance of any particle at the end of any interval [m]."""
        return float(self.experiment.distances(one, other).max())

    def _motion(self) -> float:
        """The largest distance of any particle from its start [m].

        The value is 0 with impacts, because differences then decrease irregularly, long before they are small.
        """
        samples = self.trials[-1].samples
        return self.distance(samples, samples[:1]) if self.certain != 1 else 0.0
