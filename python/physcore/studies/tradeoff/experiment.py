"""One scene over one duration, to be computed in many ways, and a trial of one of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from physcore.arithmetic import lengths
from physcore.checks import FloatArray, array
from physcore.errors import SceneError, SimulationDiverged
from physcore.numerics.choices import DivergenceRule
from physcore.numerics.fluids import Fluids
from physcore.numerics.integrators import Integrator
from physcore.scene.scene import ItemKey, Scene
from physcore.simulation.energy import Energy, EnergySeries
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation
from physcore.simulation.stepper import unwarned
from physcore.studies import clock
from physcore.studies.state import place, primary

SAMPLES = 32
"""Intervals of the duration unless another number is given. Every time step divides them."""

Precision = Literal["f32", "f64"]
EPSILON: dict[Precision, float] = {"f64": 2.0**-52, "f32": 2.0**-23}
"""The relative spacing of numbers."""

Observer = Callable[[Simulation], ArrayLike]
"""What is compared between runs: an array of the same shape at every time."""


@dataclass(frozen=True)
class Choice:
    """A way to compute."""

    integrator: Integrator
    precision: Precision
    steps: int
    """Steps in each of the intervals."""

    def finer(self, factor: int = 2) -> Choice:
        """The same with `factor` times as many steps."""
        return Choice(self.integrator, self.precision, self.steps * factor)


@dataclass(frozen=True, eq=False)
class Trial:
    """One run and what it cost."""

    choice: Choice
    samples: FloatArray
    """What was observed at the start and at the end of each interval, shape (intervals + 1, …); shorter where it
    diverged."""
    seconds: float
    """Spent in stepping, once: for planning, not for comparing."""
    evaluations: int
    """Evaluations of the forces."""
    energy_drift: float
    """The largest drift of the energy balance, over the same times; infinite where it diverged."""
    diverged: SimulationDiverged | None
    recording: Recording | None = None
    """All its frames, where they were asked for."""

    @property
    def rounding(self) -> float:
        """What rounding makes relative errors of about [1]: ε√n after n evaluations, for it walks at random.

        Source: D. Brouwer, Astron. J. 46, 149 (1937).
        """
        return EPSILON[self.choice.precision] * math.sqrt(self.evaluations)

    @property
    def complete(self) -> bool:
        """Whether it came to its end with numbers."""
        return self.diverged is None and bool(np.isfinite(self.samples).all())


@dataclass(frozen=True)
class Experiment:
    """A scene, how long to compute it, and what to compare."""

    scene: Scene
    duration: float
    """[s]"""
    threads: int | None = None
    observer: Observer | None = None
    """None: the positions of all particles; without any, the first field of the first system."""
    intervals: int = SAMPLES
    """Equal parts of the duration, at whose ends every run is looked at."""
    max_energy_growth: float | None = None
    """As in Simulation."""
    on_divergence: DivergenceRule = "raise"
    """As in Simulation."""
    integrators: Mapping[ItemKey, Integrator | str] | None = None
    """Those of the items, where they are given; a choice's is then that of the first."""
    fluids: Fluids = "auto"
    """As in Simulation."""

    @property
    def interval(self) -> float:
        """[s]"""
        return self.duration / self.intervals

    def dt(self, choice: Choice) -> float:
        """The time step of a choice [s]."""
        return self.interval / choice.steps

    def steps_of(self, largest: float) -> int:
        """The fewest steps per interval that are no longer than `largest` [s]."""
        return max(1, int(np.ceil(self.interval / largest - 1e-9)))

    def start(self, choice: Choice) -> Simulation:
        """A simulation at its start.

        Raises:
            SceneError: the scene cannot be computed so.
        """
        with unwarned():  # Whoever measures where it ends goes beyond.
            return Simulation(
                self.scene,
                self.integrators or choice.integrator,
                self.dt(choice),
                choice.precision,
                self.threads,
                max_energy_growth=self.max_energy_growth,
                on_divergence=self.on_divergence,
                fluids=self.fluids,
            )

    def observe(self, simulation: Simulation) -> FloatArray:
        """What is compared, of the present state.

        Raises:
            SceneError: the observer gives no array of finite numbers.
        """
        if self.observer is None:
            return place(simulation)
        return array(self.observer(simulation), "observe")

    def difference(self, one: FloatArray, other: FloatArray) -> FloatArray:
        """one − other; of positions in a periodic domain, the way to the nearest image."""
        if one.shape[1:] != other.shape[1:]:
            raise SceneError(f"observe: must always give one shape, gave {other.shape[1:]} and then {one.shape[1:]}")
        change: FloatArray = one - other
        if self._positions and self.scene.periodic is not None:
            return self.scene.periodic.nearest(change)
        return change

    @property
    def _positions(self) -> bool:
        """Whether positions are what is compared."""
        return self.observer is None and bool(self.scene.bodies)

    def distances(self, one: FloatArray, other: FloatArray) -> FloatArray:
        """The largest distance of any particle, or of any number that is observed, at each time; shape (F,)."""
        change = self.difference(one, other)
        sizes = lengths(change) if self._positions else np.abs(change)
        largest: FloatArray = sizes.reshape(len(sizes), -1).max(axis=1)
        return largest

    def attempt(self, choice: Choice) -> Trial:
        """Run it once, from start to end or until it diverges.

        Raises:
            SceneError: the scene cannot be computed so.
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
        """The same, of a run that comes to its end.

        Raises:
            SceneError: the scene cannot be computed so.
            SimulationDiverged: the run diverged.
        """
        trial = self.attempt(choice)
        if trial.diverged is not None:
            raise trial.diverged
        return trial

    def recorded(self, choice: Choice, duration: float, fps: float, channels: tuple[str, ...]) -> Trial:
        """The same, with a recording of its frames, of a duration [s] that ends less than an interval later.

        Raises:
            SceneError: the scene cannot be computed so, or the recording would not fit into memory.
            SimulationDiverged: the run diverged.
        """
        simulation = self.start(choice)
        begin = clock.seconds()
        with unwarned():
            recording = simulation.record(duration, fps, channels, progress=False)
        seconds = clock.seconds() - begin
        taken = simulation.steps * recording.plan.evaluations
        drift = _largest_drift(recording.energy)
        return Trial(choice, recording.channels[primary(self.scene)], seconds, taken, drift, None, recording)


def series(budget: list[Energy]) -> EnergySeries:
    """Budgets at several times as one over time."""
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
    """The largest drift of the energy balance; inf where energies are beyond the range of numbers."""
    drift = float(np.abs(energy.drift).max())
    return drift if math.isfinite(drift) else math.inf


def _stack(samples: list[FloatArray]) -> FloatArray:
    if any(sample.shape != samples[0].shape for sample in samples):
        shapes = sorted({sample.shape for sample in samples})
        raise SceneError(f"observe: must always give one shape, gave {' and '.join(map(str, shapes))}")
    return np.stack(samples)
