"""Chaos: how fast a twin that starts next to a run leaves it, and until when a trajectory means anything."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from physcore.arithmetic import log
from physcore.checks import FloatArray
from physcore.simulation.simulation import Simulation
from physcore.studies.state import motion, nudge
from physcore.studies.tradeoff.experiment import SAMPLES, Choice, Experiment

NUDGE = 1e-10
"""How much faster or slower the twin starts, as a fraction of the largest speed of the run."""
LOST = 1e5
"""The growth after which a trajectory is lost: an error of 1e-5 of the motion is then as large as the motion."""
FAR = 1e-3
"""The distance in phase space, as a fraction of the motion, beyond which twins do not grow apart as fast any more."""
STEEPEST = 3.0
"""The power of time with which a regular twin leaves at most: with the first for shear between orbits, the second where
a force grows with the way, and one to spare. A chaotic one leaves with eˡᵗ, whose power at time t is λt."""


@dataclass(frozen=True, eq=False)
class Chaos:
    """What a twin run found."""

    times: FloatArray
    """[s], shape (33,) at most."""
    growth: FloatArray
    """The largest distance in phase space so far over that at the start, at each time."""
    chaotic: bool
    """Whether the twin left exponentially and far enough for trajectories to be lost within the duration."""
    exponent: float
    """The largest Lyapunov exponent over these times [1/s], where chaotic; else 0."""
    horizon: float
    """Until when a trajectory can be compared [s]; inf where not chaotic."""


def twin(experiment: Experiment, choice: Choice, seed: int) -> Chaos:
    """Run a scene and its twin side by side, and look at how they part.

    Distances are taken in phase space, √(mean |Δx|²/L² + mean |Δv|²/V²), with the largest way L and the largest speed V
    of the run; where only something is observed, in that alone. The largest so far is what counts, for it does not
    swing with the motion.

    Source: G. Benettin, L. Galgani, J.-M. Strelcyn, Phys. Rev. A 14, 2338 (1976), for two nearby orbits; C. Froeschlé,
    E. Lega, R. Gonczi, Celest. Mech. Dyn. Astron. 67, 41 (1997), for telling exponentials from powers of time.
    """
    first, other = experiment.start(choice), experiment.start(choice)
    states = list(_states(experiment, first, choice))
    speed = max(float(np.abs(velocities).max()) for velocities, _ in states) or 1.0
    nudge(other, NUDGE * speed, seed)
    scales = [max(float(np.abs(state[part] - states[0][part]).max()) for state in states) for part in (0, 1)]
    parts = [(0, max(speed, scales[0])), (1, scales[1])] if experiment.observer is None else [(1, scales[1])]
    distances = [
        math.sqrt(
            sum(
                _mean_square(state[part], twin[part], experiment, part) / (scale * scale)
                for part, scale in parts
                if scale
            )
        )
        for state, twin in zip(states, _states(experiment, other, choice), strict=True)
    ]
    # An observer may see nothing of the nudge at the start, but it cannot see less than its size for ever.
    start = distances[0] if experiment.observer is None else NUDGE
    growth: FloatArray = np.maximum.accumulate(np.array(distances) / start) if start > 0.0 else np.ones(len(states))
    times: FloatArray = experiment.interval * np.arange(len(growth), dtype=np.float64)
    return judge(times, growth, FAR / max(start, NUDGE * NUDGE))


def judge(times: FloatArray, growth: FloatArray, saturated: float) -> Chaos:
    """Tell exponential growth from that with a power of time; `saturated` is where it ends."""
    lost = np.flatnonzero(growth > LOST)
    near = np.flatnonzero(growth < saturated)
    last = int(near[-1]) if len(near) else 0
    regular = Chaos(times, growth, False, 0.0, math.inf)
    if len(lost) == 0:
        return regular
    # Over the last octave before it is far away; no power of time gets there within two intervals.
    half = last // 2
    octave = float(log(growth[last] / growth[half]) / log(2.0)) if half > 0 else math.inf
    if octave <= STEEPEST:
        return regular
    ends = slice(last // 4, last + 1) if last > 1 else slice(0, int(lost[0]) + 1)
    exponent = _slope(times[ends], log(growth[ends]))
    return Chaos(times, growth, True, exponent, float(times[int(lost[0]) - 1]))


def _slope(x: FloatArray, y: FloatArray) -> float:
    """The slope of the line of least squares."""
    from_mean = x - x.mean()
    return float((from_mean * y).sum() / (from_mean * from_mean).sum())


def _states(experiment: Experiment, simulation: Simulation, choice: Choice) -> Iterator[tuple[FloatArray, FloatArray]]:
    """How the state moves and what is observed, at the start and the end of each interval."""
    yield motion(simulation), experiment.observe(simulation)
    for _ in range(SAMPLES):
        simulation.step(choice.steps)
        yield motion(simulation), experiment.observe(simulation)


def _mean_square(one: FloatArray, other: FloatArray, experiment: Experiment, part: int) -> float:
    change = experiment.difference(one[None], other[None]) if part == 1 else one - other
    return float(np.mean(change * change))
