"""Lyapunov exponents, and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physcore.checks import FloatArray


@dataclass(frozen=True, eq=False)
class Lyapunov:
    """Lyapunov exponents, the largest first.

        cloud = pc.Tracers(rng.normal(size=(20, 3)) + (0, 0, 25), pc.Lorenz())
        spectrum = pc.lyapunov(cloud, duration=5.0, transient=1.0, dt=0.01)  # a Lyapunov
        spectrum.exponents, spectrum.dimension

    `lyapunov` measures it.
    """

    exponents: FloatArray
    """Mean rates of growth λ along directions of the tangent space [1/s], shape (K,)."""
    errors: FloatArray
    """Their standard errors [1/s], shape (K,): from the scatter among paths; of a single path from that among tenths of
    the duration, not a number where these are shorter than an interval."""
    each: FloatArray
    """The exponents along each path [1/s], shape (N, K)."""
    duration: float
    """The time over which they were averaged [s]."""
    directions: int
    """How many exponents there are: the dimension of the tangent space."""

    @property
    def sum(self) -> float:
        """Σ λ, of all exponents the mean rate at which volumes grow [1/s]."""
        return float(self.exponents.sum())

    @property
    def dimension(self) -> float:
        """The dimension of the attractor by Kaplan and Yorke: j + (λ₁ + … + λⱼ)/|λⱼ₊₁|, with the largest j at which
        that sum is not below zero; not a number where exponents that it takes were not measured.
        """
        sums = np.cumsum(self.exponents)
        j = int((sums >= 0.0).sum())
        if j == len(sums):
            return float(j) if j == self.directions else np.nan
        return j + float(sums[j - 1] / abs(self.exponents[j])) if j > 0 else 0.0
