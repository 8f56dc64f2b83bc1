"""Search for the Pareto front: series of decreasing time steps, starting at the limit of stability, within a budget."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from physcore.errors import PhyscoreError, SceneError, SimulationDiverged
from physcore.numerics.contacts import ContactSolver
from physcore.numerics.fluids import FluidMethod
from physcore.numerics.integrators import Integrator
from physcore.studies import clock
from physcore.studies.state import is_whole
from physcore.studies.tradeoff import reference, restarts
from physcore.studies.tradeoff.budget import Budget
from physcore.studies.tradeoff.chaos import Chaos, twin
from physcore.studies.tradeoff.experiment import Choice, Experiment
from physcore.studies.tradeoff.labels import labels
from physcore.studies.tradeoff.methods import SAFETY, halved, largest_step, methods, other_family
from physcore.studies.tradeoff.reference import Reference
from physcore.studies.tradeoff.restarts import Windows
from physcore.studies.tradeoff.result import CERTAIN, Measure, Row
from physcore.studies.tradeoff.step_sizes import LEAST, REPEATS, Measurement, StepSizeSeries

REFERENCE_SHARE = 0.3
"""Largest share of the reference in the budget."""
ENOUGH = 8
"""Number of rows after which a series continues only if its next row may be on the Pareto front."""
HELD_OUT = 8
"""Largest number of held-out rows, which are predicted from their neighbors before they are run."""
LOST = 0.5
"""Share of the largest displacement from which on an error leaves nothing right: the amplitude of an oscillation."""
WRONG = 10.0
"""Divergence threshold: an error of this many times the largest displacement in the reference, or an average off by
this many times its value.
"""


class WorkPrecisionDiagram:
    """Work–precision diagram of one scene: `find` finds the rows, `time` measures their times, `rows` returns them."""

    def __init__(
        self,
        experiment: Experiment,
        integrators: Sequence[Integrator],
        precisions: Sequence[Literal["f32", "f64"]],
        dts: Sequence[float] | None,
        seed: int,
        tick: Callable[[], None],
    ) -> None:
        self.experiment = experiment
        self.refused: dict[str, list[str]] = {}
        """Integrators that do not support the scene, by the reason."""
        self._seed = seed
        self._tick = tick
        self._searching = dts is None
        self.simd = ""
        self._methods = methods(experiment)
        self._labels = labels([*integrators, *(method.integrator for method in self._methods)])
        self._series = [
            series
            for integrator in integrators
            for precision in precisions
            if (series := self._new_series(integrator, precision, dts)) is not None
        ]
        self.chaos: Chaos
        self.truth: Reference | Windows
        self.measure: Measure = "trajectory"

    def find(self, budget: Budget) -> None:
        """Detect chaos, compute a reference, and run every series as far as the budget allows.

        Raises:
            PhyscoreError: no choice supports the scene, or every run of the reference diverged.
        """
        if not self._series:
            raise PhyscoreError(" ".join(self.notes) or "tradeoff: there is nothing to compare")
        self._judge(budget.share(REFERENCE_SHARE))
        while unfinished := [series for series in self._series if series.next() is not None]:
            series = min(unfinished, key=StepSizeSeries.cost)
            held = sum(measurement.status != "diverged" for measurement in series.measurements)
            left = budget.left() - self._timing() + (budget.seconds if held < LEAST else 0.0)
            if series.measurements and not series.choices and series.cost() > left:
                break
            self._run(series)
            if series.open_ended and (series.exhausted(self.truth.uncertainty) or self._left_behind(series)):
                series.open_ended = False
        if self._searching:
            self._refine(budget)

    def time(self) -> None:
        """Time all rows five times, each time in a new random order.

        Each time is that of a whole run in one call. The simulation is newly built, which is not timed, and the caches
        are warm from the first run of the row. Runs too short for the clock are timed several at once.
        """
        generator = np.random.default_rng(self._seed)
        measurements = [measurement for series in self._series for measurement in series.measurements]
        for _ in range(REPEATS):
            for index in generator.permutation(len(measurements)):
                measurement = measurements[index]
                measurement.times.append(
                    sum(self._time_once(measurement.choice) for _ in range(measurement.runs)) / measurement.runs
                )
                self._tick()

    @property
    def notes(self) -> list[str]:
        """Notes on omitted integrators, with reasons."""
        return [f"Left out: {', '.join(names)} ({reason})." for reason, names in self.refused.items()]

    def until(self) -> int:
        """The number of samples that can be compared."""
        return max(2, int(np.sum(self.chaos.times <= self.chaos.horizon)))

    def rows(
        self,
        resolution: float | None = None,
        discretization_error: float = 0.0,
        fluids: FluidMethod | None = None,
        contacts: ContactSolver | None = None,
    ) -> list[Row]:
        """The rows; `time` must be called before."""
        return [
            Row(
                integrator=series.integrator,
                label=self._labels[series.integrator],
                order=series.order,
                dt=self.experiment.dt(measurement.choice),
                precision=series.precision,
                threads=self.experiment.threads,
                seconds=float(np.median(measurement.times)),
                least_seconds=min(measurement.times),
                evaluations=measurement.evaluations,
                pair_interactions=measurement.evaluations * series.pairs,
                bytes_swept=measurement.evaluations * series.memory,
                error=measurement.error,
                error_uncertainty=self.truth.uncertainty,
                energy_drift=measurement.energy_drift,
                status=measurement.status,
                resolution=resolution,
                discretization_error=discretization_error,
                bias=measurement.bias,
                fluids=fluids,
                contacts=contacts,
                units=self.experiment.scene.units,
                prediction=series.prediction(measurement) if measurement.held_out else None,
            )
            for series in self._series
            for measurement in series.measurements
        ]

    def _time_once(self, choice: Choice) -> float:
        """The time of a whole run [s], or until it diverges."""
        simulation = self.experiment.start(choice)
        begin = clock.seconds()
        with contextlib.suppress(SimulationDiverged):
            simulation.run(self.experiment.duration)
        return clock.seconds() - begin

    def _new_series(
        self, integrator: Integrator, precision: Literal["f32", "f64"], dts: Sequence[float] | None
    ) -> StepSizeSeries | None:
        """A series that starts at the limit of an integrator, or has the given steps; None if the integrator does not
        support the scene.
        """
        try:
            plan = self.experiment.start(Choice(integrator, precision, 1)).plan
        except SceneError as error:
            reason = str(error).replace(f", got {type(integrator).__name__}", "")
            self.refused.setdefault(reason, []).append(f"{self._labels[integrator]} {precision}")
            return None
        self.simd = plan.simd
        known = [method for method in self._methods if method.integrator == integrator]
        method, *_ = known or methods(self.experiment, [integrator])
        largest = [SAFETY * largest_step(method, self._methods)] if dts is None else sorted(dts, reverse=True)
        steps = dict.fromkeys(self.experiment.steps_of(dt) for dt in largest)
        choices = [Choice(integrator, precision, number) for number in steps]
        open_ended = dts is None
        return StepSizeSeries(
            integrator, precision, plan.order, plan.pairs, plan.memory, choices, open_ended=open_ended
        )

    def _judge(self, budget: Budget) -> None:
        """Decide whether trajectories can be compared, and compute their reference."""
        best = self._methods[0]
        steps = self.experiment.steps_of(reference.START * best.accurate)
        choice, self.chaos = self._twin(Choice(best.integrator, "f64", steps))
        if not self.chaos.chaotic:
            self.truth = reference.find(self.experiment, self._methods, budget)
        elif not is_whole(self.experiment.scene) or self.experiment.observer is not None:
            # Restarts need the whole state, which for fluids and observers is more than positions and velocities.
            self.measure = "until the horizon"
            self.truth = reference.find(self.experiment, self._methods, budget, self.until())
        else:
            self.measure = "restart"
            others = other_family(best, self._methods)
            self.truth = restarts.windows(self.experiment, choice, others, self.chaos, self._seed, budget)
            for series in self._series:
                series.choices = [
                    replace(choice, steps=restarts.multiple(choice.steps, self.truth.parts))
                    for choice in series.choices
                ]

    def _twin(self, choice: Choice) -> tuple[Choice, Chaos]:
        """Run a perturbed copy at steps that do not diverge, and return these steps too. The limit may fall while the
        scene moves.
        """
        return halved(lambda each: twin(self.experiment, each, self._seed), choice)

    def _run(self, series: StepSizeSeries) -> None:
        choice = series.next()
        assert choice is not None
        if series.choices:
            series.choices.pop(0)
        series.measurements.append(self._try(choice))

    def _try(self, choice: Choice) -> Measurement:
        """Run a choice once, and measure its error."""
        begin = clock.seconds()
        trial = self.experiment.attempt(choice)
        cost = clock.seconds() - begin
        measurement = Measurement(
            choice, math.inf, trial.energy_drift, trial.evaluations, "diverged", trial.seconds, cost, 0.0
        )
        if trial.complete:
            measurement.status = "ok"
            if isinstance(self.truth, Reference):
                until = self.until()
                apart = self.experiment.distances(trial.samples[:until], self.truth.samples[:until])
                measurement.error = float(apart.max())
                way = self.experiment.distances(self.truth.samples, self.truth.samples[:1]).max()
                if measurement.error > WRONG * way + CERTAIN * self.truth.uncertainty:
                    measurement.status, measurement.error = "diverged", math.inf
                elif measurement.error > LOST * way + CERTAIN * self.truth.uncertainty:
                    measurement.status = "lost"
            else:
                self._compare_statistics(measurement, self.truth)
        measurement.judging = clock.seconds() - begin - cost
        self._tick()
        return measurement

    def _compare_statistics(self, measurement: Measurement, truth: Windows) -> None:
        """Measure the error over short windows, and the bias of averages over an ensemble."""
        measurement.error = restarts.error(self.experiment, measurement.choice, truth)
        try:
            found = restarts.ensemble(self.experiment, measurement.choice, truth.nudge, self._seed)
        except SimulationDiverged:
            measurement.status = "diverged"
            return
        measurement.bias = restarts.bias(found, truth.averages, truth.doubts)
        measurement.status = "biased" if measurement.bias.found else "ok"
        if abs(measurement.bias.relative) > WRONG:
            measurement.status, measurement.error = "diverged", math.inf

    def _left_behind(self, series: StepSizeSeries) -> bool:
        """Whether a series is long enough and its expected next row would be dominated by another row."""
        if len(series.measurements) < ENOUGH:
            return False
        before, last = series.measurements[-2:]
        return self._beaten(last.error * last.error / before.error if before.error > 0.0 else 0.0, 2.0 * last.cost)

    def _beaten(self, error: float, cost: float) -> bool:
        """Whether some row has both a smaller error and a lower cost."""
        measurements = (
            measurement for series in self._series for measurement in series.measurements if measurement.status == "ok"
        )
        return any(measurement.error <= error and measurement.cost <= cost for measurement in measurements)

    def _timing(self) -> float:
        """The expected duration of timing all rows so far [s]."""
        return REPEATS * sum(
            measurement.runs * measurement.cost for series in self._series for measurement in series.measurements
        )

    def _refine(self, budget: Budget) -> None:
        """Run held-out rows halfway between two rows of a series, at the widest gaps of the front, with the remaining
        budget; at least one.
        """
        parts = self.truth.parts if isinstance(self.truth, Windows) else 1
        for _ in range(HELD_OUT):
            gaps = [
                (not self._beaten(*series.between(index)), series.gap(index), position, index)
                for position, series in enumerate(self._series)
                for index in range(len(series.measurements) - 1)
                if series.has_room(index, parts, self.truth.uncertainty)
            ]
            if not gaps:
                return
            on_front, _, position, index = max(gaps)
            series = self._series[position]
            coarse, fine = series.measurements[index : index + 2]
            held_out = any(measurement.held_out for series in self._series for measurement in series.measurements)
            dear = not on_front or (1 + REPEATS) * fine.cost > budget.left() - self._timing()
            if held_out and dear:
                return
            middle = round(math.sqrt(coarse.choice.steps * fine.choice.steps) / parts) * parts
            measurement = self._try(replace(coarse.choice, steps=middle))
            measurement.held_out = True
            series.measurements.insert(index + 1, measurement)
