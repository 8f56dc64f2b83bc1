"""Interpolated paths of particles between frames: a cubic, or two arcs with a corner at a collision."""

from __future__ import annotations

import numpy as np

from physcore.checks import BoolArray, FloatArray

BETWEEN = 6
"""Number of points of a curve between two frames, including the later frame."""
MANY = 500
"""Number of particles above which paths are straight between frames."""
SUDDEN = 3.0
"""A change of velocity above this multiple of the one in the previous interval counts as a collision."""
MEETING = 0.05
"""Tolerance of the corner: least distance of the two arcs, relative to |Δv| Δt."""
NEARLY = 1e-6
"""Relative difference from the usual interval up to which an interval counts as that: times are rounded."""
MOMENTS = 33
"""Number of instants within an interval that are tried for a collision."""
FLAT = 1e-9
"""Second differences of the squared distance below this fraction of their terms count as rounding errors."""


class Curve:
    """Interpolated paths of N particles, one piece per interval.

    Smooth pieces are cubic Hermite interpolants of positions and velocities. After a sudden change of velocity, a piece
    consists of two parabolas, one from its start and one toward its end. Both have the acceleration of the interval
    before. The corner is where they are nearest to each other. In a bounce this is the wall, with an error of O(Δt³).

    Args:
        interval: the usual interval between two frames [s].
        smooth: whether paths are curved between frames.
    """

    def __init__(self, interval: float, *, smooth: bool = True) -> None:
        self._interval, self._smooth = interval, smooth
        self._last: tuple[float, FloatArray, FloatArray | None] | None = None
        self._acceleration: FloatArray | None = None

    def begin(self) -> None:
        """Forget earlier frames."""
        self._last = self._acceleration = None

    def piece(self, time: float, points: FloatArray, velocities: FloatArray | None) -> FloatArray:
        """The path since the last frame (K, N, D) [m], including its end at a time [s]. K is the same for all pieces
        except the first.
        """
        last, self._last = self._last, (time, points, velocities)
        if last is None:
            return points[np.newaxis]
        moment, before, slopes = last
        if velocities is None or slopes is None or not self._smooth or len(points) > MANY:
            return points[np.newaxis]
        dt = time - moment
        if dt <= 0.0 or abs(dt - self._interval) < NEARLY * self._interval:
            dt = self._interval
        s = (np.arange(1, BETWEEN + 1) / BETWEEN)[:, np.newaxis, np.newaxis]
        r, shift = 1.0 - s, points - before
        way: FloatArray = before + s * s * (3.0 - 2.0 * s) * shift + dt * s * r * (r * slopes - s * velocities)
        change = (velocities - slopes) / dt
        collided = self._collided(change)
        if collided.any():
            rows = np.flatnonzero(collided)
            constant = np.zeros_like(change[rows]) if self._acceleration is None else self._acceleration[rows]
            start, end = (before[rows], slopes[rows]), (points[rows], velocities[rows])
            arcs, gap = _cornered(start, end, constant, dt)
            met = gap < MEETING * np.linalg.norm(slopes[rows] - velocities[rows], axis=1) * dt
            way[:, rows[met]] = arcs[:, met]
        earlier = change if self._acceleration is None else self._acceleration
        self._acceleration = np.where(collided[:, np.newaxis], earlier, change)
        return way

    def _collided(self, change: FloatArray) -> BoolArray:
        """Mask (N,) of the particles whose velocity changed suddenly; `change` is the mean acceleration of the
        interval.
        """
        if self._acceleration is None:
            return np.zeros(len(change), dtype=bool)
        usual = np.linalg.norm(self._acceleration, axis=1)
        sudden: BoolArray = np.linalg.norm(change - self._acceleration, axis=1) > SUDDEN * usual + 1e-9
        return sudden


def _cornered(
    start: tuple[FloatArray, FloatArray], end: tuple[FloatArray, FloatArray], acceleration: FloatArray, dt: float
) -> tuple[FloatArray, FloatArray]:
    """Two arcs (K, N, D) with a corner where they are nearest to each other, and their distance there (N,) [m]."""

    def forward(time: FloatArray) -> FloatArray:
        return start[0] + time * start[1] + 0.5 * time**2 * acceleration

    def backward(time: FloatArray) -> FloatArray:
        left = dt - time
        return end[0] - left * end[1] + 0.5 * left**2 * acceleration

    times = np.linspace(0.0, dt, MOMENTS)[:, np.newaxis, np.newaxis]
    apart = ((forward(times) - backward(times)) ** 2).sum(axis=2)
    middle = np.clip(apart.argmin(axis=0), 1, MOMENTS - 2)
    # The squared distance is nearly a parabola in time. Its vertex refines the best of the instants.
    low, least, high = (np.take_along_axis(apart, (middle + step)[np.newaxis], axis=0)[0] for step in (-1, 0, 1))
    # Without curvature beyond rounding there is no vertex, and the best instant is kept.
    bend = low - 2.0 * least + high
    bend[bend <= FLAT * (low + high)] = np.inf
    vertex = (middle + np.clip(0.5 * (low - high) / bend, -1.0, 1.0)) * dt / (MOMENTS - 1)
    corner = vertex[:, np.newaxis]
    first, last = BETWEEN // 2, BETWEEN - BETWEEN // 2
    ups = [forward(corner * (step / first)) for step in range(1, first)]
    downs = [backward(corner + (dt - corner) * (step / last)) for step in range(1, last + 1)]
    one, other = forward(corner), backward(corner)
    return np.stack([*ups, 0.5 * (one + other), *downs]), np.linalg.norm(one - other, axis=1)
