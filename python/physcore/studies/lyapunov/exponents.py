"""Lyapunov exponents and derived quantities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physcore.checks import BoolArray, FloatArray
from physcore.markup import Printed
from physcore.units.systems import SI, UnitSystem

MOST = 7
"""Largest number of exponents in a table."""


@dataclass(frozen=True, eq=False, repr=False)
class Lyapunov(Printed):
    """Lyapunov exponents, in descending order.

        cloud = pc.Tracers(rng.normal(size=(20, 3)) + (0, 0, 25), pc.Lorenz())
        spectrum = pc.lyapunov(cloud, duration=5.0, transient=1.0, dt=0.01)  # a Lyapunov
        spectrum.exponents, spectrum.dimension

    `lyapunov` returns it.
    """

    exponents: FloatArray
    """Exponents λ: mean growth rates along directions of the tangent space [1/s], shape (K,)."""
    errors: FloatArray
    """Standard errors of the exponents [1/s], shape (K,), from the scatter over trajectories. For a single trajectory,
    from the scatter over tenths of the duration; NaN if these are shorter than an interval. At least the exponent
    itself where the growth is not exponential.
    """
    each: FloatArray
    """Exponents along each trajectory [1/s], shape (N, K)."""
    duration: float
    """Averaging time [s]."""
    directions: int
    """Total number of exponents: the dimension of the tangent space."""
    exponential: BoolArray
    """Whether distances grow or shrink exponentially, shape (K,): false where this is not told from a growth in
    proportion to time.
    """
    units: UnitSystem = SI
    """Units of the scene."""

    def __str__(self) -> str:
        """A line for each exponent with its error and a remark, and the dimension if it is known."""
        exponent = self.units.label("exponent", "1/s")
        width = max(16, len(exponent) + 2)
        heading = f"{exponent:>{width}}  {'error':>8}"
        remarks = np.where(self.exponential, "", "  not told from zero")
        rows = [
            f"{value:{width}.6g}  {error:8.2g}{remark}"
            for value, error, remark in zip(self.exponents, self.errors, remarks, strict=True)
        ]
        shown = [*rows[:MOST], *([f"  … and {len(rows) - MOST} more"] if len(rows) > MOST else [])]
        dimension = [] if np.isnan(self.dimension) else [f"  dimension {self.dimension:.4g}"]
        return "\n".join([heading, *shown, *dimension])

    @property
    def sum(self) -> float:
        """Sum Σ λ of the exponents; with all of them, the mean rate of volume growth [1/s]."""
        return float(self.exponents.sum())

    @property
    def dimension(self) -> float:
        """Kaplan–Yorke dimension of the attractor, j + (λ₁ + … + λⱼ)/|λⱼ₊₁|, with the largest j for a nonnegative sum.

        The value is NaN if an exponent in the formula was not measured.
        """
        sums = np.cumsum(self.exponents)
        j = int((sums >= 0.0).sum())
        if j == len(sums):
            return float(j) if j == self.directions else np.nan
        return j + float(sums[j - 1] / abs(self.exponents[j])) if j > 0 else 0.0
