"""Gravitation by the trees of pytreegrav (M. Y. Grudić, A. B. Gurvich, J. Open Source Softw. 6 (2021) 3675), with
quadrupoles, and of REBOUND (H. Rein, S.-F. Liu, Astron. Astrophys. 537 (2012) A128), without.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rivals import optional

pytreegrav, rebound = optional("pytreegrav"), optional("rebound")

Array = NDArray[Any]
Evaluation = Callable[[Array, Array, float], Array]
ANGLES = (1.2, 1.0, 0.85, 0.7, 0.6, 0.5, 0.42, 0.35, 0.3)
SAMPLE = 1000


def accelerations(positions: Array, mass: Array, angle: float) -> Array:
    """Those of all stars by pytreegrav."""
    found: Array = pytreegrav.Accel(positions, mass, theta=angle, parallel=True, method="tree", quadrupole=True)
    return found


def rebound_run(positions: Array, mass: Array, angle: float, step: float) -> rebound.Simulation:
    """A run of REBOUND from rest: one evaluation for each step. The root cell holds all stars of a cube of side 1."""
    run = rebound.Simulation()
    run.G, run.gravity, run.integrator, run.dt = 1.0, "tree", "leapfrog", step
    run.root_size, run.opening_angle2 = 2.0, angle**2
    for m, (x, y, z) in zip(mass, positions - 0.5, strict=True):
        run.add(m=m, x=x, y=y, z=z)
    return run


def rebound_accelerations(positions: Array, mass: Array, angle: float) -> Array:
    """Those of all stars by REBOUND."""
    run = rebound_run(positions, mass, angle, 1e-12)
    run.steps(1)
    return np.array([(one.ax, one.ay, one.az) for one in run.particles])


def widest_angle(evaluate: Evaluation, positions: Array, mass: Array, error: float) -> float:
    """The largest of some opening angles whose rms error is at most so much, on a sample."""
    some = slice(None, None, len(positions) // SAMPLE)
    exact = np.zeros_like(positions[some])
    for row, place in zip(exact, positions[some], strict=True):
        d = positions - place
        square = (d**2).sum(axis=1)
        row[:] = (mass / np.where(square > 0.0, square, np.inf) ** 1.5) @ d
    for angle in ANGLES:
        off = evaluate(positions, mass, angle)[some] - exact
        if (off**2).sum() <= error**2 * (exact**2).sum():
            return angle
    raise SystemExit(f"a rival errs by more than {error:g} at an opening angle of {ANGLES[-1]}")
