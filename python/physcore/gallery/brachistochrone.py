"""Beads released at any height of a cycloid reach its lowest point together, before one on the straight way.

The physics checked: the time to the lowest point is π √(R/g) from every height (C. Huygens, 1673).
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.checks import FloatArray
from physcore.gallery.figure import Figure

RADIUS = 1.0
"""Radius R of the circle that generates the cycloid [m]."""
STARTS = (0.02, 0.9, 1.6, 2.3)
"""Where beads are released: angles by which the circle has rolled [rad]. The lowest point is at π."""
GRAVITY = 9.81
"""Acceleration of free fall [m/s²]."""

DURATION = 1.4
"""Simulated time [s]."""


def cycloid(turns: FloatArray) -> FloatArray:
    """Points of the cycloid [m] at angles by which the circle has rolled [rad]."""
    return RADIUS * np.column_stack([turns - np.sin(turns), np.cos(turns) - 1.0])


def scene() -> pc.Scene:
    """Beads on a cycloid up to its lowest point, and one on the straight line to there."""
    beads = pc.Particles(cycloid(np.array(STARTS)), mass=0.1, radius=0.07, name="cycloid")
    other = pc.Particles(cycloid(np.array(STARTS[:1])), mass=0.1, radius=0.07, name="line")
    wires = (
        pc.Wire(cycloid(np.linspace(0.0, 2.0 * np.pi, 301)), on=beads),
        pc.Wire([other.positions[0], 1.6 * cycloid(np.array([np.pi]))[0] - 0.6 * other.positions[0]], on=other),
    )
    return pc.Scene(beads, other, *wires, pc.Gravity((0.0, -GRAVITY)))


def main(path: str | os.PathLike[str] = "brachistochrone.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film, four times slower than real time."""
    recording = pc.simulate(scene(), duration=DURATION, fps=60, dt=DURATION / 8400, progress=progress)
    pc.film(
        recording,
        path,
        size=(528, 392),
        style=pc.styles.Points("body", size=13.0, trail=0.25, glow=0.5),
        speed=0.25,
        title="The fastest way down",
        subtitle="From any height of the cycloid beads arrive together",
        progress=progress,
    )
    return {"brachistochrone": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Time to the lowest point of the bead that starts highest."""
    recording = recordings["brachistochrone"]
    x = recording["cycloid"].positions[:, 0, 0]
    after = int(np.argmax(x > math.pi * RADIUS))
    step = recording.times[1] - recording.times[0]
    passed = recording.times[after] - step * (x[after] - math.pi * RADIUS) / (x[after] - x[after - 1])
    # From an angle θ on, the speed is the same as from 0 but for the height: the time is π √(R/g) from every θ.
    return Figure("time to the lowest point", passed, math.pi * math.sqrt(RADIUS / GRAVITY), "by theory", 2e-3, "s")
