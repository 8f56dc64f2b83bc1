"""Resolution of waves by a grid: cells per wavelength, and the speed that differences leave to them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from physcore.arithmetic import arctan2, exp
from physcore.checks import FloatArray

SLOW = 0.05
"""Largest error of the group velocity that is not noted."""


def wave_number(values: FloatArray | np.ndarray[tuple[int, ...], np.dtype[np.complex128]]) -> float:
    """The root-mean-square wave number of a field along the axis in which it is largest, in radians per cell.

    It follows from the differences between neighboring cells, Σ|Δu|²/Σ|u|² = 4 sin²(k h/2). 0 for a field of zeros.
    """
    size = float(np.square(np.abs(values)).sum())
    if size == 0.0:
        return 0.0
    steepest = max(float(np.square(np.abs(np.diff(values, axis=axis))).sum()) for axis in range(values.ndim))
    return angle(0.5 * math.sqrt(steepest / size))


def angle(sine: float) -> float:
    """The wave number k h with sin(k h/2) = `sine`; π, the largest of a grid, for a larger sine."""
    return 2.0 * float(arctan2(sine, math.sqrt(max(0.0, 1.0 - sine * sine))))


def carried(speed: Callable[[float], float]) -> float:
    """The largest wave number k h whose relative group velocity is off by at most `SLOW`, by bisection."""
    low, high = 0.0, math.pi
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if abs(1.0 - speed(middle)) <= SLOW else (low, middle)
    return low


def note(what: str, number: float, speed: Callable[[float], float], spacing: float, true: float = 0.0) -> list[str]:
    """A note on waves of a wave number k h, with the spacing that carries them, if they are off by more than `SLOW`.

    The wave number of such waves without the grid is `true`, if it differs.
    """
    relative, number = speed(number), true or number
    if abs(1.0 - relative) <= SLOW:
        return []
    finer = spacing * carried(speed) / number
    return [
        f"{what}: {math.tau / number:.2g} cells in a wavelength, which travel at {relative:.2g} of their speed on this "
        f"grid in small steps; a spacing of {finer:.2g} m keeps {SLOW:.0%}"
    ]


def front_speed(cells: float) -> float:
    """The speed of a pulled front over 2√(r D), if its width √(D/r) has so many cells.

    A front exp(−μ j) on a grid grows at r + 2 D/h² (cosh μ − 1), and the slowest one is selected. Source: W. van
    Saarloos, Phys. Rep. 386, 29 (2003).
    """

    def speed(mu: float) -> float:
        cosh = 0.5 * float(exp(mu) + exp(-mu))
        return (1.0 + 2.0 * cells * cells * (cosh - 1.0)) / (2.0 * cells * mu)

    low, high = 1e-3, min(2.0 + 4.0 / cells, 300.0)
    for _ in range(100):
        first, second = low + (high - low) / 3.0, high - (high - low) / 3.0
        low, high = (low, second) if speed(first) < speed(second) else (first, high)
    return speed(low)
