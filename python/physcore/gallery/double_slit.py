"""A plane wave passes through two slits; dark fringes appear where the paths differ by half a wavelength.

The physics checked: the first dark fringes on a far screen are at the positions given by the path difference.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure

DURATION = 11.0
"""Simulated time [s]."""
WAVELENGTH, APART, OPENING = 0.5, 2.0, 0.25
"""Wavelength, distance between the centers of the slits, and width of each slit [m]."""
SCREEN = 6.5
"""Distance of the screen behind the slits [m]."""


def scene() -> pc.Scene:
    """A row of oscillating cells in front of a wall with two slits."""
    plane = pc.Grid.over((-2.0, -5.0), (7.0, 5.0), 0.04)
    x, y = plane.coordinates
    wall = (np.abs(x) < 0.05) & (np.abs(np.abs(y) - APART / 2) > OPENING / 2)
    lamp = pc.Source(np.abs(x + 1.5) < 0.02, amplitude=20.0, frequency=1.0 / WAVELENGTH, phase=math.pi / 2)
    return pc.Scene(pc.Wave(plane, speed=1.0, walls=wall, sources=lamp, edges="absorbing"))


def main(path: str | os.PathLike[str] = "double_slit.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=6, progress=progress)
    pc.film(
        recording,
        path,
        size=(400, 468),
        style=pc.styles.Field(range=0.028),
        camera=Window((-0.5, -4.0), (7.0, 4.0)),
        speed=2.0,
        max_bytes=3_000_000,
        title="Two slits",
        subtitle="Dark where the paths differ by half a wave",
        progress=progress,
    )
    return {"light": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Distance of the first dark fringe from the middle of the screen, and its value where the paths differ by half a
    wavelength.
    """
    recording = recordings["light"]
    (wave,) = recording.scene.grids
    column = round((SCREEN - wave.grid.origin[0]) / wave.grid.spacing)
    periods = round(4 * WAVELENGTH * recording.fps)  # four periods in the steady state
    heights = wave.grid.coordinates[1][column]
    brightness = np.mean(recording[wave].displacement[-periods:, column] ** 2, axis=0)
    near = np.abs(heights) < 1.5 * SCREEN * WAVELENGTH / APART
    upper, lower = (heights[side][np.argmin(brightness[side])] for side in (near & (heights > 0), near & (heights < 0)))
    distance = SCREEN + wave.grid.spacing / 2
    paths = np.hypot(distance, heights + APART / 2) - np.hypot(distance, heights - APART / 2)
    expected = float(np.interp(WAVELENGTH / 2, paths, heights))
    return Figure("first dark place on the screen", float(upper - lower) / 2, expected, "by the paths", 0.05, "m")
