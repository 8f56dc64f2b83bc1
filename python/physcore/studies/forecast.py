"""Forecast of the duration of a run, from a few steps of a copy."""

from __future__ import annotations

import copy
import math
import warnings
from dataclasses import dataclass

from physcore.errors import SimulationDiverged
from physcore.simulation.simulation import Simulation
from physcore.simulation.stepper import unwarned
from physcore.studies import clock
from physcore.units.systems import SI, UnitSystem

TRIAL = 0.05
"""Least duration of the timed steps [s]: some thousand calls of the clock."""
PART, LONGEST = 0.01, 10.0
"""For long runs, fraction of the simulated duration that is timed, and its limit [s], so that rebuilds of neighbor
lists are included.
"""


@dataclass(frozen=True)
class Forecast:
    """Forecast of a run: its steps and their time; `str` gives it as text."""

    steps: int
    dt: float
    """Time step [s]."""
    seconds: float
    """Time of all steps at the present load of the machine [s]; 0 if the first steps diverge."""
    units: UnitSystem = SI
    """Units of the scene."""

    def __str__(self) -> str:
        return f"{self.steps} steps of {self.dt:.2g}{self.units.suffix('s')}, about {words(self.seconds)}"


def forecast(simulation: Simulation, duration: float) -> Forecast:
    """The forecast of a run of a duration [s], with steps of the present size."""
    steps, units = math.ceil(duration / simulation.dt), simulation.scene.units
    trial, count, taken = copy.copy(simulation), 1, 0.0
    with unwarned(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            trial.run(trial.dt)  # The first step builds the neighbor lists.
            begun, before = clock.seconds(), trial.steps
            while taken < TRIAL or taken < min(PART * steps * taken / (trial.steps - before), LONGEST):
                begun, before = clock.seconds(), trial.steps
                trial.run(count * trial.dt)
                taken, count = clock.seconds() - begun, 2 * count
        except SimulationDiverged:
            return Forecast(steps, simulation.dt, 0.0, units)
    return Forecast(steps, simulation.dt, steps * taken / max(trial.steps - before, 1), units)


def rehearsed(simulation: Simulation, duration: float) -> float:
    """Run a simulation, and return the ratio of its time to the forecast."""
    ahead, begun = forecast(simulation, duration), clock.seconds()
    simulation.run(duration)
    return (clock.seconds() - begun) / ahead.seconds if ahead.seconds > 0.0 else 1.0


def words(seconds: float) -> str:
    """A time in a suitable unit, as text."""
    for unit, length in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds:.0f} s"
