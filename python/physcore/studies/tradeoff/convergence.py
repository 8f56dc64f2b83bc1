"""Convergence: orders and errors from runs that differ only in their time step.

This estimator is used by `accuracy=` and `tradeoff`. The error of a method of order p is e(h) = C hᵖ + O(hᵖ⁺¹). The
difference d of two runs with the steps h and h/r thus gives both errors: C hᵖ = d/(1 − r⁻ᵖ), and this value over rᵖ.
The differences of three runs show whether the steps are small enough for this law.

Source: L. F. Richardson, Phil. Trans. R. Soc. A 226, 299 (1927); E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary
Differential Equations I", 2nd ed. 1993, § II.4, and § II.6 for discontinuities.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from physcore.arithmetic import log, power

AGREEMENT = 0.5
"""Largest deviation of the measured order from the order of the method at which the latter is accepted."""
NEXT = 2.0
"""Order of the next term above that of the method, which may dominate: symmetric methods have only even terms."""
SAFETY_FACTOR = 2.0
"""Safety factor of an error that is extrapolated by the order of the method."""
MEMORY = 3
"""Number of differences that are used if the order is not that of the method."""
FLAT = 0.7
"""Least mean reduction of a value per halving of the step. At order one it would be 0.5."""
SMALL = 1e-3
"""Bound of small values, as a fraction of the scale."""
STUCK = 6
"""Number of runs for the test of stagnation; for small values, which rounding may dominate, two."""


@dataclass(frozen=True)
class Convergence:
    """Results of two or three runs with decreasing steps, about the last two."""

    order: float
    """Order q measured from three runs; NaN for two runs, or if differences vanish."""
    asymptotic: bool
    """Whether q is the order of the method, so that errors follow it and extrapolation is valid."""
    coarser: float
    """Bound on the error of the second-last run, proven by the last one."""
    finer: float
    """Bound on the error of the last run, by the order of the method if measured, otherwise by order one."""
    expected: float
    """The error expected for the last run, if the measured order turns out to be that of the method."""


def convergence(
    steps: Sequence[int], differences: Sequence[float], order: int, certain: int | None = None
) -> Convergence:
    """Estimate the errors of runs with increasing numbers of steps, from the differences between successive runs.

    Once the order of the method was measured, the motion counts as smooth: a term of lower order that is too small to
    change the measured order is not seen.

    An order that was not measured is assumed to be at least one, over no more than a halving of the step. With a
    difference d, the error of the coarser run is then at most 2d, and that of the finer run at most d. Because d may be
    small by chance, earlier differences are used too, reduced as for order one, if they are larger. For the coarser run
    they are not used if d has decreased according to the order of the method. If d has decreased faster, by up to two
    orders, the finer run has at most the error that follows from the difference before and the order of the method.
    Impacts reduce the order to one, with a factor that depends on their position within a step. Then four runs are
    required, and the bounds are twice as large.

    Args:
        steps: numbers of steps of all runs, two or more.
        differences: differences between successive runs, one fewer.
        order: order p of the method.
        certain: the guaranteed order for motion that is not smooth: one with impacts; None: smooth motion.
    """
    ratio, change = min(steps[-1] / steps[-2], 2.0), differences[-1]
    expected = min(SAFETY_FACTOR * change / (float(power(ratio, certain or order)) - 1.0), change / (ratio - 1.0))
    measured, asymptotic, regular, faster = math.nan, False, len(steps) < 3, math.inf
    if len(steps) > 2 and min(differences[-2:]) > 0.0:
        shrunk = _log2(differences[-2] / change)
        measured = shrunk / _log2(steps[-2] / steps[-3])
        surplus = shrunk + _log2(_shrinkage(steps[-3:-1], steps[-2:], order))
        asymptotic, regular = abs(surplus) < AGREEMENT, -AGREEMENT < surplus < NEXT + AGREEMENT
        if regular and certain is None:
            # What the order of the method alone would have made of the difference before, which is larger.
            slower = differences[-2] * _shrinkage(steps[-3:-1], steps[-2:], order)
            faster = SAFETY_FACTOR * max(slower, change) / (float(power(ratio, order)) - 1.0)
    envelope = max(
        earlier * _shrinkage(steps[at : at + 2], steps[-2:], 1)
        for at, earlier in enumerate(differences)
        if at >= len(differences) - MEMORY
    )
    if certain == 1:
        envelope *= SAFETY_FACTOR if len(differences) >= MEMORY else math.inf
        asymptotic = regular = False
    coarser = (change if regular else envelope) * ratio / (ratio - 1.0)
    finer = expected if asymptotic else min(envelope / (ratio - 1.0), faster)
    return Convergence(measured, asymptotic, coarser, finer, expected)


def _shrinkage(before: Sequence[int], after: Sequence[int], order: int) -> float:
    """Ratio of the difference between two runs to that between two others, for errors C hᵖ."""
    first, second, third, fourth = power((*before, *after), -order).tolist()
    shrinkage: float = (third - fourth) / (first - second)
    return shrinkage


def _log2(x: float) -> float:
    return float(log(x) / log(2.0))


def order_between(steps: Sequence[int], values: Sequence[float], order: int) -> float:
    """The observed order of the last two values, from 1 to the order of the method; the latter for a single value."""
    if len(values) < 2 or not values[-2] > values[-1] > 0.0:
        return float(order) if len(values) < 2 else 1.0
    seen = float(log(values[-2] / values[-1]) / log(steps[-1] / steps[-2]))
    return min(max(seen, 1.0), float(order))


def errors_of(steps: Sequence[int], differences: Sequence[float]) -> list[float]:
    """The errors of all runs but the first, from the differences between successive runs, as for order one."""
    ratios = [min(after / before, 2.0) for before, after in pairwise(steps)]
    return [difference / (ratio - 1.0) for difference, ratio in zip(differences, ratios, strict=True)]


def stagnant(values: Sequence[float], scale: float, steps: Sequence[int] = ()) -> bool:
    """Whether smaller steps no longer reduce a value, because of rounding or a lack of convergence.

    Args:
        values: errors, in the order of decreasing steps.
        scale: the scale by which values are small or large.
        steps: numbers of steps of the same runs; by default each has twice as many as the one before.
    """
    small = bool(values) and values[-1] < SMALL * scale
    runs = 2 if small else STUCK
    if len(values) <= runs:
        return False
    # Values that are not small can be small by chance in single runs, so the maximum is used.
    halvings = _log2(steps[-1] / steps[-1 - runs]) if steps else float(runs)
    return values[-1] > float(power(FLAT, halvings)) * (values[-1 - runs] if small else max(values[:-runs]))
