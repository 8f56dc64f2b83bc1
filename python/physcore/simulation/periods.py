"""Period of a motion, found from the frames of a recording."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import cast

import numpy as np

from physcore.arithmetic import cos, sin
from physcore.checks import FloatArray
from physcore.scene.bodies import Body
from physcore.scene.periodic import Periodic
from physcore.scene.rigid import RigidBodies
from physcore.scene.scene import Scene

CLOSE = 0.02
"""Tolerance of the return to earlier positions, relative to the extent of the motion (root mean squares)."""
PARTICLES, FRAMES = 200, 600
"""Largest numbers of particles and of frames that are used."""
TURNS = ("angles", "orientations")
"""Fields of the orientations of rigid bodies, in 2D and in 3D."""


def marked(scene: Scene, channels: Mapping[str, FloatArray]) -> FloatArray | None:
    """Places (F, M, D) [m] that return when particles and rigid bodies do; None if they were not recorded.

    They are the particles, the centers of rigid bodies, and points of these at their radius of gyration, which show
    how they turn.
    """
    wanted = ("positions", *(name for name in ("rigid_positions", *TURNS) if name in scene.fields))
    if not set(wanted) <= channels.keys():
        return None
    places = [channels["positions"]] if scene.bodies else []
    if scene.has_rigid_bodies:
        centers = channels["rigid_positions"]
        reach = np.concatenate([np.full(len(body), _gyration(body)) for body in scene.bodies if body.is_rigid])
        arms = reach[:, np.newaxis] * _axes(channels[TURNS[scene.dimension - 2]])
        places += [centers, *(centers + arm for arm in arms)]
    return np.concatenate(places, axis=1) if places else None


def _gyration(body: Body) -> float:
    """The radius of gyration of the shape of rigid bodies [m]."""
    size, _, moment = cast("RigidBodies", body).shape.properties(body.dimension)
    return (
        math.sqrt(float(np.trace(moment)) / 2.0 / size) if isinstance(moment, np.ndarray) else math.sqrt(moment / size)
    )


def _axes(turns: FloatArray) -> FloatArray:
    """The x axes, in 3D also the y axes, of bodies with angles (F, B) or quaternions (F, B, 4): (A, F, B, D)."""
    if turns.ndim == 2:
        return np.stack([cos(turns), sin(turns)], axis=-1)[np.newaxis]
    w, x, y, z = np.moveaxis(turns, -1, 0)
    first = np.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)], axis=-1)
    second = np.stack([2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)], axis=-1)
    return np.stack([first, second])


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
