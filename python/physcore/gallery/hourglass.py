"""Layers of colored sand run through the neck of an hourglass, as fast at the end as at the start.

The physics checked: the flow does not depend on how much sand is left, grains at rest overlap by less than a twentieth
of their radius, and every grain arrives.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure

LARGEST = 0.0065
"""The radius of the largest grain [m]; the smallest has three quarters of it, so that they do not form a lattice."""
NECK = 0.26
"""The width of the neck [m]."""
WIDTH, HEIGHT = 1.08, 1.75
"""Half the width of the glass, and how far the floor is below the neck [m]."""

DURATION = 2.6
"""[s]"""


def scene() -> pc.Scene:
    """Let grains of a centimeter run through the neck between two great circles."""
    bend, fill, layers = 2.1, 1.5, 6
    centers = np.array([[-bend - NECK / 2, 0.0], [bend + NECK / 2, 0.0]])
    places = pc.block((-WIDTH, 0.0), (WIDTH, fill), 2 * LARGEST)
    apart = np.linalg.norm(places[:, np.newaxis] - centers, axis=2).min(axis=1)
    places = places[apart > bend + 1.2 * LARGEST]  # room to shake them
    generator = np.random.default_rng(3)
    radii = LARGEST * generator.uniform(0.75, 1.0, len(places))
    places += (LARGEST - radii)[:, np.newaxis] * generator.uniform(-1.0, 1.0, places.shape)
    masses = 2000.0 * np.pi * radii**2
    layer = (places[:, 1] * layers / fill).astype(int)
    sand = [
        pc.Particles(places[layer == k], mass=masses[layer == k], radius=radii[layer == k], name=f"layer {k}")
        for k in range(layers)
    ]
    return pc.Scene(
        *sand,
        pc.Gravity((0.0, -9.81)),
        pc.Repulsion(stiffness=2e6, damping=250.0, friction=0.5),
        pc.Drag(quadratic=0.5),  # so that no grain falls through the air with more than two meters per second
        *(pc.Sphere(tuple(center), bend, restitution=0.0, friction=0.3) for center in centers),
        pc.Floor(-HEIGHT, restitution=0.0, friction=0.5),
    )


def main(path: str | os.PathLike[str] = "hourglass.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(
        scene(), duration=DURATION, fps=50, dt=pc.AutoStep(safety=0.9), precision="f32", progress=progress
    )
    pc.film(
        recording,
        path,
        size=(480, 800),
        style=pc.styles.Points(color="body"),
        camera=Window((-WIDTH, -HEIGHT - 0.02), (WIDTH, HEIGHT - 0.15)),
        speed=0.5,
        progress=progress,
    )
    return {"sand": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The flow in the second half of the time, beside that in the first.

    Source: W. A. Beverloo et al., Chem. Eng. Sci. 15, 260 (1961).
    """
    sand = recordings["sand"]
    above = (sand.positions[..., 1] > 0.0).sum(axis=1)
    running = np.flatnonzero((above < 0.8 * above[0]) & (above > 0.2 * above[0]))
    first, last = np.array_split(running, 2)
    early, late = (-np.polyfit(sand.times[part], above[part], 1)[0] for part in (first, last))
    return Figure("grains per second at the end", late, early, "at the start", 0.05)
