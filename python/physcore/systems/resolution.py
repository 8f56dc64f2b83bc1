"""Resolution of waves by a grid: cells per wavelength, and the speed that differences leave to them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from physcore.arithmetic import arctan2, exp, log
from physcore.checks import FloatArray

SLOW = 0.05
"""Largest error of the group velocity that is not noted."""


FEW = 0.05
"""Largest fraction of the cells that are spikes, as opposed to noise."""

SHARP = 0.5
"""Mean square of the differences between cells, in units of that of the field, above which spikes are narrower than a
cell. It is that of a block of four cells.
"""

SINGLE = 1.9
"""Mean square of the differences of spikes in single cells, whose width the grid does not tell; 2 without neighbors."""

WIDE = 1.6
"""Width σ [cells] of a Gaussian that diffuses at its rate but for `SLOW`: 2 (1 − exp(−s/2))/s at s = 1/(2σ²)."""


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


def spikes(what: str, values: FloatArray, spacing: float) -> list[str]:
    """A note on spikes of an initial field that are too sharp for diffusion on a grid: on those narrower than a cell.

    Diffusion levels a Gaussian of width σ off at the rate D/σ², by the mean of k². On a grid it is the mean of
    4 sin²(kh/2)/h², which is 2 (1 − exp(−s/2))/h² for s = h²/(2σ²), and the differences between cells give it. Noise,
    which is in all cells, is left to the reactions that it starts.
    """
    heights = values - np.median(values)
    heights /= np.abs(heights).max() or 1.0
    total = float(np.square(heights).sum())
    if total == 0.0 or total * total > FEW * values.size * float(np.square(np.square(heights)).sum()):
        return []
    steepest = max(float(np.square(np.diff(heights, axis=axis)).sum()) for axis in range(values.ndim)) / total
    if steepest <= SHARP:
        return []
    mean = min(steepest, SINGLE)
    square = -2.0 * float(log(1.0 - 0.5 * mean))
    width = math.sqrt(0.5 / square)
    cells = f"{width:.2f}" if steepest < SINGLE else f"at most {width:.1f}"
    return [
        f"{what}: spikes have a width σ of {cells} cells, and level off at about {mean / square:.2f} of their rate on "
        f"this grid at first; σ = {WIDE * spacing:.2g} m, or a spacing of {width / WIDE * spacing:.2g} m, keeps "
        f"{SLOW:.0%}"
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
