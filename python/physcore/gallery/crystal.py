"""A hot gas of atoms loses its heat, condenses into drops and freezes into crystals.

The physics checked: the drag removes the heat of the atoms, and they end bound as in a hexagonal lattice with surfaces.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.gallery.figure import Figure

DURATION = 500.0
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """Atoms whose mass, size and binding energy are 1; for argon a second then corresponds to 2.2 ps."""
    domain = pc.Periodic((0.0, 0.0), (80.0, 60.0))
    places = pc.block(domain.lower, domain.upper, spacing=1.75)
    velocities = np.random.default_rng(2).normal(scale=1.2, size=places.shape)
    atoms = pc.Particles(places, velocities - velocities.mean(axis=0), radius=0.5)
    return pc.Scene(atoms, pc.LennardJones(epsilon=1.0, sigma=1.0), pc.Drag(linear=0.008), domain)


def main(path: str | os.PathLike[str] = "crystal.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=0.16, dt=0.008, progress=progress)
    style = pc.styles.Points(top=2.5)
    pc.film(
        recording,
        path,
        size=(496, 456),
        style=style,
        speed=100.0,
        max_bytes=3_000_000,
        title="A gas freezes",
        subtitle="Atoms condense into drops, and freeze into crystals",
        progress=progress,
    )
    return {"argon": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Distance of neighbors, with its value in the hexagonal lattice of least energy.

    The remaining heat, kT = 0.13 ε, stretches a single bond by kT |U‴| / 2U″² = 1.8 %, and less in a lattice.
    """
    recording = recordings["argon"]
    places, domain = recording.positions[-1], recording.scene.periodic
    assert domain is not None
    separation = [np.linalg.norm(domain.nearest(places[one + 1 :] - place), axis=1) for one, place in enumerate(places)]
    distances = np.concatenate([each[each < 1.4] for each in separation])
    candidates = np.linspace(1.05, 1.2, 1501)
    lowest = candidates[np.argmin([lattice_energy(distance) for distance in candidates])]
    return Figure("distance of neighbors", float(np.median(distances)), float(lowest), "in a cold lattice", 0.02, "σ")


def lattice_energy(distance: float) -> float:
    """Half the energy of an atom's bonds in a hexagonal lattice [ε], with the shifted force of LennardJones."""
    steps = np.arange(-4, 5)
    i, j = (index.ravel() for index in np.meshgrid(steps, steps))
    separation = distance * np.sqrt(i * i + i * j + j * j)
    separation = separation[(separation > 0.0) & (separation < 2.5)]
    cut = 4.0 * (2.5**-12 - 2.5**-6)
    slope = 24.0 * (2.5**-7 - 2.0 * 2.5**-13)
    return 0.5 * float((4.0 * (separation**-12 - separation**-6) - cut - (separation - 2.5) * slope).sum())
