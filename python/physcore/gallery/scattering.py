"""A wave packet meets a potential hill, which scatters it in all directions.

The physics checked: the reflected probability is that of classical particles with the same positions and velocities.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure

DURATION = 1.3
"""Simulated time [s]."""
START, MOMENTUM, WIDTH = (-5.0, 0.35), 8.0, 0.9
"""Initial position, momentum and width of the packet, with ħ = m = 1."""
HEIGHT, RADIUS = 60.0, 1.2
"""Height [J] and radius [m] of the hill, V = V₀ exp(−r²/2w²)."""
PARTICLES = 4000


def scene() -> pc.Scene:
    """A wave packet that meets a hill, in a room with absorbing edges."""
    room = pc.Grid.over((-10.0, -8.0), (10.0, 8.0), 0.1)
    packet = pc.wave_packet(room, START, (MOMENTUM, 0.0), WIDTH)

    def hill(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        height: np.ndarray = HEIGHT * np.exp(-(x * x + y * y) / (2.0 * RADIUS**2))
        return height

    return pc.Scene(
        pc.Schrodinger(room, packet, potential=hill, edges="absorbing", name="electron"), units=pc.units.dimensionless
    )


def main(path: str | os.PathLike[str] = "scattering.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=60, dt=0.003, progress=progress)
    camera = Window((-7.0, -5.25), (7.0, 5.25))
    style = pc.styles.Phase(range=0.025)
    pc.film(
        recording,
        path,
        size=(484, 447),
        style=style,
        camera=camera,
        speed=0.25,
        quality="high",
        max_bytes=3_000_000,
        title="Scattering",
        subtitle="A wave packet meets a potential hill",
        progress=progress,
    )
    return {"electron": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The probability on the near side of the hill at the end, and the fraction of particles that are reflected."""
    recording = recordings["electron"]
    (electron,) = recording.scene.grids
    near = electron.grid.coordinates[0][:, 0] < 0.0
    back = float(recording[electron].density[-1][near].sum()) * electron.grid.spacing**2
    random = np.random.default_rng(2)
    places = random.normal(START, WIDTH, size=(PARTICLES, 2))
    velocities = random.normal((MOMENTUM, 0.0), 0.5 / WIDTH, size=(PARTICLES, 2))

    def force(x: np.ndarray) -> np.ndarray:
        along: np.ndarray = HEIGHT / RADIUS**2 * x * np.exp(-(x * x).sum(axis=1, keepdims=True) / (2.0 * RADIUS**2))
        return along

    particles = pc.Scene(pc.Particles(places, velocities), pc.CustomForce(lambda time, x, v: force(x)))
    classical = pc.simulate(particles, duration=DURATION, fps=1 / DURATION, dt=0.005, progress=False)
    expected = float((classical.positions[-1, :, 0] < 0.0).mean())
    return Figure("probability to come back", back, expected, "of particles", 0.05)
