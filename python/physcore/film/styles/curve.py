"""The curve that particles take from one frame to the next: a cubic, or two arcs that meet in a corner at a contact."""

from __future__ import annotations

import numpy as np

from physcore.checks import BoolArray, FloatArray

BETWEEN = 6
"""Points of a curve between two frames, the later frame's own included."""
MANY = 500
"""Of more particles, only the positions in the frames are joined."""
SUDDEN = 3.0
"""A change of velocity is a collision where it is so many times that of the interval before."""
MEETING = 0.05
"""Arcs meet where they pass closer than this part of the way that the change of velocity makes in an interval."""
MOMENTS = 33
"""Moments within an interval that are tried for a collision."""
FLAT = 1e-9
"""Of the squared distances around a moment: a second difference below this share is rounding."""


class Curve:
    """Curves of N particles, piece by piece.

    Smooth pieces are cubic Hermite interpolants of positions and velocities. Where a velocity has changed suddenly, the
    piece follows the parabola from its start and the one toward its end, with the acceleration before, up to where they
    are nearest to each other: at a bounce that is the wall, off by O(Δt³).
    """

    def __init__(self, interval: float, *, smooth: bool = True) -> None:
        self._interval, self._smooth = interval, smooth
        self._last: tuple[FloatArray, FloatArray | None] | None = None
        self._acceleration: FloatArray | None = None

    def begin(self) -> None:
        """Forget what was before."""
        self._last = self._acceleration = None

    def piece(self, points: FloatArray, velocities: FloatArray | None) -> FloatArray:
        """The curve since the last frame (K, N, D) [m], its end included; K is the same for all but the first."""
        last, self._last = self._last, (points, velocities)
        if last is None:
            return points[np.newaxis]
        before, slopes = last
        if velocities is None or slopes is None or not self._smooth or len(points) > MANY:
            return points[np.newaxis]
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
        """Which particles (N,) have changed their velocity suddenly, by their mean acceleration."""
        if self._acceleration is None:
            return np.zeros(len(change), dtype=bool)
        usual = np.linalg.norm(self._acceleration, axis=1)
        sudden: BoolArray = np.linalg.norm(change - self._acceleration, axis=1) > SUDDEN * usual + 1e-9
        return sudden


def _cornered(
    start: tuple[FloatArray, FloatArray], end: tuple[FloatArray, FloatArray], acceleration: FloatArray, dt: float
) -> tuple[FloatArray, FloatArray]:
    """Two arcs (K, N, D) with a corner where the one from the start meets the one toward the end, and how far from each
    other they pass there (N,) [m].
    """

    def forward(time: FloatArray) -> FloatArray:
        return start[0] + time * start[1] + 0.5 * time**2 * acceleration

    def backward(time: FloatArray) -> FloatArray:
        left = dt - time
        return end[0] - left * end[1] + 0.5 * left**2 * acceleration

    times = np.linspace(0.0, dt, MOMENTS)[:, np.newaxis, np.newaxis]
    apart = ((forward(times) - backward(times)) ** 2).sum(axis=2)
    middle = np.clip(apart.argmin(axis=0), 1, MOMENTS - 2)
    # The squared distance is nearly a parabola in time: its vertex lies between the moments that were tried.
    low, least, high = (np.take_along_axis(apart, (middle + step)[np.newaxis], axis=0)[0] for step in (-1, 0, 1))
    # No curvature beyond rounding, no vertex: the moment that was tried stands.
    bend = low - 2.0 * least + high
    bend[bend <= FLAT * (low + high)] = np.inf
    vertex = (middle + np.clip(0.5 * (low - high) / bend, -1.0, 1.0)) * dt / (MOMENTS - 1)
    corner = vertex[:, np.newaxis]
    first, last = BETWEEN // 2, BETWEEN - BETWEEN // 2
    ups = [forward(corner * (step / first)) for step in range(1, first)]
    downs = [backward(corner + (dt - corner) * (step / last)) for step in range(1, last + 1)]
    one, other = forward(corner), backward(corner)
    return np.stack([*ups, 0.5 * (one + other), *downs]), np.linalg.norm(one - other, axis=1)
