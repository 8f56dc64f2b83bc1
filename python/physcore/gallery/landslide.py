"""A hundred and eighty rocks run down a hillside into a lake, and throw up a wave.

The physics checked: the budget closes over collisions of rocks, ground and water, and nothing is below the ground.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.checks import FloatArray
from physcore.film import DARK, Orbit
from physcore.gallery.figure import Figure, budget

ROCKS = 180
"""Number of rocks."""
RADIUS = 0.028
"""Radius of a rock [m]."""
SPACING = 0.042
"""Spacing of the water [m]."""
LEVEL = 0.1
"""Height of the lake's surface [m]."""
METHOD = pc.WeaklyCompressible(sound_speed=30.0)
"""Method of the water. The fastest drops, which rocks throw up, have 3 m/s."""
SHORE = -0.25
"""Where the slope, on which only rocks are, meets the bed of the lake: x [m]."""

DURATION = 2.0
"""Simulated time [s]."""


def height(x: FloatArray, y: FloatArray) -> FloatArray:
    """Height of the ground [m]: a slope along x, with a winding valley, a hollow, and a rim around the edge."""
    valley = y - 0.22 * np.sin(4.0 * x)
    side = 0.5 / (1.0 + np.exp(4.0 * (x + 0.2))) + 0.06 * (1.0 - x)
    banks = 0.45 * valley**2 + 0.03 * np.cos(9.0 * y) * np.sin(8.0 * x)
    hollow = -0.22 * np.exp(-((x - 0.72) ** 2 + (y - 0.1) ** 2) / 0.11)
    rim = 0.25 * (np.abs(x) / 1.15) ** 14
    return np.asarray(side + banks + hollow + rim)


def scene() -> pc.Scene:
    """A heap of rocks high on the slope, initially at rest, above a lake."""
    generator = np.random.default_rng(4)
    sites = pc.block((-1.0, -0.5, 0.0), (-0.5, 0.5, 0.5), 2.4 * RADIUS)
    sites = sites[generator.permutation(len(sites))[:ROCKS]]
    sites[:, 2] += 0.15 + height(sites[:, 0], sites[:, 1])
    rocks = pc.RigidBodies(pc.Ball(RADIUS), sites, density=2500.0, friction=0.4, restitution=0.2, name="rocks")
    slope = pc.HeightField.over(height, (-1.2, -0.9), (SHORE, 0.9), 0.05, restitution=0.2, friction=0.4, on=rocks)
    bed = pc.HeightField.over(height, (SHORE, -0.9), (1.2, 0.9), 0.05).solid(0.04, friction=0.4, restitution=0.2)
    lake = pc.block((0.1, -0.7, -0.3), (1.15, 0.85, LEVEL), SPACING)
    lake = lake[lake[:, 2] > height(lake[:, 0], lake[:, 1]) + 0.5 * SPACING]
    return pc.Scene(rocks, pc.Fluid(lake, SPACING, name="lake"), bed, slope, pc.Gravity((0.0, 0.0, -9.81)))


def main(path: str | os.PathLike[str] = "landslide.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=25, progress=progress, fluids=METHOD)
    rocks, lake, bed = recording.scene.bodies
    style = [
        pc.styles.Fluid("#2f7fb5", opacity=0.55, on=lake),
        pc.styles.Solids("#c9a27a", on=rocks),
        pc.styles.Solids(DARK.solid, marks=False, on=bed),
    ]
    pc.film(
        recording,
        path,
        size=(640, 470),
        style=style,
        camera=Orbit(azimuth=-68.0, elevation=40.0, target=(0.06, 0.0, 0.22), extent=2.2),
        max_bytes=3_000_000,
        title="A landslide",
        subtitle="Rocks run down a hillside into a lake",
        progress=progress,
    )
    return {"rocks": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms."""
    return budget(recordings, bound=2e-2)
