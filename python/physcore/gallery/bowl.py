"""A hundred thousand particles bounce in a bowl.

The physics checked: each bounce loses the energy given by the restitution, and the budget closes over millions of
bounces.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget

DURATION = 4.0
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """Drop a cube of dust into a bowl."""
    generator = np.random.default_rng(1)
    dust = pc.Particles(generator.uniform((-0.35, -0.35, 0.1), (0.35, 0.35, 0.7), size=(100_000, 3)), mass=1e-6)
    bowl = pc.Sphere((0.0, 0.0, 0.0), radius=1.0, inside=True, restitution=0.85)
    return pc.Scene(dust, pc.Gravity((0.0, 0.0, -9.81)), bowl)


def main(path: str | os.PathLike[str] = "bowl.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=20, dt=1e-3, progress=progress)
    pc.film(
        recording,
        path,
        size=(480, 376),
        camera=Orbit(azimuth=-60.0, elevation=32.0, target=(0.0, 0.0, -0.42), extent=1.75),
        style=pc.styles.Points(color="speed"),
        max_bytes=3_000_000,
        title="Dust in a bowl",
        subtitle="A hundred thousand particles bounce, and settle",
        progress=progress,
    )
    return {"dust": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms, after millions of bounces."""
    return budget(recordings, bound=1e-6)
