"""Fifteen pendulums start together, form waves, and meet again after a whole number of swings of each.

The physics checked: the period of the longest pendulum is that given by its length and amplitude.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure
from physcore.gallery.means import arithmetic_geometric

PENDULUMS, SWINGS = 15, 16
"""Number of pendulums, and number of swings of the longest one until they meet. Each shorter pendulum has one swing
more.
"""
ANGLE = math.radians(25.0)
"""Initial angle [rad]."""

DURATION = 20.0
"""Simulated time, until the pendulums meet [s]."""


def stretch() -> float:
    """The ratio of the period at this amplitude to the period of small oscillations.

    The ratio is 1/M(1, cos θ/2), with the arithmetic–geometric mean M.
    """
    return 1.0 / arithmetic_geometric(1.0, math.cos(ANGLE / 2.0))


def scene() -> pc.Scene:
    """A row of pendulums on nearly inextensible wires, with lengths that follow from their periods."""
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
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=8, progress=progress)
    # Colors from the longest to the shortest pendulum, for wires and bobs alike.
    style = pc.styles.Strain(color=np.tile(np.arange(PENDULUMS), 2), width=1.6)
    camera = Orbit(-28.0, 14.0)
    pc.film(
        recording,
        path,
        size=(528, 370),
        style=style,
        camera=camera,
        color_bar=False,
        speed=2.0,
        quality="high",
        max_bytes=3_000_000,
        title="Pendulum waves",
        subtitle="Fifteen pendulums drift apart, and meet again",
        progress=progress,
    )
    return {"pendulums": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Period of the longest pendulum, from its first to its last passage through the middle."""
    times, x = recordings["pendulums"].times, recordings["pendulums"].positions[:, PENDULUMS, 0]
    after = np.flatnonzero((x[:-1] > 0.0) & (x[1:] <= 0.0))
    crossings = times[after] + x[after] / (x[after] - x[after + 1]) * (times[1] - times[0])
    period = (crossings[-1] - crossings[0]) / (len(crossings) - 1)
    return Figure("period of the longest", period, DURATION / SWINGS, "by theory", 1e-3, "s")
