"""A wave packet in a harmonic trap keeps its shape, and its center follows a classical orbit.

The physics checked: the mean position at the end is that of a particle (Schrödinger's coherent states, 1926).
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure

DURATION = 4.0 * math.pi
"""Simulated time [s], two periods of the slower oscillation; ħ = m = 1."""
RATES = (1.0, 1.5)
"""Angular frequencies along x and y [1/s]."""
START, MOMENTUM = (5.0, 0.0), (0.0, 4.5)


def scene() -> pc.Scene:
    """A packet with the width of the ground state beside the middle of a trap, with an initial momentum, and a particle
    with it.
    """
    room = pc.Grid.over((-8.0, -6.0), (8.0, 6.0), 0.1)
    packet = pc.wave_packet(room, START, MOMENTUM, [math.sqrt(0.5 / rate) for rate in RATES])

    def trap(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 0.5 * ((RATES[0] * x) ** 2 + (RATES[1] * y) ** 2)

    def force(time: float, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        return np.asarray(-np.square(RATES) * positions)

    particle = pc.Particles([START], [MOMENTUM], name="particle")
    return pc.Scene(
        pc.Schrodinger(room, packet, potential=trap, name="atom"),
        particle,
        pc.CustomForce(force),
        units=pc.units.dimensionless,
    )


def main(path: str | os.PathLike[str] = "harmonic_trap.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=150 / DURATION, dt=0.01, progress=progress)
    style = [pc.styles.Phase(), pc.styles.Points(color="body", size=9.0, trail=DURATION)]
    camera = Window((-8.0, -5.53), (8.0, 5.53))
    pc.film(
        recording,
        path,
        size=(520, 440),
        style=style,
        camera=camera,
        speed=2.0,
        max_bytes=3_000_000,
        title="A wave packet in a harmonic trap",
        subtitle="It keeps its shape on a classical orbit",
        progress=progress,
    )
    return {"atom": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Mean of x at the last frame."""
    recording = recordings["atom"]
    (atom,) = recording.scene.grids
    density = recording[atom].density[-1]
    x = float((density.sum(axis=1) * atom.grid.coordinates[0][:, 0]).sum() / density.sum())
    expected = START[0] * math.cos(RATES[0] * float(recording.times[-1]))
    return Figure("mean position at the end", x, expected, "of a particle", 0.01)
