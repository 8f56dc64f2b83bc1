"""Two thousand grains of colored sand run through the neck of an hourglass, at a constant rate, and form a heap.

The physics checked: the flow does not depend on the height of the sand. Of the contacts of grains at rest, 99 of 100
are no deeper than a twentieth of a radius. Every grain arrives. `main(path, grains=10_000)` has finer sand, and takes
ten times as long.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure

GRAINS = 2200
"""Approximate number of grains."""
NECK = 0.065
"""Width of the neck [m], some five grains."""
WIDTH, HEIGHT, FILL = 1.06, 1.2, 0.96
"""Half the width of the glass, depth of the floor below the neck, and height of the sand above it [m]."""
BEND = 1.25
"""Radius of the circles that form the glass [m]."""
SAND = 0.308
"""Area between the circles that the sand fills [m²]."""

DENSITY, STIFFNESS = 2000.0, 1e6
"""Density of grains [kg/m³, per meter of depth], and stiffness of their contacts [N/m]."""
RESTITUTION = 0.7
"""Coefficient of restitution between grains."""
TERMINAL = 1.6
"""Terminal velocity of a grain in air [m/s]."""

DURATION = 4.0
"""Simulated time [s]."""


def scene(grains: int = GRAINS, neck: float = NECK) -> pc.Scene:
    """About `grains` grains that run through the neck between two circles.

    The smallest grain has three quarters of the radius of the largest, so that they do not form a lattice.
    """
    largest, layers = 0.5 * math.sqrt(SAND / grains), 6
    centers = np.array([[-BEND - neck / 2, 0.0], [BEND + neck / 2, 0.0]])
    places = pc.block((-WIDTH, 0.0), (WIDTH, FILL), 2 * largest)
    separation = np.hypot(np.abs(places[:, 0]) - centers[1, 0], places[:, 1])
    places = places[separation > BEND + 1.2 * largest]  # room for random shifts
    generator = np.random.default_rng(3)
    radii = largest * generator.uniform(0.75, 1.0, len(places))
    places += (largest - radii)[:, np.newaxis] * generator.uniform(-1.0, 1.0, places.shape)
    masses = DENSITY * np.pi * radii**2
    layer = (places[:, 1] * layers / FILL).astype(int)
    sand = [
        pc.Particles(places[layer == k], mass=masses[layer == k], radius=radii[layer == k], name=f"layer {k}")
        for k in range(layers)
    ]
    # A colliding pair is a damped oscillator of reduced mass m/2 for half a period: e = exp(−πξ/√(1 − ξ²)).
    mass, bounce = float(masses.mean()), -math.log(RESTITUTION)
    damping = 2.0 * bounce / math.hypot(math.pi, bounce) * math.sqrt(STIFFNESS * mass / 2.0)
    return pc.Scene(
        *sand,
        pc.Gravity((0.0, -9.81)),
        pc.SoftSpheres(STIFFNESS, damping, friction=0.8, tangential_damping=damping / 2.0),
        pc.Drag(quadratic=mass * 9.81 / TERMINAL**2),
        *(pc.Sphere(tuple(center), BEND, restitution=0.0, friction=0.3) for center in centers),
        pc.Floor(-HEIGHT, restitution=0.0, friction=0.8),
    )


def main(
    path: str | os.PathLike[str] = "hourglass.gif", progress: bool | None = None, grains: int = GRAINS
) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(
        scene(grains), duration=DURATION, fps=25, dt=pc.AutoStep(safety=0.9), precision="f32", progress=progress
    )
    pc.film(
        recording,
        path,
        size=(400, 520),
        style=pc.styles.Points(color="body"),
        camera=Window((-WIDTH, -HEIGHT - 0.04), (WIDTH, HEIGHT)),
        max_bytes=3_000_000,
        title="An hourglass",
        subtitle="Two thousand grains run out at a constant rate",
        progress=progress,
    )
    return {"sand": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Flow rate in the second half of the time, with its value in the first half.

    Source: W. A. Beverloo et al., Chem. Eng. Sci. 15, 260 (1961).
    """
    sand = recordings["sand"]
    above = (sand.positions[..., 1] > 0.0).sum(axis=1)
    running = np.flatnonzero((above < 0.8 * above[0]) & (above > 0.2 * above[0]))
    first, last = np.array_split(running, 2)
    early, late = (-np.polyfit(sand.times[part], above[part], 1)[0] for part in (first, last))
    return Figure("grains per second at the end", late, early, "at the start", 0.05)
