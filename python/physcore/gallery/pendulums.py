"""Fifteen pendulums start together, drift apart into waves, and meet again when each has swung a whole number of times.

The physics checked: the longest one's period is that of a pendulum of its length and amplitude.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure

PENDULUMS, SWINGS = 15, 16
"""How many there are, and how often the longest one swings until they meet; each of the others once more than the one
before it."""
ANGLE = math.radians(25.0)
"""From which they are let go."""

DURATION = 20.0
"""Until they meet [s]."""


def stretch() -> float:
    """The period of a pendulum with this amplitude over that of small swings.

    It is 1/M(1, cos θ/2), M the arithmetic-geometric mean; C. F. Gauss, 1799.
    """
    one, other = 1.0, math.cos(ANGLE / 2.0)
    for _ in range(6):
        one, other = (one + other) / 2.0, math.sqrt(one * other)
    return 1.0 / one


def scene() -> pc.Scene:
    """Hang them in a row, each as long as its period requires, on wires that hardly give."""
    swings = SWINGS + np.arange(PENDULUMS)
    lengths = 9.81 * (DURATION / swings / stretch() / (2.0 * np.pi)) ** 2
    pivots = np.stack([np.zeros(PENDULUMS), 0.09 * np.arange(PENDULUMS), np.zeros(PENDULUMS)], axis=1)
    bobs = pivots + lengths[:, np.newaxis] * np.array([math.sin(ANGLE), 0.0, -math.cos(ANGLE)])
    wires = pc.SpringNetwork(
        np.concatenate([pivots, bobs]),
        [(index, index + PENDULUMS) for index in range(PENDULUMS)],
        stiffness=1e5,
        mass=0.5,
        radius=np.repeat([0.006, 0.04], PENDULUMS),
        fixed=np.arange(PENDULUMS),
    )
    floor = pc.Floor(-float(lengths.max()) - 0.12)
    return pc.Scene(wires, pc.Gravity((0.0, 0.0, -9.81)), floor)


def main(path: str | os.PathLike[str] = "pendulums.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=8, progress=progress)
    # From the longest to the shortest, wires and bobs alike.
    style = pc.styles.Strain(color=np.tile(np.arange(PENDULUMS), 2), colormap="plasma", width=1.6)
    camera = Orbit(-28.0, 14.0)
    pc.film(
        recording,
        path,
        size=(528, 330),
        style=style,
        camera=camera,
        color_bar=False,
        speed=2.0,
        quality="high",
        progress=progress,
    )
    return {"pendulums": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The period of the longest one, between the first and the last time that it comes through the middle."""
    times, x = recordings["pendulums"].times, recordings["pendulums"].positions[:, PENDULUMS, 0]
    after = np.flatnonzero((x[:-1] > 0.0) & (x[1:] <= 0.0))
    crossings = times[after] + x[after] / (x[after] - x[after + 1]) * (times[1] - times[0])
    period = (crossings[-1] - crossings[0]) / (len(crossings) - 1)
    return Figure("period of the longest", period, DURATION / SWINGS, "by theory", 1e-3, "s")
