"""How long a run will take, from a few steps that a copy of it takes."""

from __future__ import annotations

import copy
import math
import warnings
from dataclasses import dataclass

from physcore.errors import SimulationDiverged
from physcore.simulation.simulation import Simulation
from physcore.simulation.stepper import unwarned
from physcore.studies import clock

TRIAL = 0.05
"""How long the steps are timed at least [s]: some thousand calls of the clock."""
PART, LONGEST = 0.01, 10.0
"""Of a long run a hundredth is timed, ten seconds [s] at most, so that the time of neighbor lists counts too."""


@dataclass(frozen=True)
class Forecast:
    """The steps of a run and their time; `str` says them in words."""

    steps: int
    dt: float
    """[s]"""
    seconds: float
    """Of all steps, on this machine as busy as it is; 0 where the first ones diverge."""

    def __str__(self) -> str:
        return f"{self.steps} steps of {self.dt:.2g} s, about {words(self.seconds)}"


def forecast(simulation: Simulation, duration: float) -> Forecast:
    """The steps and the time [s] of a run of a duration [s], in steps of the present length."""
    steps = math.ceil(duration / simulation.dt)
    trial, count, taken = copy.copy(simulation), 1, 0.0
    with unwarned(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            trial.run(trial.dt)  # The first step builds lists of neighbors.
            begun, before = clock.seconds(), trial.steps
            while taken < TRIAL or taken < min(PART * steps * taken / (trial.steps - before), LONGEST):
                begun, before = clock.seconds(), trial.steps
                trial.run(count * trial.dt)
                taken, count = clock.seconds() - begun, 2 * count
        except SimulationDiverged:
            return Forecast(steps, simulation.dt, 0.0)
    return Forecast(steps, simulation.dt, steps * taken / max(trial.steps - before, 1))


def rehearsed(simulation: Simulation, duration: float) -> float:
    """How many times as long a run takes as was forecast, which is taken."""
    ahead, begun = forecast(simulation, duration), clock.seconds()
    simulation.run(duration)
    return (clock.seconds() - begun) / ahead.seconds if ahead.seconds > 0.0 else 1.0


def words(seconds: float) -> str:
    """A time as people write it."""
    for unit, length in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds:.0f} s"
