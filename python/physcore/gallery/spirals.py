"""A wave of excitation in a sheet of cells, cut at both ends, curls up into two spirals that turn for ever.

The physics checked: it turns steadily, so that its waves pass all cells equally often.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.gallery.figure import Figure

DURATION = 220.0
"""[s]"""
MEDIUM = pc.FitzHughNagumo(epsilon=0.1, beta=0.5, gamma=0.5)
REST = (-0.8177, -0.6355)
"""u and v where nothing happens."""


def scene() -> pc.Scene:
    """Excite a strip of a sheet that cannot be excited again below it for some time."""
    grid = pc.Grid.over((0.0, 0.0), (130.0, 100.0), 0.5)
    start = {
        "u": lambda x, y: np.where((np.abs(x - 65.0) < 16.0) & (np.abs(y - 50.0) < 4.0), 1.5, REST[0]),
        "v": lambda x, y: np.where((np.abs(x - 65.0) < 16.0) & (np.abs(y - 36.0) < 10.0), REST[1] + 1.2, REST[1]),
    }
    return pc.Scene(pc.ReactionDiffusion(grid, MEDIUM, {"u": 1.0, "v": 0.0}, start))


def main(path: str | os.PathLike[str] = "spirals.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=0.5, precision="f32", progress=progress)
    style = pc.styles.Field(colormap="inferno", range=(-2.6, 2.2), relief=0.3)
    pc.film(recording, path, size=(440, 372), style=style, speed=50.0, progress=progress)
    return {"sheet": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The time between two waves on the left at the end, beside that at the bottom."""
    recording = recordings["sheet"]
    (sheet,) = recording.scene.systems
    u = recording[sheet]["u"]

    def period(values: np.ndarray) -> float:
        rises = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
        parts = -values[rises] / (values[rises + 1] - values[rises])
        return float(np.diff((rises + parts) / recording.fps)[-1])

    return Figure("time between waves", period(u[:, 40, 100]), period(u[:, 130, 30]), "elsewhere", 0.05, "s")
