"""A drop falls into milk and throws up a crown and a jet, eight times slower than in life.

It is as large as a head, and its surface tension as much larger than that of milk: the Weber number ρv²D/σ is that of
a drop of 5 mm at 4 m/s.

The physics checked: the fall of the drop is all the energy there is, and no bead of the crown is lost.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.checks import FloatArray
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget
from physcore.gallery.rotation import rotation

DURATION = 0.55
"""[s]"""
METHOD = pc.WeaklyCompressible(kernel=pc.WendlandC2(smoothing=1.25))
"""How the milk is computed."""
WEBER = 1650.0
"""ρv²D/σ of a drop of milk, 1030 · 4² · 0.005/0.05."""
RADIUS, SPEED = 0.09, 5.0
"""Of the drop [m] and [m/s]."""


def scene() -> pc.Scene:
    """Let a drop hit a pool nearly as deep as the drop is wide."""
    spacing = 1 / 60
    tension = 1000.0 * SPEED**2 * 2.0 * RADIUS / WEBER

    def milk(places: FloatArray, speed: float, name: str) -> pc.Fluid:
        velocity = (0.0, 0.0, -speed)
        return pc.Fluid(places, spacing, velocities=velocity, surface_tension=tension, name=name)

    half, deep = 24 * spacing, 9 * spacing
    pool = milk(pc.block((-half, -half, 0.0), (half, half, deep), spacing), 0.0, "pool")
    # Turned, so that the two lattices have no direction in common, which a crown would show.
    ball = pc.ball((0.0, 0.0, 0.0), RADIUS, spacing) @ rotation((1.0, 2.0, 3.0), 1.0)
    drop = milk(ball + np.array([0.0, 0.0, deep + spacing + RADIUS]), SPEED, "drop")
    tank = pc.Box((-half, -half, 0.0), (half, half, 0.5))
    return pc.Scene(pool, drop, pc.Gravity((0.0, 0.0, -9.81)), tank)


def main(path: str | os.PathLike[str] = "splash.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=200, progress=progress, fluids=METHOD)
    style = pc.styles.Fluid({"pool": "#f7f5ee", "drop": "#e8485f"}, opacity=1.0)
    camera = Orbit(elevation=24.0, target=(0.0, 0.0, 0.15), extent=0.85)
    pc.film(recording, path, size=(560, 392), style=style, camera=camera, speed=0.125, progress=progress)
    return {"splash": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The fall of the drop is all there."""
    return budget(recordings, bound=1e-2)
