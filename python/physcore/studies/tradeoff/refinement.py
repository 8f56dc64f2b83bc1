"""Refinement: whole runs of one method with falling time steps, and what they prove of each other."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from physcore.arithmetic import power
from physcore.checks import FloatArray
from physcore.forces import LennardJones, SoftSpheres
from physcore.studies.tradeoff.convergence import Convergence, convergence, order_between, stagnant
from physcore.studies.tradeoff.experiment import Experiment, Trial

AIM = 0.7
"""The error that is aimed at, as a fraction of the target."""


@dataclass(frozen=True)
class Target:
    """What is asked for."""

    accuracy: float
    """The largest distance of any particle from where it should be, at the end of any interval [m]; inf: any."""
    energy_drift: float
    """The largest drift of the energy balance; inf: any."""

    @property
    def compares(self) -> bool:
        """Whether runs must be compared with each other: a drift is seen in one alone."""
        return math.isfinite(self.accuracy)

    def met_by(self, error: float, drift: float) -> bool:
        """Whether both are within what was asked for."""
        return (error <= self.accuracy or not self.compares) and drift <= self.energy_drift

    def excess(self, error: float, drift: float) -> float:
        """The error or the drift over what was asked for, whichever is larger."""
        return max(error / self.accuracy if self.compares else 0.0, drift / self.energy_drift)


@dataclass
class Refinement:
    """Runs of one method in one precision, by rising number of steps."""

    experiment: Experiment
    order: int
    """Of the method, p."""
    target: Target
    trials: list[Trial] = field(default_factory=list)
    """The last three at most."""
    changes: list[float] = field(default_factory=list)
    """The largest distance between each run and the one before [m]."""
    drifts: list[float] = field(default_factory=list)
    """The largest drift of the energy balance of each run."""

    counts: list[int] = field(default_factory=list)
    """Steps per interval of each run."""

    def add(self, trial: Trial) -> None:
        """A run with more steps than all so far; or, to measure the order, one with fewer than two."""
        coarser = bool(self.trials) and trial.choice.steps < self.counts[0]
        at = 0 if coarser else len(self.counts)
        if self.trials:
            self.changes.insert(at, self.distance(trial.samples, self.trials[0 if coarser else -1].samples))
        self.drifts.insert(at, trial.energy_drift)
        self.counts.insert(at, trial.choice.steps)
        self.trials = [trial, *self.trials] if coarser else [*self.trials, trial][-3:]

    def clear(self) -> None:
        """Begin anew."""
        self.trials, self.changes, self.drifts, self.counts = [], [], [], []

    @property
    def steps(self) -> list[int]:
        """Steps per interval of the last three runs."""
        return self.counts[-3:]

    @property
    def certain(self) -> int | None:
        """The order that is certain: one where particles can hit something, two where forces between them begin, or
        end, with a kink or a jump, which comes anywhere in a step; None where the motion is smooth.
        """
        scene = self.experiment.scene
        if scene.boundaries:
            return 1
        kinked = scene.fluids or any(isinstance(force, (SoftSpheres, LennardJones)) for force in scene.forces)
        return 2 if kinked and self.order > 2 else None

    @property
    def convergence(self) -> Convergence | None:
        """What the runs so far say of the last two; None before there are two."""
        return convergence(self.counts, self.changes, self.order, self.certain) if self.changes else None

    @property
    def estimated(self) -> bool:
        """Whether it is known how far the last run is from the target."""
        return bool(self.changes if self.target.compares else self.trials)

    @property
    def asymptotic(self) -> bool:
        """Whether errors follow the order of the method, as far as that was looked at: it takes three runs."""
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
        """What is aimed at: somewhat less than the target, but no less than rounding allows."""
        last = self.trials[-1]
        extent = float(abs(last.samples).max())
        return Target(
            max(AIM * self.target.accuracy, last.rounding * extent), max(AIM * self.target.energy_drift, last.rounding)
        )

    def excess(self) -> float:
        """Of the last run over the goal, as is expected of it once the order is measured."""
        found = self.convergence
        return self.goal.excess(found.expected if found else 0.0, self.drifts[-1])

    def factor(self) -> float:
        """How many times as many steps as the last run's reach the goal, by the order that was measured.

        With x times as many, errors are x⁻ᵖ and rounding √x times as large: more than where they meet are no use.
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
        """Whether errors do not follow even order one: chaos, or rounding, may rule."""
        found = self.convergence
        return self.certain != 1 and found is not None and found.order < 1.0

    def stagnant(self) -> bool:
        """Whether smaller steps have stopped to bring what misses the target nearer to it."""
        if not self.trials:
            return False
        drifts = self.drifts if self.drifts[-1] > self.target.energy_drift else []
        return stagnant(drifts, 1.0) or (self.target.compares and stagnant(self.changes, self._motion()))

    def distance(self, one: FloatArray, other: FloatArray) -> float:
        """The largest of any particle, at the end of any interval [m]."""
        return float(self.experiment.distances(one, other).max())

    def _motion(self) -> float:
        """The largest distance of any particle from its start [m].

        0 where particles hit something: differences then shrink by fits and starts, long before they are small.
        """
        samples = self.trials[-1].samples
        return self.distance(samples, samples[:1]) if self.certain != 1 else 0.0
