"""Comparison of chaotic runs: errors over short windows that start on a reference, and the bias of averages."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from physcore.arithmetic import log
from physcore.checks import FloatArray
from physcore.errors import SceneError, SimulationDiverged
from physcore.simulation.simulation import Simulation
from physcore.studies.primary import Primary
from physcore.studies.state import State, compared, nudge, restore, state
from physcore.studies.tradeoff.budget import Budget
from physcore.studies.tradeoff.chaos import Chaos
from physcore.studies.tradeoff.experiment import SAMPLES, Choice, Experiment
from physcore.studies.tradeoff.methods import Method, halved
from physcore.studies.tradeoff.reference import AGREEMENT, START

WINDOW_GROWTH = 100.0
"""Largest growth of errors within a window."""
MEMBERS = 8
"""Number of runs in an ensemble."""
SCATTER = 1e-6
"""Perturbation of the members of an ensemble, relative to their largest speed; forgotten at the horizon."""
QUANTILE = 4.71
"""Quantile of Student's t with 14 degrees of freedom, two-sided at 0.1 %, shared among three averages."""
NEGLIGIBLE = 0.01
"""Largest negligible bias, as a fraction of the average."""
AVERAGES = ("kinetic energy", "potential energy", "radius")


@dataclass(frozen=True, eq=False)
class Windows:
    """Short runs of a reference, each from its state at the start of an interval."""

    starts: list[State]
    """Initial states of the windows."""
    ends: FloatArray
    """Observed values at the end of each window."""
    parts: int
    """A window is the first of this many equal parts of an interval."""
    choice: Choice
    """Numerics of the reference."""
    uncertainty: float
    """Bound on the error of the windows [m], or in the unit of the observed values."""
    agrees: bool
    """Whether the windows of a method of another family, if there is one, agree within the uncertainties."""
    nudge: tuple[float, ...]
    """Perturbation of the rates of each item in the members of an ensemble, such as [m/s] of particles."""
    averages: FloatArray
    """Averages of each member of the ensemble, shape (8, 3)."""
    doubts: FloatArray
    """Uncertainty of the means of these averages, shape (3,): their changes after a halving of the time step."""


@dataclass(frozen=True)
class Bias:
    """The most biased average."""

    quantity: str
    """Name of the quantity, averaged over the second half of the run and over an ensemble."""
    relative: float
    """Difference from the reference's average, relative to that average."""
    interval: float
    """Half-width of its 99.9 % confidence interval, likewise relative."""

    @property
    def found(self) -> bool:
        """Whether the bias is significant and not negligible."""
        return abs(self.relative) - self.interval > NEGLIGIBLE


def windows(
    experiment: Experiment,
    choice: Choice,
    others: list[Method],
    chaos: Chaos,
    seed: int,
    budget: Budget,
) -> Windows:
    """Compute the windows of a choice, whose states come from a long run.

    The steps of the windows are reduced as far as the budget allows. The best of the other methods is the check.
    """
    growth = chaos.exponent * experiment.interval / float(log(WINDOW_GROWTH))
    parts = 1 << (math.ceil(growth) - 1).bit_length() if growth > 1.0 else 1
    choice = replace(choice, steps=multiple(choice.steps, parts))
    simulation = experiment.start(choice)
    primaries = compared(experiment.scene)
    starts, fastest = [], [0.0] * len(primaries)
    for _ in range(SAMPLES):
        starts.append(state(simulation))
        own = [float(np.abs(each.rates(simulation)).max()) for each in primaries]
        fastest = list(map(max, fastest, own))
        simulation.step(choice.steps)
    scatter = tuple(SCATTER * speed for speed in fastest)
    averages, doubts = _settle(experiment, choice, scatter, seed, budget.share(0.4))
    choice, ends, uncertainty = _converge(experiment, choice, starts, parts, budget.share(0.5 if others else 1.0))
    agrees = True
    if others:
        steps = experiment.steps_of(START * others[0].accurate)
        other = Choice(others[0].integrator, "f64", multiple(steps, parts))
        _, check, doubt = _converge(experiment, other, starts, parts, budget)
        apart = float(experiment.distances(check, ends).max())
        agrees = apart <= AGREEMENT * (uncertainty + doubt)
        uncertainty = uncertainty if agrees else apart
    return Windows(starts, ends, parts, choice, uncertainty, agrees, scatter, averages, doubts)


