"""A wave of excitation in a sheet of cells, with two free ends, curls up into two rotating spirals.

The physics checked: the rotation is steady, so that the waves have the same period everywhere.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.gallery.figure import Figure

DURATION = 220.0
"""Simulated time [s]."""
MEDIUM = pc.FitzHughNagumo(epsilon=0.1, beta=0.5, gamma=0.5)
REST = (-0.8177, -0.6355)
"""Values of u and v at rest."""


def scene() -> pc.Scene:
    """An excited strip in a sheet that is refractory below it."""
    grid = pc.Grid.over((0.0, 0.0), (130.0, 100.0), 0.5)
    start = {
        "u": lambda x, y: np.where((np.abs(x - 65.0) < 16.0) & (np.abs(y - 50.0) < 4.0), 1.5, REST[0]),
        "v": lambda x, y: np.where((np.abs(x - 65.0) < 16.0) & (np.abs(y - 36.0) < 10.0), REST[1] + 1.2, REST[1]),
    }
    return pc.Scene(pc.ReactionDiffusion(grid, MEDIUM, {"u": 1.0, "v": 0.0}, start), units=pc.units.dimensionless)


def main(path: str | os.PathLike[str] = "spirals.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=0.25, precision="f32", progress=progress)
    style = pc.styles.Field(colormap="inferno", range=(-2.6, 2.2), relief=0.3)
    pc.film(
        recording,
        path,
        size=(440, 422),
        style=style,
        speed=50.0,
        max_bytes=3_000_000,
        title="Spiral waves",
        subtitle="Excitation in a sheet of cells curls up at its free ends",
        progress=progress,
    )
    return {"sheet": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The period of the waves on the left at the end, compared with that at the bottom."""
    recording = recordings["sheet"]
    (sheet,) = recording.scene.systems
    u = recording[sheet]["u"]

    def period(values: np.ndarray) -> float:
        rises = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
        parts = -values[rises] / (values[rises + 1] - values[rises])
        return float(np.diff((rises + parts) / recording.fps)[-1])

    return Figure("time between waves", period(u[:, 40, 100]), period(u[:, 130, 30]), "elsewhere", 0.05)
