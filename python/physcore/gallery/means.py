"""The arithmetic–geometric mean, from which complete elliptic integrals follow."""

from __future__ import annotations

import math

ROUNDS = 8
"""Number of means, each of which about doubles the number of right digits."""


def arithmetic_geometric(one: float, other: float) -> float:
    """The common limit of repeated arithmetic and geometric means of two positive numbers (C. F. Gauss, 1799).

    The complete elliptic integral K of the modulus k is π/2 over that of 1 and √(1 − k²).
    """
    for _ in range(ROUNDS):
        one, other = 0.5 * (one + other), math.sqrt(one * other)
    return one
