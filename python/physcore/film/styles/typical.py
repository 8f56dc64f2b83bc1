"""What is typical of values: ends of color scales that neither a few values nor a few frames take for themselves."""

from __future__ import annotations

from bisect import insort

import numpy as np

from physcore.checks import FloatArray

TYPICAL = 99.5
"""What is typical of a frame is this percentile of its values: one particle in two hundred may be beyond."""
RARE = 0.02
"""The share of frames that may be beyond the end of a scale: an impact of some frames does not darken all others."""
SEVERAL = 10
"""Of so many frames at least one may be."""
MANY = 50_000
"""The largest number of values of which a percentile is taken."""


class Typical:
    """The end of a scale for a whole film: a percentile of each frame, and of these all but the rarest.

        top = Typical()
        top.add(np.array([0.1, 0.3, 0.2]))  # 0.3

    With one outlier in a frame, or one frame among many, the end is that of the others; the values beyond it have its
    color. A percentile of all values of a film would be that of the particles at rest, if only a few move.

    Args:
        percentile: of each frame.
        rare: the share of frames that may be beyond the end.
        least: the end is at least this fraction of what is typical of the frame with the most.
    """

    def __init__(self, percentile: float = TYPICAL, rare: float = RARE, least: float = 0.0) -> None:
        self._percentile, self._rare, self._least = percentile, rare, least
        self._frames: list[float] = []

    def add(self, values: FloatArray) -> float:
        """The end for all frames so far, with one more."""
        insort(self._frames, typical(values, self._percentile))
        beyond = max(int(self._rare * len(self._frames)), len(self._frames) >= SEVERAL)
        return max(self._frames[-1 - beyond], self._least * self._frames[-1])


def typical(values: FloatArray, percentile: float = TYPICAL) -> float:
    """The value below which nearly all lie, of at most some ten thousands of them; 0 if there are none."""
    few = values[:: 1 + len(values) // MANY]
    finite = few[np.isfinite(few)]
    if len(finite) == 0:
        return 0.0
    rank = min(int(len(finite) * percentile / 100), len(finite) - 1)
    return float(np.partition(finite, rank)[rank])
