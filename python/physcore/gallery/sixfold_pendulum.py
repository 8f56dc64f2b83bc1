"""Twenty-four chains of six rods hang on to one motion for five seconds, and a second later none is like another.

The physics checked: while they are close together, they part as fast as neighbors do by their Lyapunov exponent.
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
"""Of a pendulum, and of a rod [m]."""
ANGLE, SPREAD = math.radians(95.0), math.radians(1e-6)
"""Of all rods at the start, from below, and between the upper rods of the first pendulum and the last."""

DURATION = 9.0
"""[s]"""
NEAR = (3.0, 5.0)
"""When all have turned to the direction in which they part, and when they are still a millimeter apart [s]."""


def scene(pendulum_count: int = PENDULUMS) -> pc.Scene:
    """All hang from one point and do not feel each other; of one alone, that in the middle."""
    turns = SPREAD * (np.arange(pendulum_count) / max(pendulum_count - 1, 1) - 0.5 * (pendulum_count > 1))
    return pc.Scene(*pendulums([LENGTH] * RODS, [ANGLE] * RODS, [1.0] * RODS, turns), down())


def main(
    path: str | os.PathLike[str] = "sixfold_pendulum.gif", progress: bool | None = None
) -> dict[str, pc.Recording]:
    """Simulate it by RATTLE of order 4, and draw rods and bobs with light behind them."""
    recording = pc.simulate(scene(), DURATION, fps=20, integrator=pc.RATTLE(4), dt=1e-3, progress=progress)
    camera = Window((-1.9, -1.95), (1.9, 0.9))
    draw(recording, path, fade=0.6, size=(520, 420), camera=camera, progress=progress)
    return {"pendulums": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """How fast neighbors part, and the Lyapunov exponent of the pendulum in the middle over the same time."""
    return parting(recordings["pendulums"], scene(1), PENDULUMS, NEAR)
