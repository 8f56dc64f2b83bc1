"""Twenty-four chains of six rods move alike for five seconds; a second later all of them differ.

The physics checked: as long as they are close, they separate at the rate given by the Lyapunov exponent.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.double_pendulum import down, draw, parting, pendulums
from physcore.gallery.figure import Figure

PENDULUMS = 24
RODS, LENGTH = 6, 0.3
"""Number of rods of a pendulum, and length of a rod [m]."""
ANGLE, SPREAD = math.radians(95.0), math.radians(1e-6)
"""Initial angle of all rods from the downward vertical, and range of the upper angles over all pendulums [rad]."""

DURATION = 9.0
"""Simulated time [s]."""
NEAR = (3.0, 5.0)
"""Interval of the measurement [s]. At its start all separations have the direction of fastest growth; at its end they
are still a millimeter.
"""


def scene(pendulum_count: int = PENDULUMS) -> pc.Scene:
    """Pendulums at one pivot, without interaction; a single pendulum is the middle one."""
    turns = SPREAD * (np.arange(pendulum_count) / max(pendulum_count - 1, 1) - 0.5 * (pendulum_count > 1))
    return pc.Scene(*pendulums([LENGTH] * RODS, [ANGLE] * RODS, [1.0] * RODS, turns), down())


def main(
    path: str | os.PathLike[str] = "sixfold_pendulum.gif", progress: bool | None = None
) -> dict[str, pc.Recording]:
    """Simulate the scene by RATTLE of order 4, and draw rods and bobs with fading paths."""
    recording = pc.simulate(scene(), DURATION, fps=20, integrator=pc.RATTLE(4), dt=1e-3, progress=progress)
    camera = Window((-1.9, -1.95), (1.9, 0.9))
    options = {"title": "Chains of six rods", "subtitle": "Twenty-four move alike, and a second later all differ"}
    draw(recording, path, fade=0.6, size=(640, 440), camera=camera, progress=progress, **options)
    return {"pendulums": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The rate at which neighbors separate, and the Lyapunov exponent of the middle pendulum over the same time."""
    return parting(recordings["pendulums"], scene(1), PENDULUMS, NEAR)
