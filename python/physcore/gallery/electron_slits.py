"""One electron passes through two slits, and interferes with itself behind them.

The physics checked: on a screen behind the slits, the first dark fringes are where paths differ by half a wavelength.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure

DURATION = 2.9
"""Simulated time [s]."""
MOMENTUM = 6.0
"""Momentum; with ħ = m = 1 the wavelength is 2π/6."""
APART, OPENING = 3.0, 0.7
"""Distance between the centers of the slits, and width of each slit [m]."""
SCREEN = 6.0
"""Distance of the screen behind the slits [m]."""


def scene() -> pc.Scene:
    """A wave packet that meets a wall with two slits, in a room with absorbing edges."""
    room = pc.Grid.over((-12.0, -9.0), (12.0, 9.0), 0.1)
    packet = pc.wave_packet(room, (-6.5, 0.0), (MOMENTUM, 0.0), (1.6, 2.6))

    def wall(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        shut = np.abs(np.abs(y) - APART / 2) > OPENING / 2
        height: np.ndarray = 200.0 * ((np.abs(x) < 0.2) & shut)
        return height

    return pc.Scene(
        pc.Schrodinger(room, packet, potential=wall, edges="absorbing", name="electron"), units=pc.units.dimensionless
    )


def main(path: str | os.PathLike[str] = "electron_slits.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=30, dt=0.004, progress=progress)
    style, camera = pc.styles.Phase(range=0.012), Window((-9.0, -6.6), (9.0, 6.6))
    pc.film(
        recording,
        path,
        size=(396, 370),
        style=style,
        camera=camera,
        speed=0.5,
        max_bytes=3_000_000,
        title="One electron, two slits",
        subtitle="It interferes with itself",
        progress=progress,
    )
    return {"electron": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Distance of the first dark fringe from the middle of the screen, over all times, and its value from the path
    difference.
    """
    recording = recordings["electron"]
    (electron,) = recording.scene.grids
    grid = electron.grid
    heights = grid.coordinates[1][0]
    column = round((SCREEN - grid.origin[0]) / grid.spacing)
    seen = recording[electron].density[:, column].sum(axis=0)
    waves = 2.0 * math.pi / MOMENTUM
    near = np.abs(heights) < 1.5 * SCREEN * waves / APART
    upper, lower = (heights[side][np.argmin(seen[side])] for side in (near & (heights > 0), near & (heights < 0)))
    paths = np.hypot(SCREEN, heights + APART / 2) - np.hypot(SCREEN, heights - APART / 2)
    expected = float(np.interp(waves / 2, paths, heights))
    return Figure("first dark place on the screen", float(upper - lower) / 2, expected, "by the ways", 0.1)
