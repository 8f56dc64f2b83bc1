"""Step-size series: the rows of one integrator in one precision, by decreasing time step."""

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
"""Number of timings of each row."""
SHORTEST = 2e-3
"""Least duration of a timing [s]; for shorter runs, several are timed together and averaged."""
MOST_RUNS = 20
"""Largest number of runs in one timing."""
LEAST = 3
"""Number of rows of a series that are run beyond the budget, once more as long: fewer rows have no slope."""
LOWEST = 24
"""Largest number of rows of a series."""


@dataclass
class Measurement:
    """Row that is still being measured."""

    choice: Choice
    error: float
    energy_drift: float
    evaluations: int
    status: Status
    seconds: float
    """Time of the steps in the run that gave the error [s]."""
    cost: float
    """Time of a single run, including the construction of the simulation [s]."""
    judging: float
    """Additional time to measure its error [s]."""
    bias: Bias | None = None
    held_out: bool = False
    times: list[float] = field(default_factory=list)

    @property
    def runs(self) -> int:
        """The number of runs in one timing."""
        return math.ceil(min(MOST_RUNS, SHORTEST / max(self.seconds, SHORTEST / MOST_RUNS)))


@dataclass
class StepSizeSeries:
    """Rows of one integrator in one precision, by decreasing time step."""

    integrator: Integrator
    precision: Literal["f32", "f64"]
    order: int
    """Order of the integrator in this scene."""
    pairs: int
    memory: int
    choices: list[Choice]
    """Choices still to run, the coarsest first."""
    measurements: list[Measurement] = field(default_factory=list)
    open_ended: bool = True
    """Whether the series continues with finer steps after these choices."""

    def next(self) -> Choice | None:
        """The next choice to run; None at the end of the series."""
        if self.choices:
            return self.choices[0]
        if not self.open_ended or len(self.measurements) >= LOWEST:
            return None
        return self.measurements[-1].choice.finer()

    def cost(self) -> float:
        """The expected time of the next choice, including its timing [s]; 0 if unknown."""
        choice = self.next()
        if not self.measurements or choice is None:
            return 0.0
        last = self.measurements[-1]
        return ((1 + REPEATS) * last.cost + last.judging) * choice.steps / last.choice.steps

    def exhausted(self, uncertainty: float) -> bool:
        """Whether smaller steps no longer help, or the error is near the uncertainty of the reference."""
        errors = [measurement.error for measurement in self.measurements]
        if len(errors) < LEAST:
            return False
        if errors[-1] < CERTAIN * uncertainty:
            return True
        finite = [error for error in errors if math.isfinite(error)]
        return stagnant(errors, max(finite, default=0.0))

    def has_room(self, index: int, parts: int, uncertainty: float) -> bool:
        """Whether a held-out row with a multiple of `parts` steps fits between two successive rows, which are both
        valid.

        No row is predicted from held-out rows.
        """
        coarse, fine = self.measurements[index : index + 2]
        room = fine.choice.steps >= 2 * coarse.choice.steps and fine.choice.steps - coarse.choice.steps >= 2 * parts
        fresh = not (coarse.held_out or fine.held_out)
        return room and fresh and math.isfinite(coarse.error) and fine.error >= CERTAIN * uncertainty

    def gap(self, index: int) -> float:
        """The factor by which the error decreases from one row to the next; 0 if it does not."""
        coarse, fine = self.measurements[index : index + 2]
        return coarse.error / fine.error if coarse.error > fine.error > 0.0 else 0.0

    def between(self, index: int) -> tuple[float, float]:
        """The expected error and cost halfway between a row and the next, by logarithmic interpolation."""
        coarse, fine = self.measurements[index : index + 2]
        return math.sqrt(coarse.error * fine.error), math.sqrt(coarse.cost * fine.cost)

    def prediction(self, held_out: Measurement) -> Prediction:
        """Error and time by log–log interpolation between the rows on both sides that were not held out."""
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
