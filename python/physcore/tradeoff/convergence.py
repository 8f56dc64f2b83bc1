"""Convergence: orders and errors from runs that differ in their time step alone.

The one estimator behind `accuracy=` and `tradeoff`. A method of order p is off by e(h) = C hᵖ + O(hᵖ⁺¹), so that the
difference d of two runs with the steps h and h/r tells both errors: C hᵖ = d/(1 − r⁻ᵖ), and that over rᵖ. Whether steps
are small enough for that, the differences of three runs tell: they shrink as they should, or they do not.

Source: L. F. Richardson, Phil. Trans. R. Soc. A 226, 299 (1927); E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary
Differential Equations I", 2nd ed. 1993, § II.4.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

AGREEMENT = 0.5
"""How far the measured order may be from the order of the method for the latter to be believed."""
SAFETY_FACTOR = 2.0
"""Of an error that the order of the method gives, and not the difference of two runs alone."""
FLAT = 0.7
"""A value that shrinks less than this, twice, where it is small, has reached the floor of rounding; with the step
halved it would halve even at order 1."""
SMALL = 1e-3
"""What is small, as a fraction of the scale."""
STUCK = 6
"""As often as this a value that is not small may refuse to shrink: else it is chaos, or nothing converges."""


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


def convergence(steps: Sequence[int], differences: Sequence[float], order: int) -> Convergence:
    """Judge runs with rising numbers of steps by the differences between each and the one before.

    Of an order that was not measured no more is believed than that it is one at least, over no more than a halving:
    the coarser run is off by 2d at most then, and the finer by d.

    Args:
        steps: of the last two or three runs.
        differences: between each two of them in turn, one fewer.
        order: of the method, p.
    """
    ratio = min(steps[-1] / steps[-2], 2.0)
    change = differences[-1]
    measured, asymptotic = math.nan, False
    if len(differences) > 1 and min(differences[-2:]) > 0.0:
        powers = [float(count) ** -order for count in steps[-3:]]
        shrunk = math.log2(differences[-2] / change)
        due = math.log2((powers[0] - powers[1]) / (powers[1] - powers[2]))
        measured = shrunk / math.log2(steps[-2] / steps[-3])
        asymptotic = abs(shrunk - due) < AGREEMENT
    by_order_one = change / (ratio - 1.0)
    expected = min(SAFETY_FACTOR * change / (ratio**order - 1.0), by_order_one)
    return Convergence(
        measured, asymptotic, change * ratio / (ratio - 1.0), expected if asymptotic else by_order_one, expected
    )


def order_between(steps: Sequence[int], values: Sequence[float], order: int) -> float:
    """The power with which a value fell in the last two runs, between 1 and the order of the method; that, of one."""
    if len(values) < 2 or not values[-2] > values[-1] > 0.0:
        return float(order) if len(values) < 2 else 1.0
    seen = math.log(values[-2] / values[-1]) / math.log(steps[-1] / steps[-2])
    return min(max(seen, 1.0), float(order))


def stagnant(values: Sequence[float], scale: float) -> bool:
    """Whether smaller steps have stopped to make a value smaller: at the floor of rounding, or because nothing converges.

    Args:
        values: differences or errors, in the order of falling steps.
        scale: what they are small or large beside.
    """
    flat = [later > FLAT * earlier for earlier, later in zip(values, values[1:], strict=False)]
    least = 2 if values and values[-1] < SMALL * scale else STUCK
    return len(flat) >= least and all(flat[-least:])
