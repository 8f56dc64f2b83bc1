"""Drops fall into a pond without shores; their circular waves cross each other and leave through the open edges.

The physics checked: the energy of the drops becomes kinetic and potential energy, and the flux through the open edges.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import partial

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure

DURATION = 6.0
"""Simulated time [s]."""
DROPS = (
    (1.0, 1.9, 0.0),
    (2.9, 1.1, 0.4),
    (2.2, 2.3, 0.9),
    (0.9, 0.8, 1.4),
    (3.2, 2.2, 1.8),
    (2.0, 1.4, 2.3),
    (3.1, 0.6, 2.7),
    (0.7, 2.4, 3.1),
    (1.6, 0.6, 3.6),
    (2.6, 1.8, 4.0),
    (1.2, 1.4, 4.5),
    (3.5, 1.5, 4.9),
)
"""Positions and times of the drops [m, m, s]."""


def scene() -> pc.Scene:
    """Drops that fall into a part of an infinite pond."""
    pulse = pc.Ricker(3.0)
    drops = [pc.Source((x, y), 1.0, signal=partial(_later, pulse, start)) for x, y, start in DROPS]
    pond = pc.Wave(pc.Grid.over((0.0, 0.0), (4.0, 3.0), 0.025), speed=1.0, sources=drops, edges="absorbing")
    return pc.Scene(pond)


def _later(pulse: pc.Ricker, start: float, time: float) -> float:
    """A pulse that begins at the time `start` [s]."""
    return float(pulse(time - start))


def main(path: str | os.PathLike[str] = "ripples.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=20, dt=pc.AutoStep(safety=0.3), progress=progress)
    style, camera = pc.styles.Relief(range=0.08, height=0.08), Orbit(-70.0, 27.0, target=(1.97, 1.5, 0.0), extent=3.1)
    pc.film(
        recording,
        path,
        size=(520, 396),
        style=style,
        camera=camera,
        color_bar=False,
        max_bytes=3_000_000,
        title="Rain on a pond",
        subtitle="Circular waves cross each other",
        progress=progress,
    )
    return {"pond": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Energy in the pond at the end plus the energy that has left through the edges, compared with the work of the
    drops.
    """
    energy = recordings["pond"].energy
    found = float(energy.total[-1] + energy.dissipated_by["edges"][-1])
    return Figure("waves at the end and what has left", found, float(energy.work[-1]), "from the drops", 0.01, "J")
