"""Period of a motion, found from the frames of a recording."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from physcore.checks import FloatArray
from physcore.scene.marks import TURNS, marks
from physcore.scene.periodic import Periodic
from physcore.scene.scene import Scene

CLOSE = 0.02
"""Tolerance of the return to earlier positions, relative to the extent of the motion (root mean squares)."""
PARTICLES, FRAMES = 200, 600
"""Largest numbers of particles and of frames that are used."""


def marked(scene: Scene, channels: Mapping[str, FloatArray]) -> FloatArray | None:
    """Places (F, M, D) [m] that return when particles and rigid bodies do; None if they were not recorded.

    They are the particles and the marks of rigid bodies.
    """
    wanted = ("positions", *(name for name in ("rigid_positions", *TURNS.values()) if name in scene.fields))
    if not set(wanted) <= channels.keys():
        return None
    places = [channels["positions"]] if scene.bodies else []
    if scene.has_rigid_bodies:
        places.append(marks(scene, channels))
    return np.concatenate(places, axis=1) if places else None


def period_of(times: FloatArray, positions: FloatArray, domain: Periodic | None) -> float | None:
    """The period [s] of positions (F, N, D) at equidistant times; None if they do not return.

    The mean square distance s(τ) of x(t + τ) from x(t) is small at a period. It is computed at the frames. A parabola
    through the three values around its minimum, s(τ) ≈ s₀ + ½ s″ (τ − T)², gives the period between frames.
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
    # A period is a minimum of s after a large value. Between frames, s is smaller than at the frames.
    for index in range(1, len(lags) - 1):
        before, here, after = squares[index - 1 : index + 2]
        if squares[:index].max() > 0.25 * largest and here <= before and here < after:
            curvature = before - 2.0 * here + after
            offset = 0.5 * (before - after) / curvature
            if here - 0.25 * (before - after) * offset <= CLOSE * CLOSE * largest:
                return float((lags[index] + offset) * step)
    return None
