"""A hot gas of atoms loses its heat, condenses into drops and freezes into crystals.

The physics checked: the drag takes all that the atoms had, and they end bound as in a hexagonal lattice with surfaces.
"""

from __future__ import annotations

import os

import numpy as np

import physcore as pc

DURATION = 500.0
"""[s]"""


def scene() -> pc.Scene:
    """Cool atoms of mass, size and binding energy one; a second is then 2.2 ps of argon."""
    domain = pc.Periodic((0.0, 0.0), (80.0, 60.0))
    places = pc.block(domain.lower, domain.upper, spacing=1.75)
    velocities = np.random.default_rng(2).normal(scale=1.2, size=places.shape)
    atoms = pc.Particles(places, velocities - velocities.mean(axis=0), radius=0.5)
    return pc.Scene(atoms, pc.LennardJones(epsilon=1.0, sigma=1.0), pc.Drag(linear=0.008), domain)


def main(path: str | os.PathLike[str] = "crystal.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=0.16, dt=0.008, progress=progress)
    pc.film(recording, path, size=(600, 480), speed=100.0, progress=progress)
    return {"argon": recording}
