"""A plucked string is the sum of its harmonics: each oscillates at its own period, and all repeat after the longest.

The physics checked: the period of the fundamental is twice the length over the speed.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.checks import FloatArray
from physcore.gallery.figure import Figure

LENGTH, SPEED = 1.0, 0.5
"""Length [m] and wave speed [m/s] of the string; the speed is some hundred times lower than on a guitar."""
HARMONICS = 4
"""Number of harmonics shown."""
HEIGHT = 0.015
"""Height of the string where it is plucked [m]."""
DURATION = 2.0 * LENGTH / SPEED
"""Simulated time: one period [s]."""


def pluck(x: FloatArray) -> FloatArray:
    """Initial shape: a triangle with a rounded corner at a quarter of the length."""
    corner = 0.25 * LENGTH
    rise, fall = x / corner, (LENGTH - x) / (LENGTH - corner)
    return 0.5 * HEIGHT * (rise + fall - np.sqrt((rise - fall) ** 2 + 0.01))


def scene() -> pc.Scene:
    """A plucked string at rest, and strings with its harmonics, b sin(nπx/L) with b = 2⟨u sin(nπx/L)⟩."""
    line = pc.Grid.over(0.0, LENGTH, 0.0025)
    (x,) = line.coordinates
    shapes = [np.sin(n * np.pi * x / LENGTH) for n in range(1, HARMONICS + 1)]
    harmonics = [
        pc.Wave(line, speed=SPEED, displacement=2.0 * np.mean(pluck(x) * shape) * shape, name=f"harmonic {n}")
        for n, shape in enumerate(shapes, 1)
    ]
    return pc.Scene(pc.Wave(line, speed=SPEED, displacement=pluck, name="string"), *harmonics)


def main(path: str | os.PathLike[str] = "string.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate one period, and draw the string with a thick line and its harmonics with thin ones, on one scale."""
    recording = pc.simulate(scene(), duration=DURATION, fps=25, progress=progress)
    string, *harmonics = recording.scene.systems
    style = [pc.styles.Line(range=HEIGHT, width=4.0, on=string), pc.styles.Line(range=HEIGHT, width=1.4, on=harmonics)]
    pc.film(
        recording,
        path,
        size=(640, 404),
        style=style,
        title="A plucked string",
        subtitle="Blue: the string; the others: its first harmonics",
        progress=progress,
    )
    return {"string": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Period: twice the time between two successive zeros of the lowest mode."""
    recording = recordings["string"]
    x = recording.scene.systems[0].grid.coordinates[0]  # type: ignore[attr-defined]
    mode = recording["string"].displacement @ np.sin(np.pi * x / LENGTH)
    before = np.flatnonzero(mode[:-1] * mode[1:] < 0.0)[:2]
    passages = recording.times[before] + mode[before] / (mode[before] - mode[before + 1]) / recording.fps
    return Figure("period", 2.0 * float(np.diff(passages)[0]), 2.0 * LENGTH / SPEED, "by length and speed", 2e-3, "s")
