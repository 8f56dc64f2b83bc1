"""Detection of chaos: the growth of a small perturbation, and the time until which trajectories are meaningful."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from physcore.arithmetic import log
from physcore.checks import FloatArray
from physcore.simulation.simulation import Simulation
from physcore.studies.state import compared, nudge
from physcore.studies.tradeoff.experiment import SAMPLES, Choice, Experiment

NUDGE = 1e-10
"""Perturbation of the velocities, relative to the largest speed of the run."""
LOST = 1e5
"""Growth after which a trajectory is lost: an error of 1e-5 of the motion is then as large as the motion."""
FAR = 1e-3
"""Distance in phase space, relative to the motion, above which the growth saturates."""
STEEPEST = 3.0
"""Largest power of time in the growth of regular motion. Shear between orbits gives the first power, and a force that
grows with the distance the second; one more is a margin. The growth eˡᵗ of chaotic motion has the power λt at time t.
"""


@dataclass(frozen=True, eq=False)
class Chaos:
    """Result of a perturbed run."""

    times: FloatArray
    """Times [s], shape (33,) at most."""
    growth: FloatArray
    """Growth: the largest distance in phase space so far over the initial one, at each time."""
    chaotic: bool
    """Whether the growth is exponential, and large enough for trajectories to be lost within the duration."""
    exponent: float
    """Largest Lyapunov exponent over these times [1/s] for chaotic motion; otherwise 0."""
    horizon: float
    """Time until which trajectories can be compared [s]; inf for regular motion."""


def twin(experiment: Experiment, choice: Choice, seed: int) -> Chaos:
    """Run a scene and a perturbed copy, and measure how they separate.

    The distance in phase space is √(mean |Δx|²/L² + mean |Δv|²/V²), with the largest displacement L and the largest
    speed V of the run. With an observer, only the observed values count. The growth is the largest distance so far,
    which does not oscillate with the motion. Each item has a distance of its own; the item with the shortest horizon
    counts.

    Source: G. Benettin, L. Galgani, J.-M. Strelcyn, Phys. Rev. A 14, 2338 (1976), for two nearby orbits; C. Froeschlé,
    E. Lega, R. Gonczi, Celest. Mech. Dyn. Astron. 67, 41 (1997), for the distinction of exponential and power-law
    growth.
    """
    first, other = experiment.start(choice), experiment.start(choice)
    states = list(_states(experiment, first, choice))
    speeds = [max(float(np.abs(state[item][0]).max()) for state in states) or 1.0 for item in range(len(states[0]))]
    nudge(other, [NUDGE * speed for speed in speeds], seed)
    twins = list(_states(experiment, other, choice))
    found = []
    for item, (own, difference) in enumerate(_compared(experiment, speeds)):
        pairs = [(state[item], twin[item]) for state, twin in zip(states, twins, strict=True)]
        found.append(_growth(experiment, pairs, own, difference))
    return min(found, key=lambda chaos: (chaos.horizon, -float(chaos.growth[-1])))


_State = tuple[FloatArray, FloatArray]
"""The rate of change of an item, and its compared values."""
_Difference = Callable[[FloatArray, FloatArray], FloatArray]


def _compared(experiment: Experiment, speeds: list[float]) -> list[tuple[float | None, _Difference]]:
    """For each item its largest speed, None for observed values, and the difference of compared values."""
    if experiment.observer is not None:
        return [(None, experiment.difference)]
    primaries = compared(experiment.scene)
    return [(speed, each.difference) for speed, each in zip(speeds, primaries, strict=True)]


def _growth(
    experiment: Experiment, pairs: list[tuple[_State, _State]], speed: float | None, difference: _Difference
) -> Chaos:
    """The growth of the distance between two runs of an item, from pairs of states at the same times."""
    first = pairs[0][0]
    scales = [max(float(np.abs(state[part] - first[part]).max()) for state, _ in pairs) for part in (0, 1)]
    parts = [(1, scales[1])] if speed is None else [(0, max(speed, scales[0])), (1, scales[1])]
    distances = [
        math.sqrt(
            sum(
                _mean_square(state[part], twin[part], difference if part == 1 else np.subtract) / (scale * scale)
                for part, scale in parts
                if scale
            )
        )
        for state, twin in pairs
    ]
    # An observer may not show the perturbation initially, so its size is the initial distance.
    start = NUDGE if speed is None else distances[0]
    growth: FloatArray = np.maximum.accumulate(np.array(distances) / start) if start > 0.0 else np.ones(len(pairs))
    times: FloatArray = experiment.interval * np.arange(len(growth), dtype=np.float64)
    return judge(times, growth, FAR / max(start, NUDGE * NUDGE))


def judge(times: FloatArray, growth: FloatArray, saturated: float) -> Chaos:
    """Classify the growth as exponential or as a power of time; `saturated` is the growth at which it saturates."""
    lost = np.flatnonzero(growth > LOST)
    near = np.flatnonzero(growth < saturated)
    last = int(near[-1]) if len(near) else 0
    regular = Chaos(times, growth, False, 0.0, math.inf)
    if len(lost) == 0:
        return regular
    # The power in the last octave before saturation. Saturation within two intervals counts as exponential.
    half = last // 2
    octave = float(log(growth[last] / growth[half]) / log(2.0)) if half > 0 else math.inf
    if octave <= STEEPEST:
        return regular
    ends = slice(last // 4, last + 1) if last > 1 else slice(0, int(lost[0]) + 1)
    exponent = _slope(times[ends], log(growth[ends]))
    return Chaos(times, growth, True, exponent, float(times[int(lost[0]) - 1]))


def _slope(x: FloatArray, y: FloatArray) -> float:
    """The slope of the least-squares line."""
    from_mean = x - x.mean()
    return float((from_mean * y).sum() / (from_mean * from_mean).sum())


def _states(experiment: Experiment, simulation: Simulation, choice: Choice) -> Iterator[list[_State]]:
    """The states of all items, or of the observed values, at the start and the end of each interval."""
    yield _present(experiment, simulation)
    for _ in range(SAMPLES):
        simulation.step(choice.steps)
        yield _present(experiment, simulation)


def _present(experiment: Experiment, simulation: Simulation) -> list[_State]:
    """The present states. Observed values belong to the first item."""
    primaries = compared(experiment.scene)
    states = [(each.rates(simulation), each.values(simulation)) for each in primaries]
    if experiment.observer is None:
        return states
    observed = experiment.observe(simulation)
    return [(rates, observed) for rates, _ in states]


def _mean_square(one: FloatArray, other: FloatArray, difference: _Difference) -> float:
    change = difference(one[np.newaxis], other[np.newaxis])
    return float(np.mean(change.real * change.real + change.imag * change.imag))
