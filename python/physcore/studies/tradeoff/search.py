"""The search for the Pareto front: series of time steps, from the limit of stability downward, within a budget."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from physcore.errors import PhyscoreError, SceneError, SimulationDiverged
from physcore.numerics.fluids import FluidMethod
from physcore.numerics.integrators import Integrator
from physcore.studies import clock
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
"""How much of the budget the reference may take."""
ENOUGH = 8
"""Rows after which a series goes on only where the next one may get onto the Pareto front."""
HELD_OUT = 8
"""Rows between two others that are predicted before they are run, at most."""
WRONG = 10.0
"""An error of this many times the largest way in the reference, or an average off by this many times itself, is a
blow-up, whatever the watch says."""


class WorkPrecisionDiagram:
    """Measures one scene; `find` looks for the rows, `time` how long each of them takes, `rows` gives them."""

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
        """Who cannot compute the scene, by the reason."""
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
        """Look for chaos and for a reference, and run every series as far as the budget reaches.

        Raises:
            PhyscoreError: no choice can compute the scene, or every run of the reference diverged.
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
        """Run everything again, five times, each time in another order, and take the times.

        Whole runs in one call, from a simulation that is built anew and not timed; the run that found the error has
        warmed everything up. Runs that are too short for a clock are timed several in a row.
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
        """What was left out, and why."""
        return [f"Left out: {', '.join(names)} ({reason})." for reason, names in self.refused.items()]

    def until(self) -> int:
        """How many of the samples can be compared."""
        return max(2, int(np.sum(self.chaos.times <= self.chaos.horizon)))

    def rows(
        self, resolution: float | None = None, discretization_error: float = 0.0, fluids: FluidMethod | None = None
    ) -> list[Row]:
        """What was found; `time` comes first."""
        return [
            Row(
                integrator=series.integrator,
                label=self._labels[series.integrator],
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
                prediction=series.prediction(measurement) if measurement.held_out else None,
            )
            for series in self._series
            for measurement in series.measurements
        ]

    def _time_once(self, choice: Choice) -> float:
        """How long a whole run takes [s], or until it diverges."""
        simulation = self.experiment.start(choice)
        begin = clock.seconds()
        with contextlib.suppress(SimulationDiverged):
            simulation.run(self.experiment.duration)
        return clock.seconds() - begin

    def _new_series(
        self, integrator: Integrator, precision: Literal["f32", "f64"], dts: Sequence[float] | None
    ) -> StepSizeSeries | None:
        """A series that begins at its limit, or has the steps that were asked for."""
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
        return StepSizeSeries(integrator, precision, plan.pairs, plan.memory, choices, open_ended=dts is None)

    def _judge(self, budget: Budget) -> None:
        """Find out whether trajectories can be compared, and what with."""
        best = self._methods[0]
        steps = self.experiment.steps_of(reference.START * best.accurate)
        choice, self.chaos = self._twin(Choice(best.integrator, "f64", steps))
        if not self.chaos.chaotic:
            self.truth = reference.find(self.experiment, self._methods, budget)
        elif self.experiment.scene.fluids or self.experiment.observer is not None:
            # The state of a fluid is more than places and velocities, and an observer may look at the past.
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
        """Run the twin with steps that hold, and give those too: the limit may fall while the scene moves."""
        return halved(lambda each: twin(self.experiment, each, self._seed), choice)

    def _run(self, series: StepSizeSeries) -> None:
        choice = series.next()
        assert choice is not None
        if series.choices:
            series.choices.pop(0)
        series.measurements.append(self._try(choice))

    def _try(self, choice: Choice) -> Measurement:
        """Run a choice once, and judge it."""
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
            else:
                self._compare_statistics(measurement, self.truth)
        measurement.judging = clock.seconds() - begin - cost
        self._tick()
        return measurement

    def _compare_statistics(self, measurement: Measurement, truth: Windows) -> None:
        """The error over short windows, and the averages over an ensemble."""
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
        """Whether a series has shown its slope, and what it would reach next is had for less elsewhere."""
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
        """What the timing of all rows so far will take [s]."""
        return REPEATS * sum(
            measurement.runs * measurement.cost for series in self._series for measurement in series.measurements
        )

    def _refine(self, budget: Budget) -> None:
        """Spend what is left halfway between two rows of a series, where the front has its widest gap; one at least."""
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
