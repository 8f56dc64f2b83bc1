"""The period of a motion, from the frames of a recording."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray
from physcore.scene.periodic import Periodic

CLOSE = 0.02
"""How far particles may be from where they were, as a fraction of how far they go (root mean squares)."""
PARTICLES, FRAMES = 200, 600
"""At most so many of them are looked at."""


def period_of(times: FloatArray, positions: FloatArray, domain: Periodic | None) -> float | None:
    """The least time [s] after which positions (F, N, D) at equal distances of time come back; None where they do not.

    The mean square distance s(τ) of x(t + τ) from x(t) is small at a period. It is found at the frames and, by a
    parabola through the three around its minimum, between them, where s(τ) ≈ s₀ + ½ s″ (τ − T)².
    """
    if len(times) < 8 or positions.shape[1] == 0:
        return None
    some = positions[:: -(-len(times) // FRAMES), :: -(-positions.shape[1] // PARTICLES)]
    step = float(times[-1] - times[0]) / (len(times) - 1) * -(-len(times) // FRAMES)

    def apart(lag: int) -> float:
        shift = some[lag:] - some[: len(some) - lag]
        return float(np.mean(np.square(shift if domain is None else domain.nearest(shift))))

    lags = np.arange(1, len(some) // 2 + 1)
    squares = np.array([apart(int(lag)) for lag in lags])
    largest = squares.max()
    if not largest > 0.0 or not np.isfinite(largest):
        return None
    # A period is a minimum after the motion has been far away; between frames s is below its values at them.
    for index in range(1, len(lags) - 1):
        before, here, after = squares[index - 1 : index + 2]
        if squares[:index].max() > 0.25 * largest and here <= before and here < after:
            curvature = before - 2.0 * here + after
            offset = 0.5 * (before - after) / curvature
            if here - 0.25 * (before - after) * offset <= CLOSE * CLOSE * largest:
                return float((lags[index] + offset) * step)
    return None
