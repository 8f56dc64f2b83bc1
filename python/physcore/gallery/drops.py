"""Two drops of water collide in weightlessness, coalesce, and oscillate; eight times slower than real time.

The physics checked: the resulting drop has the surface energy of a ball.
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
"""Simulated time [s]."""
METHOD = pc.WeaklyCompressible(sound_speed=3.0)
"""Method of the fluid. The colliding drops are faster than the default, based on surface tension alone, assumes."""
TENSION = 0.072
"""Surface tension of water [N/m]."""
RADIUS, SPACING, SPEED = 8e-3, 1e-3, 0.06
"""Radius of each drop [m], spacing of the particles [m], and speed of each drop [m/s]."""


def scene() -> pc.Scene:
    """Two drops of two cubic centimeters in a slightly off-center collision."""

    def drop(side: float, angle: float, name: str) -> pc.Fluid:
        # Rotated, so that the two lattices have no common direction.
        ball: FloatArray = pc.ball((0.0, 0.0, 0.0), RADIUS, SPACING) @ rotation((1.0, 2.0, 3.0), angle)
        places = ball + side * np.array([RADIUS + 2.0 * SPACING, 0.0, 0.2 * RADIUS])
        velocity = (-side * SPEED, 0.0, 0.0)
        return pc.Fluid(places, SPACING, velocities=velocity, surface_tension=TENSION, name=name)

    return pc.Scene(drop(-1.0, 0.7, "left"), drop(1.0, 2.0, "right"))


def main(path: str | os.PathLike[str] = "drops.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=160, progress=progress, fluids=METHOD)
    style = pc.styles.Fluid({"left": "#4aa3e8", "right": "#f0b445"}, opacity=1.0)
    pc.film(
        recording,
        path,
        size=(560, 430),
        style=style,
        camera=Orbit(elevation=12.0),
        speed=0.125,
        max_bytes=3_000_000,
        title="Two drops of water",
        subtitle="In weightlessness they collide, coalesce and oscillate",
        progress=progress,
    )
    return {"drops": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The surface energy in the last tenth of the time, and 4πR²σ for a ball of both drops."""
    recording = recordings["drops"]
    surface = recording.energy.by_term["surface tension"]
    radius = (0.75 * recording.positions.shape[1] * SPACING**3 / math.pi) ** (1.0 / 3.0)
    ball = 4.0 * math.pi * radius**2 * TENSION
    found = float(surface[recording.times > 0.9 * DURATION].mean())
    return Figure("energy of the surface", 1e6 * found, 1e6 * ball, "for a ball of both drops", 0.1, "µJ")
