"""A step-size series: the rows of one integrator in one precision, by falling time step."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from physcore.arithmetic import exp, log
from physcore.numerics.integrators import Integrator
from physcore.studies.tradeoff.convergence import stagnant
from physcore.studies.tradeoff.experiment import Choice
from physcore.studies.tradeoff.restarts import Bias
from physcore.studies.tradeoff.result import CERTAIN, Prediction, Status

REPEATS = 5
"""How often each row is timed."""
SHORTEST = 2e-3
"""What is timed takes as long as this [s]: of shorter runs several in a row, whose mean is taken."""
MOST_RUNS = 20
"""Runs in a row at most."""
LEAST = 3
"""Rows of a series that come to an end and may take the budget once more: fewer have no slope."""
LOWEST = 24
"""Rows of a series at most."""


@dataclass
class Measurement:
    """A row in the making."""

    choice: Choice
    error: float
    energy_drift: float
    evaluations: int
    status: Status
    seconds: float
    """Spent in stepping, in the run that found the error."""
    cost: float
    """What running it once takes [s], with its building."""
    judging: float
    """What finding its error took beside that [s]."""
    bias: Bias | None = None
    held_out: bool = False
    times: list[float] = field(default_factory=list)

    @property
    def runs(self) -> int:
        """How many runs make one time."""
        return math.ceil(min(MOST_RUNS, SHORTEST / max(self.seconds, SHORTEST / MOST_RUNS)))


@dataclass
class StepSizeSeries:
    """The rows of one integrator in one precision, by falling time step."""

    integrator: Integrator
    precision: Literal["f32", "f64"]
    pairs: int
    memory: int
    choices: list[Choice]
    """Yet to run, the coarsest first."""
    measurements: list[Measurement] = field(default_factory=list)
    open_ended: bool = True
    """Whether a finer one follows the last of them."""

    def next(self) -> Choice | None:
        """What to run now."""
        if self.choices:
            return self.choices[0]
        if not self.open_ended or len(self.measurements) >= LOWEST:
            return None
        return self.measurements[-1].choice.finer()

    def cost(self) -> float:
        """What that will take, with its timing [s]; 0 where nobody knows yet."""
        choice = self.next()
        if not self.measurements or choice is None:
            return 0.0
        last = self.measurements[-1]
        return ((1 + REPEATS) * last.cost + last.judging) * choice.steps / last.choice.steps

    def exhausted(self, uncertainty: float) -> bool:
        """Whether finer steps have stopped to help, or the reference can no longer tell."""
        errors = [measurement.error for measurement in self.measurements]
        if len(errors) < LEAST:
            return False
        if errors[-1] < CERTAIN * uncertainty:
            return True
        finite = [error for error in errors if math.isfinite(error)]
        return stagnant(errors, max(finite, default=0.0))

    def has_room(self, index: int, parts: int, uncertainty: float) -> bool:
        """Whether a row of a multiple of `parts` steps fits between one and the next, both of which count.

        A row that was held out is not what another one is predicted from.
        """
        coarse, fine = self.measurements[index : index + 2]
        room = fine.choice.steps >= 2 * coarse.choice.steps and fine.choice.steps - coarse.choice.steps >= 2 * parts
        fresh = not (coarse.held_out or fine.held_out)
        return room and fresh and math.isfinite(coarse.error) and fine.error >= CERTAIN * uncertainty

    def gap(self, index: int) -> float:
        """By which factor the error falls from one row to the next; 0 where it does not."""
        coarse, fine = self.measurements[index : index + 2]
        return coarse.error / fine.error if coarse.error > fine.error > 0.0 else 0.0

    def between(self, index: int) -> tuple[float, float]:
        """Error and cost that are expected halfway from one row to the next, both logarithmic."""
        coarse, fine = self.measurements[index : index + 2]
        return math.sqrt(coarse.error * fine.error), math.sqrt(coarse.cost * fine.cost)

    def prediction(self, held_out: Measurement) -> Prediction:
        """Error and time by straight lines, both logarithmic, through the rows on both sides that were not held out."""
        others = [
            measurement
            for measurement in self.measurements
            if not measurement.held_out and math.isfinite(measurement.error)
        ]
        finer = next(measurement for measurement in others if measurement.choice.steps > held_out.choice.steps)
        coarser = next(
            measurement for measurement in reversed(others) if measurement.choice.steps < held_out.choice.steps
        )
        ends = log([coarser.choice.steps, finer.choice.steps])
        at = float(log(held_out.choice.steps))
        errors = log([max(measurement.error, np.finfo(float).tiny) for measurement in (coarser, finer)])
        seconds = log([np.median(measurement.times) for measurement in (coarser, finer)])
        return Prediction(float(exp(np.interp(at, ends, errors))), float(exp(np.interp(at, ends, seconds))))