def _settle(
    experiment: Experiment, choice: Choice, nudge: tuple[float, ...], seed: int, budget: Budget
) -> tuple[FloatArray, FloatArray]:
    """Averages of ensembles with decreasing steps, until the means are stable or the budget is spent; and their
    remaining changes.
    """
    averages = ensemble(experiment, choice, nudge, seed)
    while True:
        choice, before = choice.finer(), budget.left()
        finer = ensemble(experiment, choice, nudge, seed)
        changes: FloatArray = np.abs(finer.mean(axis=0) - averages.mean(axis=0))
        moved = bias(finer, averages, np.zeros_like(changes)).found
        averages = finer
        if not moved or 2.0 * (before - budget.left()) > budget.left():
            return averages, changes if moved else np.zeros_like(changes)


def _converge(
    experiment: Experiment, choice: Choice, starts: list[State], parts: int, budget: Budget
) -> tuple[Choice, FloatArray, float]:
    """The ends of all windows at the steps whose halving changed them least, and the amount of that change."""
    choice, ends = halved(lambda each: _ends(experiment, each, starts, parts), choice)
    uncertainty = math.inf
    while True:
        finer, before = choice.finer(), budget.left()
        better = _ends(experiment, finer, starts, parts)
        change = float(experiment.distances(better, ends).max())
        improved = change < 0.5 * uncertainty
        if change <= uncertainty:
            choice, ends, uncertainty = finer, better, change
        if not improved or 2.0 * (before - budget.left()) > budget.left():
            return choice, ends, max(uncertainty, float(np.spacing(np.abs(ends).max())))


def multiple(steps: int, parts: int) -> int:
    """The least multiple of `parts` that is not below `steps`."""
    return -(-steps // parts) * parts


def error(experiment: Experiment, choice: Choice, reference: Windows) -> float:
    """The largest distance from the reference at the end of any window; inf if one diverges."""
    try:
        ends = _ends(experiment, choice, reference.starts, reference.parts)
    except SimulationDiverged:
        return math.inf
    return float(experiment.distances(ends, reference.ends).max())


def ensemble(experiment: Experiment, choice: Choice, nudge: tuple[float, ...], seed: int) -> FloatArray:
    """Averages over the second half of the duration, of slightly perturbed members; shape (8, 3).

    Raises:
        SimulationDiverged: a member diverged.
    """
    return np.array([_averages(experiment, choice, nudge, seed + member) for member in range(MEMBERS)])


def bias(found: FloatArray, reference: FloatArray, doubts: FloatArray) -> Bias:
    """The worst bias in a Welch comparison of two ensembles, for each average. `doubts` widen the confidence intervals.

    Source: B. L. Welch, Biometrika 34, 28 (1947).
    """
    scale = np.abs(reference.mean(axis=0)) + np.finfo(float).tiny
    difference = (found.mean(axis=0) - reference.mean(axis=0)) / scale
    spread = QUANTILE * np.sqrt((found.var(axis=0, ddof=1) + reference.var(axis=0, ddof=1)) / MEMBERS)
    spread = (spread + doubts) / scale
    worst = int(np.argmax(np.abs(difference) - spread))
    return Bias(AVERAGES[worst], float(difference[worst]), float(spread[worst]))


def _averages(experiment: Experiment, choice: Choice, sizes: tuple[float, ...], seed: int) -> FloatArray:
    """Kinetic energy, potential energy relative to the start, and rms distance from the middle; for a field, rms
    deviation from its mean; for several items, the rms of theirs, each scaled as errors are.
    """
    simulation = experiment.start(choice)
    nudge(simulation, sizes, seed)
    begin = simulation.energy()
    sums = np.zeros(len(AVERAGES))
    for sample in range(SAMPLES):
        simulation.step(choice.steps)
        if sample < SAMPLES // 2:
            continue
        energy = simulation.energy()
        squares = [_spread(each, simulation) for each in compared(experiment.scene)]
        radius = float(np.sqrt(np.mean(experiment.comparison.weighed(squares, 2))))
        sums += energy.kinetic, energy.potential + energy.internal - begin.potential - begin.internal, radius
    return sums / (SAMPLES - SAMPLES // 2)


def _ends(experiment: Experiment, choice: Choice, starts: list[State], parts: int) -> FloatArray:
    """The observed values at the end of the window from each start. The clock continues as in a long run."""
    if choice.steps % parts:
        raise SceneError(f"steps: must be a multiple of {parts}, got {choice.steps}")
    simulation = experiment.start(choice)
    ends = []
    for start in starts:
        restore(simulation, start)
        simulation.step(choice.steps // parts)
        ends.append(experiment.observe(simulation))
        simulation.step(choice.steps - choice.steps // parts)
    return np.stack(ends)


def _spread(primary: Primary, simulation: Simulation) -> float:
    """The mean square distance from the middle, or of values from their mean."""
    places = primary.values(simulation).reshape(-1, primary.components)
    return float(np.mean(np.square(places - places.mean(axis=0)).sum(axis=1)))
