"""Experiments: one scene over one duration, computed with different numerics, and the trials of these."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from physcore.checks import FloatArray, array
from physcore.errors import SceneError, SimulationDiverged
from physcore.numerics.choices import DivergenceRule
from physcore.numerics.contacts import Contacts
from physcore.numerics.fluids import Fluids
from physcore.numerics.integrators import Integrator
from physcore.scene.contents import ItemKey
from physcore.scene.scene import Scene
from physcore.simulation.energy import Energy, EnergySeries
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation
from physcore.simulation.step_warnings import unwarned
from physcore.studies import clock
from physcore.studies.tradeoff.comparison import Comparison, scales_of

SAMPLES = 32
"""Default number of intervals of the duration. Every time step divides an interval."""

Precision = Literal["f32", "f64"]
EPSILON: dict[Precision, float] = {"f64": 2.0**-52, "f32": 2.0**-23}
"""Machine epsilon of each precision."""

Observer = Callable[[Simulation], ArrayLike]
"""Function that gives the values compared between runs: an array of constant shape."""


@dataclass(frozen=True)
class Choice:
    """Choice of numerics."""

    integrator: Integrator
    precision: Precision
    steps: int
    """Number of steps per interval."""

    def finer(self, factor: int = 2) -> Choice:
        """The choice with `factor` times as many steps."""
        return Choice(self.integrator, self.precision, self.steps * factor)


@dataclass(frozen=True, eq=False)
class Trial:
    """Result and cost of one run."""

    choice: Choice
    samples: FloatArray
    """Observed values at the start and at the end of each interval, shape (intervals + 1, …); shorter if the run
    diverged.
    """
    seconds: float
    """Time of the steps in a single run [s], for planning, not for comparison."""
    evaluations: int
    """Number of force evaluations."""
    energy_drift: float
    """Largest drift of the energy balance at the same times; inf if the run diverged."""
    diverged: SimulationDiverged | None
    recording: Recording | None = None
    """Recording of all frames, if requested."""

    @property
    def rounding(self) -> float:
        """Approximate relative error due to rounding [1]: ε√n after n evaluations, as of a random walk.

        Source: D. Brouwer, Astron. J. 46, 149 (1937).
        """
        return EPSILON[self.choice.precision] * math.sqrt(self.evaluations)

    @property
    def complete(self) -> bool:
        """Whether the run ended without divergence, with finite values."""
        return self.diverged is None and bool(np.isfinite(self.samples).all())


@dataclass(frozen=True)
class Experiment:
    """Experiment: a scene, its duration, and the values to compare."""

    scene: Scene
    duration: float
    """Simulated duration [s]."""
    threads: int | None = None
    observer: Observer | None = None
    """Function of the compared values. None: the primary fields of all items, as in Comparison."""
    intervals: int = SAMPLES
    """Number of equal parts of the duration; values are compared at their ends."""
    max_energy_growth: float | None = None
    """Largest energy growth, as in Simulation."""
    on_divergence: DivergenceRule = "raise"
    """Rule for divergence, as in Simulation."""
    integrators: Mapping[ItemKey, Integrator | str] | None = None
    """Integrators of the items, if given; the integrator of a choice is then that of the first item."""
    fluids: Fluids = "auto"
    """Methods of fluids, as in Simulation."""
    contacts: Contacts = "auto"
    """Solver of the contacts of rigid bodies, as in Simulation."""
    scales: tuple[float, ...] = ()
    """Largest change of each compared item, if there are several, in a run with the default numerics. The run is made
    unless the changes are given.
    """

    def __post_init__(self) -> None:
        if self.observer is None and not self.scales:
            scales = scales_of(self.scene, self.duration, self.threads, self.fluids, self.contacts)
            object.__setattr__(self, "scales", scales)

    @property
    def comparison(self) -> Comparison:
        """How runs are compared without an observer."""
        return Comparison(self.scene, self.scales)

    @property
    def interval(self) -> float:
        """Length of an interval [s]."""
        return self.duration / self.intervals

    def dt(self, choice: Choice) -> float:
        """The time step of a choice [s]."""
        return self.interval / choice.steps

    def steps_of(self, largest: float) -> int:
        """The smallest number of steps per interval with steps not longer than `largest` [s]."""
        return max(1, int(np.ceil(self.interval / largest - 1e-9)))

    def start(self, choice: Choice) -> Simulation:
        """A simulation at its start.

        Raises:
            SceneError: the scene does not support the choice.
        """
        with unwarned():  # Trials exceed the limit of stability on purpose.
            return Simulation(
                self.scene,
                self.integrators or choice.integrator,
                self.dt(choice),
                choice.precision,
                self.threads,
                max_energy_growth=self.max_energy_growth,
                on_divergence=self.on_divergence,
                fluids=self.fluids,
                contacts=self.contacts,
            )

    def observe(self, simulation: Simulation) -> FloatArray:
        """The compared values of the present state.

        Raises:
            SceneError: the observer does not return an array of finite numbers.
        """
        if self.observer is None:
            return self.comparison.present(simulation)
        return array(self.observer(simulation), "observe")

    def difference(self, one: FloatArray, other: FloatArray) -> FloatArray:
        """The difference one − other; for positions in a periodic domain, the displacement to the nearest image."""
        if one.shape[1:] != other.shape[1:]:
            raise SceneError(f"observe: must always give one shape, gave {other.shape[1:]} and then {one.shape[1:]}")
        return self.comparison.difference(one, other) if self.observer is None else one - other

    def distances(self, one: FloatArray, other: FloatArray) -> FloatArray:
        """The largest distance of any particle, or of any observed value, at each time; shape (F,)."""
        change = self.difference(one, other)
        if self.observer is None:
            return self.comparison.distances(change)
        largest: FloatArray = np.abs(change).reshape(len(change), -1).max(axis=1)
        return largest

    def attempt(self, choice: Choice) -> Trial:
        """Run a choice once, until the end or until it diverges.

        Raises:
            SceneError: the scene does not support the choice.
        """
        simulation = self.start(choice)
        evaluations = simulation.evaluations
        samples, budget = [self.observe(simulation)], [simulation.energy()]
        seconds, diverged = 0.0, None
        for _ in range(self.intervals):
            try:
                begin = clock.seconds()
                try:
                    simulation.step(choice.steps)
                finally:
                    seconds += clock.seconds() - begin
                budget.append(simulation.energy())
            except SimulationDiverged as error:
                diverged = error
                break
            samples.append(self.observe(simulation))
        drift = math.inf if diverged else _largest_drift(series(budget))
        taken = max(1, simulation.steps)
        return Trial(choice, _stack(samples), seconds, taken * evaluations, drift, diverged)

    def completed(self, choice: Choice) -> Trial:
        """Run a choice once, until the end.

        Raises:
            SceneError: the scene does not support the choice.
            SimulationDiverged: the run diverged.
        """
        trial = self.attempt(choice)
        if trial.diverged is not None:
            raise trial.diverged
        return trial

    def recorded(self, choice: Choice, duration: float, fps: float, channels: tuple[str, ...]) -> Trial:
        """Run a choice once and record its frames, over a duration [s] that is longer by less than an interval.

        Raises:
            SceneError: the scene does not support the choice, or the recording would not fit into memory.
            SimulationDiverged: the run diverged.
        """
        simulation = self.start(choice)
        begin = clock.seconds()
        with unwarned():
            recording = simulation.record(duration, fps, channels, progress=False)
        seconds = clock.seconds() - begin
        taken = simulation.steps * recording.plan.evaluations
        drift = _largest_drift(recording.energy)
        comparison = self.comparison
        samples = comparison.joined([each.recorded(recording) for each in comparison.items], 1)
        return Trial(choice, samples, seconds, taken, drift, None, recording)


def series(budget: list[Energy]) -> EnergySeries:
    """The series of energy budgets at several times."""
    return EnergySeries(
        kinetic=np.array([energy.kinetic for energy in budget]),
        by_term={name: np.array([energy.by_term[name] for energy in budget]) for name in budget[0].by_term},
        internal=np.array([energy.internal for energy in budget]),
        dissipated=np.array([energy.dissipated for energy in budget]),
        dissipated_by={
            name: np.array([energy.dissipated_by[name] for energy in budget]) for name in budget[0].dissipated_by
        },
        work=np.array([energy.work for energy in budget]),
        times=np.array([energy.time for energy in budget]),
    )


def _largest_drift(energy: EnergySeries) -> float:
    """Largest drift of the energy balance; inf if energies overflow."""
    drift = float(np.abs(energy.drift).max())
    return drift if math.isfinite(drift) else math.inf


def _stack(samples: list[FloatArray]) -> FloatArray:
    if any(sample.shape != samples[0].shape for sample in samples):
        shapes = sorted({sample.shape for sample in samples})
        raise SceneError(f"observe: must always give one shape, gave {' and '.join(map(str, shapes))}")
    return np.stack(samples)
