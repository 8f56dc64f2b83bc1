"""A lump of lava flows down a slope around boulders, slows down, and sticks to all surfaces.

The physics checked: nearly all energy released by gravity becomes heat at once, and the budget closes.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget

DURATION = 5.0
"""Simulated time [s]."""
METHOD = pc.WeaklyCompressible(sound_speed=30.0, kernel=pc.WendlandC2(smoothing=1.25))
"""Method of the fluid."""


def scene() -> pc.Scene:
    """1.5 tons of lava on a slope of fifteen degrees, initially at rest."""
    spacing, slope = 0.05, math.radians(15.0)
    up = (math.sin(slope), 0.0, math.cos(slope))
    lava = pc.Fluid(
        pc.ball((-0.8 + 0.5 * up[0], 0.0, 0.8 * math.tan(slope) + 0.5 * up[2]), 0.5, spacing),
        spacing,
        density=2700.0,
        viscosity=800.0,
    )
    ground = pc.Plane((0.0, 0.0, 0.0), up, no_slip=True)
    boulders = [
        pc.Sphere((x, y, -x * math.tan(slope)), radius, no_slip=True)
        for x, y, radius in ((0.1, 0.4, 0.25), (0.35, -0.3, 0.3))
    ]
    return pc.Scene(lava, pc.Gravity((0.0, 0.0, -9.81)), ground, *boulders)


def main(path: str | os.PathLike[str] = "lava.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=20, progress=progress, fluids=METHOD)
    camera = Orbit(azimuth=-40.0, elevation=28.0, target=(-0.05, 0.0, 0.34), extent=2.2)
    style = pc.styles.Fluid(colormap="ember", top=0.45, opacity=1.0, glow=0.8)
    pc.film(
        recording,
        path,
        size=(600, 440),
        style=style,
        camera=camera,
        quality="high",
        max_bytes=3_000_000,
        title="Lava",
        subtitle="It flows around boulders, slows down, and sticks",
        progress=progress,
    )
    return {"lava": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms, nearly all of it heat."""
    return budget(recordings, bound=2e-2)
