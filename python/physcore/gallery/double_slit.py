"""A plane wave passes through two slits; behind them it is dark where one path is half a wavelength longer.

The physics checked: the first dark places on a far screen are where the difference of the paths says.
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
"""[s]"""
WAVELENGTH, APART, OPENING = 0.5, 2.0, 0.25
"""Of the light, of the slits from center to center, and of each of them [m]."""
SCREEN = 6.5
"""How far the screen is behind the slits [m]."""


def scene() -> pc.Scene:
    """Let a row of cells swing in front of a wall with two slits."""
    plane = pc.Grid.over((-2.0, -5.0), (7.0, 5.0), 0.04)
    x, y = plane.coordinates
    wall = (np.abs(x) < 0.05) & (np.abs(np.abs(y) - APART / 2) > OPENING / 2)
    lamp = pc.Source(np.abs(x + 1.5) < 0.02, amplitude=20.0, frequency=1.0 / WAVELENGTH, phase=math.pi / 2)
    return pc.Scene(pc.Wave(plane, speed=1.0, walls=wall, sources=lamp, edges="absorbing"))


def main(path: str | os.PathLike[str] = "double_slit.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=10, progress=progress)
    pc.film(
        recording,
        path,
        size=(400, 420),
        style=pc.styles.Field(range=0.028),
        camera=Window((-0.5, -4.0), (7.0, 4.0)),
        speed=2.0,
        progress=progress,
    )
    return {"light": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """How far from the middle of the screen it is first dark, and where the paths differ by half a wavelength."""
    recording = recordings["light"]
    (wave,) = recording.scene.systems
    assert isinstance(wave, pc.Wave)
    column = round((SCREEN - wave.grid.origin[0]) / wave.grid.spacing)
    periods = round(4 * WAVELENGTH * recording.fps)  # four of them, after all is steady
    heights = wave.grid.coordinates[1][column]
    brightness = np.mean(recording[wave].displacement[-periods:, column] ** 2, axis=0)
    near = np.abs(heights) < 1.5 * SCREEN * WAVELENGTH / APART
    upper, lower = (heights[side][np.argmin(brightness[side])] for side in (near & (heights > 0), near & (heights < 0)))
    distance = SCREEN + wave.grid.spacing / 2
    paths = np.hypot(distance, heights + APART / 2) - np.hypot(distance, heights - APART / 2)
    expected = float(np.interp(WAVELENGTH / 2, paths, heights))
    return Figure("first dark place on the screen", float(upper - lower) / 2, expected, "by the paths", 0.05, "m")
