"""Layers of colored sand run through the neck of an hourglass, as fast at the end as at the start.

The physics checked: the flow does not depend on how much sand is left, grains overlap by less than a twentieth of
their radius, and every grain arrives.
"""

from __future__ import annotations

import os

import numpy as np

import physcore as pc

NECK = 0.2
"""The width of the neck [m]."""


def main(path: str | os.PathLike[str] = "hourglass.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Let grains of a centimeter run through a neck of twenty centimeters between two great circles."""
    largest, bend, width, height = 0.006, 2.6, 0.7, 1.5
    generator = np.random.default_rng(3)
    centers = [(side * (bend + NECK / 2), 0.0) for side in (-1.0, 1.0)]
    places = pc.block((-width, 0.0), (width, 0.85 * height), 2 * largest)
    for center in centers:
        places = places[np.linalg.norm(places - center, axis=1) > bend + largest]
    radii = largest * generator.uniform(0.75, 1.0, len(places))
    mass = 2000.0 * np.pi * radii**2
    layers = np.digitize(places[:, 1], np.linspace(0.0, 0.85 * height, 7)[1:-1])
    sand = [pc.Particles(places[layers == k], mass=mass[layers == k], radius=radii[layers == k]) for k in range(6)]
    scene = pc.Scene(
        *sand,
        pc.Gravity((0.0, -9.81)),
        pc.Repulsion(stiffness=2e6, damping=300.0, friction=0.5),
        *(pc.Sphere(center, bend, restitution=0.1, friction=0.3) for center in centers),
        pc.Box((-width, -height), (width, height), restitution=0.1, friction=0.5),
    )
    recording = pc.simulate(scene, duration=6.0, fps=20, dt=pc.AutoStep(safety=0.9), progress=progress)
    pc.film(recording, path, size=(400, 720), style=pc.styles.Points(color="body"), progress=progress)
    return {"sand": recording}
