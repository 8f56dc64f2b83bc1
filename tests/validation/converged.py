"""Springs in gravity, solved in decimal arithmetic of any length until nothing that is asked for changes any more.

That of a chaotic motion is the solution to all digits where two runs of different tolerance *and* word length agree:
errors of either kind grow alike, and what survives both is neither.

Sources: T. Boekholt, S. Portegies Zwart, Comput. Astrophys. Cosmol. 2, 2 (2015), for the criterion; E. Hairer,
S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", § II.9 and II.14, for the extrapolation.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Any

import numpy as np

import physcore as pc
from physics.laboratory import Array

STRIDE = Decimal("0.0625")
"""The longest step that is extrapolated [s]."""
COLUMNS = 24
"""Columns of the table before the step is halved."""

exact = np.vectorize(Decimal, otypes=[object])
"""The decimals that binary numbers stand for, digit by digit."""


@dataclass(frozen=True)
class Springs:
    """x'' = g + Σ k (l − L) e / m, with the numbers of a scene as decimals."""

    ends: Any
    """−1 and 1 at the ends of each spring, 0 elsewhere, shape (S, N)."""
    stiffness: Any
    rest_length: Any
    weight: Any
    """1/m, and 0 where fixed, shape (N, 1)."""
    gravity: Any

    @classmethod
    def of(cls, body: pc.SpringNetwork, gravity: pc.Gravity) -> Springs:
        """Those of a body in uniform gravity."""
        ends = np.zeros((len(body.pairs), len(body.positions)), dtype=object)
        for spring, (one, other) in enumerate(body.pairs):
            ends[spring, one], ends[spring, other] = -1, 1
        weight = np.where(body.fixed, Decimal(0), 1 / exact(body.mass))[:, None]
        return cls(ends, exact(body.stiffness), exact(body.rest_length), weight, exact(gravity.acceleration))

    def acceleration(self, positions: Any) -> Any:
        """[m/s²]"""
        offsets = self.ends @ positions
        lengths = np.array([total.sqrt() for total in (offsets * offsets).sum(axis=1)])
        pulls = (self.stiffness * (self.rest_length / lengths - 1))[:, None] * offsets
        return self.weight * (self.ends.T @ pulls) + np.sign(self.weight) * self.gravity

    def verlet(self, state: Any, span: Decimal, steps: int) -> Any:
        """Velocity Verlet, whose error is a series in the square of the step."""
        (positions, velocities), step = state, span / steps
        acceleration = self.acceleration(positions)
        for _ in range(steps):
            velocities = velocities + step / 2 * acceleration
            positions = positions + step * velocities
            acceleration = self.acceleration(positions)
            velocities = velocities + step / 2 * acceleration
        return np.array([positions, velocities])

    def advance(self, state: Any, span: Decimal, tolerance: Decimal) -> Any:
        """The state after `span`, by extrapolation to steps of zero, to within `tolerance` in each stride of it."""
        if span > STRIDE:
            return self.advance(self.advance(state, span / 2, tolerance), span / 2, tolerance)
        row: list[Any] = []
        for column in range(1, COLUMNS):
            before, row = row, [self.verlet(state, span, 2 * column)]
            for order, coarser in enumerate(before, start=1):
                ratio = Decimal(column) / (column - order)
                row.append(row[-1] + (row[-1] - coarser) / (ratio * ratio - 1))
            if before and abs(row[-1] - row[-2]).max() < tolerance:
                return row[-1]
        return self.advance(self.advance(state, span / 2, tolerance), span / 2, tolerance)


def trajectory(springs: Springs, positions: Array, velocities: Array, times: Array, digits: int) -> Array:
    """Positions and velocities at equal times, with a tolerance of 10^−digits per stride and a word half as long again;
    shape (T, 2, N, D). They are rounded at the end.
    """
    with localcontext(prec=digits * 3 // 2):
        states = [np.array([exact(positions), exact(velocities)])]
        span = exact(times[1] - times[0])[()]
        for _ in times[1:]:
            states.append(springs.advance(states[-1], span, Decimal(10) ** -digits))
    return np.array(states).astype(np.float64)
