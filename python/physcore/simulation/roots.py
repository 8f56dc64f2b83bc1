"""Roots of functions of one variable."""

from __future__ import annotations

import math
from collections.abc import Callable


def crossed(
    function: Callable[[float], float], interval: tuple[float, float], values: tuple[float, float], tolerance: float
) -> float:
    """A place at most `tolerance` after a change of sign, at which the function is 0 or has its later sign.

    The method is inverse quadratic interpolation within a bracket, and bisection where that is not safe. For a smooth
    function it takes some seven evaluations.

    Source: T. R. Chandrupatla, Adv. Eng. Software 28, 145 (1997).

    Args:
        function: the function; it may jump.
        interval: two places, the first one before the second.
        values: the values there, of opposite signs.
        tolerance: > 0.
    """
    (b, a), (fb, fa) = interval, values  # a is the latest place, b that of the opposite sign.
    share = fa / (fa - fb) if math.isfinite(fa - fb) else 0.5
    while abs(b - a) > tolerance:
        margin = min(0.5, 0.5 * tolerance / abs(b - a))
        x = a + min(max(share, margin), 1.0 - margin) * (b - a)
        if not min(a, b) < x < max(a, b):
            break  # No number lies between the two.
        fx = function(x)
        if fx == 0.0:
            return x
        if (fx > 0.0) == (fa > 0.0):
            c, fc = a, fa
        else:
            c, fc, b, fb = b, fb, a, fa
        a, fa = x, fx
        share = _interpolated((a, b, c), (fa, fb, fc))
    return max(a, b)


def _interpolated(places: tuple[float, float, float], values: tuple[float, float, float]) -> float:
    """The share of the way from a to b at which the inverse parabola through three points is 0.

    Where the parabola is not monotonic, the share is one half.
    """
    (a, b, c), (fa, fb, fc) = places, values
    place, value = (a - b) / (c - b), (fa - fb) / (fc - fb)
    if not (value * value < place and (1.0 - value) * (1.0 - value) < 1.0 - place):
        return 0.5
    return fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
