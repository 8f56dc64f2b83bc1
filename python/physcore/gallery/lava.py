"""Lava flows down a slope around boulders, slower and slower, and sticks to all that it touches.

The physics checked: nearly all that gravity gives becomes heat at once, and the budget says how much.
"""

from __future__ import annotations

import math
import os

import physcore as pc
from physcore.film import Orbit


def main(path: str | os.PathLike[str] = "lava.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Let go of a heap of lava on a slope of fifteen degrees."""
    spacing, slope = 0.05, math.radians(18.0)
    lava = pc.Fluid(
        pc.cylinder((-1.2, 0.0, 0.0), 0.5, 0.8, spacing), spacing, density=2700.0, viscosity=150.0, sound_speed=25.0
    )
    # The slope lies level and gravity is inclined, as on a tilted table.
    gravity = pc.Gravity((9.81 * math.sin(slope), 0.0, -9.81 * math.cos(slope)))
    boulders = [
        pc.Sphere(center, radius, no_slip=True)
        for center, radius in (((-0.2, 0.35, 0.05), 0.25), ((0.35, -0.35, 0.0), 0.3))
    ]
    scene = pc.Scene(lava, gravity, pc.Floor(no_slip=True), *boulders)
    recording = pc.simulate(scene, duration=6.0, fps=25, progress=progress)
    style = pc.styles.Fluid(colormap="inferno")
    pc.film(recording, path, size=(640, 440), style=style, camera=Orbit(elevation=35.0), progress=progress)
    return {"lava": recording}
