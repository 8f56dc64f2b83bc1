"""Two drops of water meet where there is no weight, become one, and swing, eight times slower than in life.

The physics checked: the surface of the drop that they become has the energy of a ball's.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.checks import FloatArray
from physcore.film import Orbit
from physcore.gallery.figure import Figure
from physcore.gallery.rotation import rotation

DURATION = 0.75
"""[s]"""
METHOD = pc.WeaklyCompressible(sound_speed=3.0)
"""How the water is computed: where drops meet it is faster than tension alone lets one expect."""
TENSION = 0.072
"""Of water [N/m]."""
RADIUS, SPACING, SPEED = 8e-3, 1e-3, 0.06
"""Of each drop [m], of its particles [m], and how fast each comes [m/s]."""


def scene() -> pc.Scene:
    """Let two drops of two cubic centimeters meet, not quite head-on."""

    def drop(side: float, angle: float, name: str) -> pc.Fluid:
        # Turned, so that the two lattices have no direction in common.
        ball: FloatArray = pc.ball((0.0, 0.0, 0.0), RADIUS, SPACING) @ rotation((1.0, 2.0, 3.0), angle)
        places = ball + side * np.array([RADIUS + 2.0 * SPACING, 0.0, 0.2 * RADIUS])
        velocity = (-side * SPEED, 0.0, 0.0)
        return pc.Fluid(places, SPACING, velocities=velocity, surface_tension=TENSION, name=name)

    return pc.Scene(drop(-1.0, 0.7, "left"), drop(1.0, 2.0, "right"))


def main(path: str | os.PathLike[str] = "drops.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=160, progress=progress, fluids=METHOD)
    style = pc.styles.Fluid({"left": "#4aa3e8", "right": "#f0b445"}, opacity=1.0)
    pc.film(recording, path, size=(560, 392), style=style, camera=Orbit(elevation=12.0), speed=0.125, progress=progress)
    return {"drops": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The energy of the surface in the last tenth of the time, 4πR²σ for the ball of both."""
    recording = recordings["drops"]
    surface = recording.energy.by_term["surface tension"]
    radius = (0.75 * recording.positions.shape[1] * SPACING**3 / math.pi) ** (1.0 / 3.0)
    ball = 4.0 * math.pi * radius**2 * TENSION
    found = float(surface[recording.times > 0.9 * DURATION].mean())
    return Figure("energy of the surface", 1e6 * found, 1e6 * ball, "for a ball of both drops", 0.1, "µJ")
