"""Six hundred pebbles run down a landscape into a hollow.

The physics checked: the budget closes over bounces on fifteen thousand faces, and nothing is below the ground.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.checks import FloatArray
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget

PEBBLES = 600
"""Number of pebbles."""
RADIUS = 0.016
"""Radius of a pebble [m]."""
STIFFNESS = 400.0
"""Stiffness of the contacts between pebbles [N/m]."""

DURATION = 3.5
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
    """A heap of pebbles high on the slope, initially at rest."""
    generator = np.random.default_rng(4)
    sites = pc.block((-1.0, -0.5, 0.0), (-0.55, 0.5, 0.5), 2.5 * RADIUS)
    sites = sites[generator.permutation(len(sites))[:PEBBLES]]
    sites += generator.uniform(-0.2 * RADIUS, 0.2 * RADIUS, sites.shape)
    sites[:, 2] += 0.2 + height(sites[:, 0], sites[:, 1])
    mass = 2500.0 * 4.0 / 3.0 * np.pi * RADIUS**3
    pebbles = pc.Particles(sites, mass=mass, radius=RADIUS)
    ground = pc.HeightField.over(height, (-1.2, -0.9), (1.2, 0.9), spacing=0.025, restitution=0.3, friction=0.25)
    contacts = pc.SoftSpheres(STIFFNESS, 0.1, friction=0.2, tangential_damping=0.05)
    return pc.Scene(pebbles, pc.Gravity((0.0, 0.0, -9.81)), ground, contacts)


def main(path: str | os.PathLike[str] = "landslide.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=25, dt=1e-3, progress=progress)
    camera = Orbit(azimuth=-72.0, elevation=42.0, target=(0.0, 0.0, 0.26), extent=2.55)
    style = pc.styles.Points(color="speed", top=2.5)
    pc.film(
        recording,
        path,
        size=(640, 470),
        style=style,
        camera=camera,
        title="A landslide",
        subtitle="Six hundred pebbles run down into a hollow",
        progress=progress,
    )
    return {"pebbles": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms."""
    return budget(recordings, bound=1e-3)
