"""Forecast of the duration of a run, from a few steps of a copy."""

from __future__ import annotations

import copy
import math
import warnings
from dataclasses import dataclass

from physcore.errors import SimulationDiverged
from physcore.simulation.simulation import Simulation
from physcore.simulation.step_warnings import unwarned
from physcore.studies import clock
from physcore.units.systems import SI, UnitSystem

TRIAL = 0.05
"""Least duration of the timed steps [s]: some thousand calls of the clock."""
REPEATED = 1000
"""Largest ratio of the timed steps to those of the run: free motion takes hardly any time."""
PART, LONGEST = 0.01, 10.0
"""For long runs, fraction of the simulated duration that is timed, and its limit [s], so that rebuilds of neighbor
lists are included.
"""


@dataclass(frozen=True)
class Forecast:
    """Forecast of a run: its steps and their time; `str` gives it as text."""

    steps: int | None
    """Number of steps; None if they follow the motion and a rehearsal does not tell."""
    dt: float
    """Time step [s]; the mean, if steps follow the motion."""
    seconds: float
    """Time of all steps at the present load of the machine [s]; 0 if the first steps diverge, or if it is unknown."""
    units: UnitSystem = SI
    """Units of the scene."""

    def __str__(self) -> str:
        if self.steps is None:
            return "a number of steps that is unknown ahead"
        return f"{self.steps} steps of {self.dt:.2g}{self.units.suffix('s')}, about {words(self.seconds)}"


def forecast(simulation: Simulation, duration: float) -> Forecast:
    """The forecast of a run of a duration [s], with steps of the present size, or as many as a rehearsal finds."""
    units = simulation.scene.units
    ahead = simulation._stepper.steps_ahead(duration)
    if not ahead:
        return Forecast(None, simulation.dt, 0.0, units)
    steps, dt = math.ceil(ahead), duration / ahead
    trial, count, taken = copy.copy(simulation), 1, 0.0
    with unwarned(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            trial.run(trial.dt)  # The first step builds the neighbor lists.
            begun, before = clock.seconds(), trial.steps
            while taken < TRIAL or taken < min(PART * steps * taken / (trial.steps - before), LONGEST):
                if count > REPEATED * steps:
                    break
                begun, before = clock.seconds(), trial.steps
                trial.run(count * dt)
                taken, count = clock.seconds() - begun, 2 * count
        except SimulationDiverged:
            return Forecast(steps, dt, 0.0, units)
    return Forecast(steps, dt, steps * taken / max(trial.steps - before, 1), units)


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
