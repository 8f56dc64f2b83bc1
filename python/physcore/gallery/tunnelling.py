"""A wave packet meets a barrier higher than its energy: most of it is reflected, and some is transmitted.

The physics checked: the transmitted probability is that of plane waves, weighted by their shares in the packet.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure

DURATION = 4.5
"""Simulated time [s]."""
MOMENTUM, WIDTH = 4.0, 1.3
"""Momentum and width of the packet, with ħ = m = 1."""
HEIGHT, THICK = 9.0, 0.6
"""Height [J] and thickness [m] of the barrier."""


def scene() -> pc.Scene:
    """A packet that moves to the right, toward a barrier."""
    plane = pc.Grid.over((-24.0, -8.0), (24.0, 8.0), 0.1, periodic=(False, True))
    packet = pc.wave_packet(plane, (-9.0, 0.0), (MOMENTUM, 0.0), (WIDTH, 2.2))

    def barrier(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return HEIGHT * (np.abs(x + 0.0 * y) < THICK / 2)

    return pc.Scene(pc.Schrodinger(plane, packet, potential=barrier, name="electron"), units=pc.units.dimensionless)


def main(path: str | os.PathLike[str] = "tunnelling.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=24, progress=progress)
    style, camera = pc.styles.Phase(range=0.02), Window((-15.0, -5.0), (15.0, 5.0))
    pc.film(
        recording,
        path,
        size=(540, 284),
        style=style,
        camera=camera,
        speed=0.5,
        quality="high",
        max_bytes=3_000_000,
        title="Tunnelling",
        subtitle="Most of a packet is reflected, some passes the barrier",
        progress=progress,
    )
    return {"electron": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The probability beyond the barrier, after the reflected part has left."""
    recording = recordings["electron"]
    (electron,) = recording.scene.grids
    x = electron.grid.coordinates[0]
    passed = float(recording[electron].density[-1][x > THICK / 2].sum()) * electron.grid.spacing**2
    k = np.linspace(MOMENTUM - 2.0, MOMENTUM + 2.0, 4001)
    kappa = np.sqrt(2.0 * HEIGHT - k**2 + 0j)
    amplitude = 1.0 / (np.cosh(kappa * THICK) + 1j * (kappa**2 - k**2) / (2.0 * k * kappa) * np.sinh(kappa * THICK))
    expected = float(np.average(np.abs(amplitude) ** 2, weights=np.exp(-2.0 * WIDTH**2 * (k - MOMENTUM) ** 2)))
    return Figure("probability beyond the barrier", passed, expected, "of plane waves", 0.05)
