"""Gravitation by the tree of pytreegrav (M. Y. Grudić, A. B. Gurvich, J. Open Source Softw. 6 (2021) 3675)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pytreegrav import Accel

Array = NDArray[Any]
ANGLES = (1.2, 1.0, 0.85, 0.7, 0.6, 0.5)
SAMPLE = 1000


def accelerations(positions: Array, mass: Array, angle: float) -> Array:
    """Those of all stars, with quadrupoles."""
    found: Array = Accel(positions, mass, theta=angle, parallel=True, method="tree", quadrupole=True)
    return found


def widest_angle(positions: Array, mass: Array, error: float) -> float:
    """The largest of some opening angles whose rms error is at most so much, on a sample."""
    some = slice(None, None, len(positions) // SAMPLE)
    exact = np.zeros_like(positions[some])
    for row, place in zip(exact, positions[some], strict=True):
        d = positions - place
        square = (d**2).sum(axis=1)
        row[:] = (mass / np.where(square > 0.0, square, np.inf) ** 1.5) @ d
    for angle in ANGLES:
        off = accelerations(positions, mass, angle)[some] - exact
        if (off**2).sum() <= error**2 * (exact**2).sum():
            return angle
    raise SystemExit(f"pytreegrav errs by more than {error:g} at an opening angle of {ANGLES[-1]}")
