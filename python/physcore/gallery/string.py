"""A plucked string: its corner runs to and fro between the ends, and all is as it was after each period.

The physics checked: the period of the lowest tone is twice the length over the speed.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.checks import FloatArray
from physcore.gallery.figure import Figure

DURATION = 6.0
"""[s]"""
LENGTH, SPEED = 1.0, 0.5
"""[m], [m/s]: some hundred times slower than a guitar's."""


def pluck(x: FloatArray) -> FloatArray:
    """Pulled up at a quarter of its length, with a finger's width."""
    corner = 0.25 * LENGTH
    rise, fall = x / corner, (LENGTH - x) / (LENGTH - corner)
    return 0.01 * (rise + fall - np.sqrt((rise - fall) ** 2 + 0.01))


def scene() -> pc.Scene:
    """Let go of a plucked string that air damps a little."""
    line = pc.Grid.over(0.0, LENGTH, 0.0025)
    return pc.Scene(pc.Wave(line, speed=SPEED, displacement=pluck, damping=0.05, name="string"))


def main(path: str | os.PathLike[str] = "string.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=25, progress=progress)
    pc.film(recording, path, size=(560, 320), progress=progress)
    return {"string": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """From one passage of the lowest mode through zero to the next but one."""
    recording = recordings["string"]
    x = recording.scene.systems[0].grid.coordinates[0]  # type: ignore[attr-defined]
    mode = recording["string"].displacement @ np.sin(np.pi * x / LENGTH)
    down = np.flatnonzero((mode[:-1] > 0.0) & (mode[1:] <= 0.0))[:2]
    passages = recording.times[down] + mode[down] / (mode[down] - mode[down + 1]) / recording.fps
    return Figure("period", float(np.diff(passages)[0]), 2.0 * LENGTH / SPEED, "by length and speed", 2e-3, "s")
