"""Three cubes of jelly, soft, medium and firm, fall on their corners, bounce and wobble until damping stops them.

The physics checked: total + dissipated energy stays constant through every bounce.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget
from physcore.gallery.rotation import rotation

DURATION = 2.0
"""Simulated time [s]."""


KINDS = {"soft": (30.0, "#e8443a"), "medium": (70.0, "#f6a21c"), "firm": (130.0, "#58b947")}
"""Stiffness of the springs [N/m] and color of each cube."""
NODES, SPACING = 8, 0.045
"""Number of particles along each side of a cube, and their spacing [m]."""


def cube(name: str, stiffness: float, place: float) -> pc.SpringNetwork:
    """A rotating cube, with one corner down."""
    lattice = pc.soft_body((NODES,) * 3, SPACING, stiffness, damping=0.4, mass=0.002, name=name)
    inward = lattice.positions - lattice.positions.mean(axis=0)
    turned = inward @ rotation((1.0, -1.0, 0.0), 0.15).T @ rotation((0.0, 0.0, 1.0), 0.5).T
    spin = np.cross((0.0, 0.0, 1.0), turned)
    return replace(lattice, positions=turned + np.array([place, 0.0, 0.62]), velocities=spin)


def scene() -> pc.Scene:
    """Drop three cubes side by side."""
    places = (-0.7, 0.0, 0.7)
    cubes = [cube(name, stiffness, place) for (name, (stiffness, _)), place in zip(KINDS.items(), places, strict=True)]
    return pc.Scene(*cubes, pc.Gravity((0.0, 0.0, -9.81)), pc.Floor(0.0, restitution=0.0, friction=0.8))


def main(path: str | os.PathLike[str] = "jelly.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    # Impacts excite frequencies close to the limit of stability. A quarter of the limiting step resolves them.
    recording = pc.simulate(scene(), duration=DURATION, fps=40, dt=pc.AutoStep(safety=0.25), progress=progress)
    style = pc.styles.Surface({name: color for name, (_, color) in KINDS.items()})
    camera = Orbit(-72.0, 16.0, target=(0.0, 0.1, 0.34), extent=1.2)
    pc.film(
        recording,
        path,
        size=(640, 400),
        style=style,
        camera=camera,
        speed=0.5,
        quality="high",
        legend=True,
        title="Three cubes of jelly",
        subtitle="Soft, medium and firm, until damping stops them",
        progress=progress,
    )
    return {"jelly": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms, after all bounces."""
    return budget(recordings, bound=5e-3)
