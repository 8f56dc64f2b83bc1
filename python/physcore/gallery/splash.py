"""A drop falls into milk, which forms a crown and a jet, eight times slower than real time.

The drop has the size of a head. Its surface tension is larger than that of milk, such that the Weber number ρv²D/σ is
that of a drop of 5 mm at 4 m/s.

The physics checked: the energy of the falling drop accounts for all energy, and no droplet of the crown is lost.
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
"""Simulated time [s]."""
METHOD = pc.WeaklyCompressible(kernel=pc.WendlandC2(smoothing=1.25))
"""Method of the fluid."""
WEBER = 1650.0
"""Weber number ρv²D/σ of a drop of milk, 1030 · 4² · 0.005/0.05."""
RADIUS, SPEED = 0.09, 5.0
"""Radius [m] and speed [m/s] of the drop."""


def scene() -> pc.Scene:
    """A drop above a pool that is nearly as deep as the drop is wide."""
    spacing = 1 / 60
    tension = 1000.0 * SPEED**2 * 2.0 * RADIUS / WEBER

    def milk(places: FloatArray, speed: float, name: str) -> pc.Fluid:
        velocity = (0.0, 0.0, -speed)
        return pc.Fluid(places, spacing, velocities=velocity, surface_tension=tension, name=name)

    half, deep = 24 * spacing, 9 * spacing
    pool = milk(pc.block((-half, -half, 0.0), (half, half, deep), spacing), 0.0, "pool")
    # Rotated, so that the two lattices have no common direction, which would be visible in the crown.
    ball = pc.ball((0.0, 0.0, 0.0), RADIUS, spacing) @ rotation((1.0, 2.0, 3.0), 1.0)
    drop = milk(ball + np.array([0.0, 0.0, deep + spacing + RADIUS]), SPEED, "drop")
    tank = pc.Box((-half, -half, 0.0), (half, half, 0.5))
    return pc.Scene(pool, drop, pc.Gravity((0.0, 0.0, -9.81)), tank)


def main(path: str | os.PathLike[str] = "splash.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=200, progress=progress, fluids=METHOD)
    style = pc.styles.Fluid({"pool": "#f7f5ee", "drop": "#e8485f"}, opacity=1.0)
    camera = Orbit(elevation=24.0, target=(0.0, 0.0, 0.19), extent=0.9)
    pc.film(
        recording,
        path,
        size=(560, 428),
        style=style,
        camera=camera,
        speed=0.125,
        max_bytes=3_000_000,
        title="A crown of milk",
        subtitle="A drop falls into a layer, which throws up a rim and a jet",
        progress=progress,
    )
    return {"splash": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy of the falling drop with its final forms."""
    return budget(recordings, bound=1e-2)
