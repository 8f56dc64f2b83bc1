"""Convergence: orders and errors from runs that differ in their time step alone.

The one estimator behind `accuracy=` and `tradeoff`. A method of order p is off by e(h) = C hᵖ + O(hᵖ⁺¹), so that the
difference d of two runs with the steps h and h/r tells both errors: C hᵖ = d/(1 − r⁻ᵖ), and that over rᵖ. Whether steps
are small enough for that, the differences of three runs tell: they shrink as they should, or they do not.

Source: L. F. Richardson, Phil. Trans. R. Soc. A 226, 299 (1927); E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary
Differential Equations I", 2nd ed. 1993, § II.4, and § II.6 for discontinuities.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from physcore.arithmetic import log, power

AGREEMENT = 0.5
"""How far the measured order may be from the order of the method for the latter to be believed."""
NEXT = 2.0
"""How far above it is the order of the next term, which may rule: those of symmetric methods are even."""
SAFETY_FACTOR = 2.0
"""Of an error that the order of the method gives, and not the difference of two runs alone."""
MEMORY = 3
"""How many differences are looked at where the order is not that of the method."""
FLAT = 0.7
"""By which factor a value shrinks at least, on average, in each run with half the step: at order one it would halve."""
SMALL = 1e-3
"""What is small, as a fraction of the scale."""
STUCK = 6
"""Over how many runs that is looked at; where the value is small, and rounding may rule, over two."""


@dataclass(frozen=True)
class Convergence:
    """What two or three runs with falling steps say of the last two."""

    order: float
    """The order q that was measured in three runs; not a number where there are two, or differences vanish."""
    asymptotic: bool
    """Whether that is the order of the method, so that errors follow it, and extrapolation is worth doing."""
    coarser: float
    """Bound on the error of the run before the last, as the last one proves it."""
    finer: float
    """Bound on the error of the last run: by the order of the method where that was measured, else by order one."""
    expected: float
    """What the latter will be once the order is measured, if it is that of the method."""


def convergence(
    steps: Sequence[int], differences: Sequence[float], order: int, certain: int | None = None
) -> Convergence:
    """Judge runs with rising numbers of steps by the differences between each and the one before.

    Of an order that was not measured no more is believed than that it is one at least, over no more than a halving:
    with a difference d the coarser run is off by 2d at most then, and the finer by d. As d may be small by chance,
    those before, as far as they would have shrunk at order one, count where they are larger; but not for the coarser
    run where d has shrunk as the order of the method asks. Impacts leave order one, with a factor that depends on where
    in a step they come: there it takes four runs, and the bounds are twice as large.

    Args:
        steps: of all runs, two or more.
        differences: between each two of them in turn, one fewer.
        order: of the method, p.
        certain: the order that is certain where the motion is not smooth: one with impacts; None: it is smooth.
    """
    ratio, change = min(steps[-1] / steps[-2], 2.0), differences[-1]
    expected = min(SAFETY_FACTOR * change / (float(power(ratio, certain or order)) - 1.0), change / (ratio - 1.0))
    measured, asymptotic, regular = math.nan, False, len(steps) < 3
    if len(steps) > 2 and min(differences[-2:]) > 0.0:
        shrunk = _log2(differences[-2] / change)
        measured = shrunk / _log2(steps[-2] / steps[-3])
        surplus = shrunk + _log2(_shrinkage(steps[-3:-1], steps[-2:], order))
        asymptotic, regular = abs(surplus) < AGREEMENT, -AGREEMENT < surplus < NEXT + AGREEMENT
    envelope = max(
        earlier * _shrinkage(steps[at : at + 2], steps[-2:], 1)
        for at, earlier in enumerate(differences)
        if at >= len(differences) - MEMORY
    )
    if certain == 1:
        envelope *= SAFETY_FACTOR if len(differences) >= MEMORY else math.inf
        asymptotic = regular = False
    coarser = (change if regular else envelope) * ratio / (ratio - 1.0)
    return Convergence(measured, asymptotic, coarser, expected if asymptotic else envelope / (ratio - 1.0), expected)


def _shrinkage(before: Sequence[int], after: Sequence[int], order: int) -> float:
    """The difference between two runs over that between two others where errors are C hᵖ."""
    first, second, third, fourth = power((*before, *after), -order).tolist()
    shrinkage: float = (third - fourth) / (first - second)
    return shrinkage


def _log2(x: float) -> float:
    return float(log(x) / log(2.0))


def order_between(steps: Sequence[int], values: Sequence[float], order: int) -> float:
    """The power with which a value fell in the last two runs, between 1 and the order of the method; that, of one."""
    if len(values) < 2 or not values[-2] > values[-1] > 0.0:
        return float(order) if len(values) < 2 else 1.0
    seen = float(log(values[-2] / values[-1]) / log(steps[-1] / steps[-2]))
    return min(max(seen, 1.0), float(order))


def stagnant(values: Sequence[float], scale: float) -> bool:
    """Whether smaller steps no longer make a value smaller: at the floor of rounding, or because nothing converges.

    Args:
        values: differences or errors, in the order of falling steps.
        scale: what they are small or large beside.
    """
    small = bool(values) and values[-1] < SMALL * scale
    runs = 2 if small else STUCK
    if len(values) <= runs:
        return False
    # Among values that are not small some are so by chance.
    return values[-1] > math.prod([FLAT] * runs) * (values[-1 - runs] if small else max(values[:-runs]))
