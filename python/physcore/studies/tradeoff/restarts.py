"""Where trajectories are lost: the error over short windows from points of a reference, and the bias of averages."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from physcore.arithmetic import log
from physcore.checks import FloatArray
from physcore.errors import SceneError, SimulationDiverged
from physcore.studies.state import State, motion, nudge, place, restore, state
from physcore.studies.tradeoff.budget import Budget
from physcore.studies.tradeoff.chaos import Chaos
from physcore.studies.tradeoff.experiment import SAMPLES, Choice, Experiment
from physcore.studies.tradeoff.methods import Method, halved
from physcore.studies.tradeoff.reference import AGREEMENT, START

WINDOW_GROWTH = 100.0
"""By how much errors may grow within a window."""
MEMBERS = 8
"""Runs in an ensemble."""
SCATTER = 1e-6
"""The nudge of the members of an ensemble, as a fraction of their largest speed: forgotten at the horizon."""
QUANTILE = 4.71
"""Student's t with 14 degrees of freedom, two-sided at 0.1 % shared among three averages."""
NEGLIGIBLE = 0.01
"""A bias below this fraction of an average is not held against anybody."""
AVERAGES = ("kinetic energy", "potential energy", "radius")


@dataclass(frozen=True, eq=False)
class Windows:
    """Short runs of a reference, each from where its long run was at the start of an interval."""

    starts: list[State]
    """The states where they begin."""
    ends: FloatArray
    """What is observed at the end of each window."""
    parts: int
    """A window is the first of this many equal parts of an interval."""
    choice: Choice
    """How the reference was computed."""
    uncertainty: float
    """How far its windows may be from the truth [m], or in the unit of what is observed."""
    agrees: bool
    """Whether windows of a method of another family are where their uncertainties let them be, if there is one."""
    nudge: float
    """How far apart the members of an ensemble start [m/s]."""
    averages: FloatArray
    """Of each member of its ensemble, shape (8, 3)."""
    doubts: FloatArray
    """How far these may be off: what halving the time step has changed in their means, shape (3,)."""


@dataclass(frozen=True)
class Bias:
    """The average that is furthest off."""

    quantity: str
    """What was averaged over the second half of the run and over an ensemble."""
    relative: float
    """The difference from the reference's average, as a fraction of that."""
    interval: float
    """Half of its confidence interval of 99.9 %, as a fraction of the same."""

    @property
    def found(self) -> bool:
        """Whether it is real and worth speaking of."""
        return abs(self.relative) - self.interval > NEGLIGIBLE


def windows(
    experiment: Experiment,
    choice: Choice,
    others: list[Method],
    chaos: Chaos,
    seed: int,
    budget: Budget,
) -> Windows:
    """A long run of a choice for the starts, and from each of them windows at ever finer steps as far as the budget
    reaches; the best of the other methods checks them.
    """
    growth = chaos.exponent * experiment.interval / float(log(WINDOW_GROWTH))
    parts = 1 << (math.ceil(growth) - 1).bit_length() if growth > 1.0 else 1
    choice = replace(choice, steps=multiple(choice.steps, parts))
    simulation = experiment.start(choice)
    starts, fastest = [], 0.0
    for _ in range(SAMPLES):
        starts.append(state(simulation))
        fastest = max(fastest, float(np.abs(motion(simulation)).max()))
        simulation.step(choice.steps)
    scatter = SCATTER * fastest
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
    experiment: Experiment, choice: Choice, nudge: float, seed: int, budget: Budget
) -> tuple[FloatArray, FloatArray]:
    """The averages of ensembles with ever finer steps, until the means stay, or the budget ends; and what remains."""
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
    """The ends of all windows, with the steps that changed them least when halved, and by how much they did."""
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
    """The largest distance from the reference at the end of any window; infinite where one diverges."""
    try:
        ends = _ends(experiment, choice, reference.starts, reference.parts)
    except SimulationDiverged:
        return math.inf
    return float(experiment.distances(ends, reference.ends).max())


def ensemble(experiment: Experiment, choice: Choice, nudge: float, seed: int) -> FloatArray:
    """Averages over the second half of the duration, of members that start a little apart; shape (8, 3).

    Raises:
        SimulationDiverged: one of them did.
    """
    return np.array([_averages(experiment, choice, nudge, seed + member) for member in range(MEMBERS)])


def bias(found: FloatArray, reference: FloatArray, doubts: FloatArray) -> Bias:
    """Welch's comparison of two ensembles, average by average; the worst of them. Doubts widen the intervals.

    Source: B. L. Welch, Biometrika 34, 28 (1947).
    """
    scale = np.abs(reference.mean(axis=0)) + np.finfo(float).tiny
    difference = (found.mean(axis=0) - reference.mean(axis=0)) / scale
    spread = QUANTILE * np.sqrt((found.var(axis=0, ddof=1) + reference.var(axis=0, ddof=1)) / MEMBERS)
    spread = (spread + doubts) / scale
    worst = int(np.argmax(np.abs(difference) - spread))
    return Bias(AVERAGES[worst], float(difference[worst]), float(spread[worst]))


def _averages(experiment: Experiment, choice: Choice, size: float, seed: int) -> FloatArray:
    """Kinetic energy, potential energy above that at the start, and the root mean square distance from the middle; of a
    field, from its mean.
    """
    simulation = experiment.start(choice)
    nudge(simulation, size, seed)
    begin = simulation.energy()
    sums = np.zeros(len(AVERAGES))
    for sample in range(SAMPLES):
        simulation.step(choice.steps)
        if sample < SAMPLES // 2:
            continue
        energy, places = simulation.energy(), place(simulation).reshape(-1, *_vector(experiment))
        radius = float(np.sqrt(np.mean(np.square(places - places.mean(axis=0)).sum(axis=1))))
        sums += energy.kinetic, energy.potential + energy.internal - begin.potential - begin.internal, radius
    return sums / (SAMPLES - SAMPLES // 2)


def _ends(experiment: Experiment, choice: Choice, starts: list[State], parts: int) -> FloatArray:
    """What is observed at the end of the window from each start. The clock goes on as in a long run."""
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


def _vector(experiment: Experiment) -> tuple[int]:
    """The number of components of what is compared."""
    return (experiment.scene.dimension if experiment.scene.bodies else 1,)
