"""One electron goes through two slits, and is seen behind them where both ways are in step.

The physics checked: the first dark places on a circle behind the slits are where the ways differ by half a wavelength.
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
"""[s]"""
MOMENTUM = 6.0
"""ħ = m = 1, so that the wavelength is 2π/6."""
APART, OPENING = 3.0, 0.7
"""Of the slits, from center to center, and of each [m]."""
SCREEN = 6.0
"""Where the electron is looked for, behind the slits [m]."""


def scene() -> pc.Scene:
    """Let a packet run against a wall with two slits, in a room that is open on all sides."""
    room = pc.Grid.over((-12.0, -9.0), (12.0, 9.0), 0.1)
    packet = pc.wave_packet(room, (-6.5, 0.0), (MOMENTUM, 0.0), (1.6, 2.6))

    def wall(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        shut = np.abs(np.abs(y) - APART / 2) > OPENING / 2
        height: np.ndarray = 200.0 * ((np.abs(x) < 0.2) & shut)
        return height

    return pc.Scene(pc.Schrodinger(room, packet, potential=wall, edges="absorbing", name="electron"))


def main(path: str | os.PathLike[str] = "electron_slits.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=30, dt=0.004, progress=progress)
    style, camera = pc.styles.Phase(range=0.012), Window((-9.0, -6.6), (9.0, 6.6))
    pc.film(recording, path, size=(396, 322), style=style, camera=camera, speed=0.5, progress=progress)
    return {"electron": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """How far from the middle the screen is first dark, over all times, and where the ways differ by half a wave."""
    recording = recordings["electron"]
    (electron,) = recording.scene.systems
    assert isinstance(electron, pc.Schrodinger)
    grid = electron.grid
    heights = grid.coordinates[1][0]
    column = round((SCREEN - grid.origin[0]) / grid.spacing)
    seen = recording[electron].density[:, column].sum(axis=0)
    waves = 2.0 * math.pi / MOMENTUM
    near = np.abs(heights) < 1.5 * SCREEN * waves / APART
    upper, lower = (heights[side][np.argmin(seen[side])] for side in (near & (heights > 0), near & (heights < 0)))
    paths = np.hypot(SCREEN, heights + APART / 2) - np.hypot(SCREEN, heights - APART / 2)
    expected = float(np.interp(waves / 2, paths, heights))
    return Figure("first dark place on the screen", float(upper - lower) / 2, expected, "by the ways", 0.1, "m")
