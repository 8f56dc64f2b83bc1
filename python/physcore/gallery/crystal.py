"""A hot gas of atoms loses its heat, condenses into drops and freezes into crystals.

The physics checked: what the drag takes is what the atoms had, and the crystals are bound like a hexagonal lattice.
"""

from __future__ import annotations

import os

import numpy as np

import physcore as pc


def main(path: str | os.PathLike[str] = "crystal.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Cool argon in units of its own: σ = ε = m = 1."""
    width, height, distance = 120.0, 90.0, 1.5
    generator = np.random.default_rng(2)
    lattice = pc.block((0.0, 0.0), (width, height), distance)
    velocities = generator.normal(size=lattice.shape)
    velocities -= velocities.mean(axis=0)
    atoms = pc.Particles(lattice, velocities, radius=0.5)
    scene = pc.Scene(
        atoms, pc.LennardJones(epsilon=1.0, sigma=1.0), pc.Drag(linear=0.03), pc.Periodic((0.0, 0.0), (width, height))
    )
    recording = pc.simulate(scene, duration=150.0, fps=1.0, dt=0.01, progress=progress)
    pc.film(recording, path, size=(640, 480), speed=20.0, progress=progress)
    return {"argon": recording}
