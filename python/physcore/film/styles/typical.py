"""Robust upper ends of color scales, which are not affected by outliers among values and frames."""

from __future__ import annotations

from bisect import insort

import numpy as np

from physcore.checks import FloatArray

TYPICAL = 99.5
"""Percentile of a frame's values for its typical value: one particle in two hundred may be beyond."""
RARE = 0.02
"""Fraction of frames that may be beyond the end of a scale, so that an impact does not darken all other frames."""
SEVERAL = 10
"""From this number of frames on, at least one frame may be beyond the end."""
MANY = 50_000
"""Largest number of values of which a percentile is computed."""


class Typical:
    """Upper end of a scale for a whole film: the largest percentile of its frames, without the rarest frames.

        top = Typical()
        top.add(np.array([0.1, 0.3, 0.2]))  # 0.3

    A single outlier in a frame, or a single extreme frame among many, does not affect the end. Values beyond the end
    have its color. A percentile over all values of a film would not serve: if few particles move, it is the value of
    those at rest.

    Args:
        percentile: the percentile of each frame.
        rare: the fraction of frames that may be beyond the end.
        least: least end, as a fraction of the largest typical value of all frames.
    """

    def __init__(self, percentile: float = TYPICAL, rare: float = RARE, least: float = 0.0) -> None:
        self._percentile, self._rare, self._least = percentile, rare, least
        self._frames: list[float] = []

    def add(self, values: FloatArray) -> float:
        """Add a frame, and return the end of the scale for all frames so far."""
        insort(self._frames, typical(values, self._percentile))
        beyond = max(int(self._rare * len(self._frames)), len(self._frames) >= SEVERAL)
        end = self._frames[-1 - beyond]
        return max(end, self._least * self._frames[-1]) if self._least > 0.0 else end


class Range:
    """Range of values of which nothing is known beforehand, from the smallest to the largest typical one of a film."""

    def __init__(self) -> None:
        self._least, self._most = Typical(), Typical()
        self._low, self._high = 0.0, 0.0

    def add(self, values: FloatArray) -> None:
        """Add a frame."""
        self._low, self._high = -self._least.add(-values), self._most.add(values)

    @property
    def signed(self) -> bool:
        """Whether the values have both signs."""
        return self._low < 0.0 < self._high

    @property
    def ends(self) -> tuple[float, float]:
        """Both ends, which differ; about zero if the values have both signs."""
        if self.signed:
            end = max(-self._low, self._high)
            return -end, end
        return self._low, self._high if self._high > self._low else self._low + (abs(self._low) or 1.0)


def typical(values: FloatArray, percentile: float = TYPICAL) -> float:
    """A percentile of the finite values, computed from at most MANY of them; 0 if there are none."""
    few = values[:: 1 + len(values) // MANY]
    finite = few[np.isfinite(few)]
    if len(finite) == 0:
        return 0.0
    rank = min(int(len(finite) * percentile / 100), len(finite) - 1)
    return float(np.partition(finite, rank)[rank])
