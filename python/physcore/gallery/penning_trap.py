"""Ions draw rosettes in a Penning trap: fast gyration, axial oscillation, and a slow drift around the axis.

The physics checked: the squares of the three frequencies add up to that of the cyclotron frequency.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import physcore as pc
from physcore.film import DARK, Orbit
from physcore.gallery.figure import Figure

DURATION = 50.0
"""Simulated time [s], about one period of the magnetron motion."""
CYCLOTRON = 4.0
"""Cyclotron frequency q B/m, relative to the axial frequency 1 [rad/s]."""
COLORS = ((255, 170, 70), (90, 190, 255), (240, 100, 160))
SLOW, FAST, HEIGHT = (1.0, 0.72, 0.45), (0.22, 0.16, 0.12), (0.5, 0.35, 0.2)
"""Radii of the magnetron and of the cyclotron motion, and axial amplitudes, of each ion [m]."""


def scene() -> pc.Scene:
    """Three ions of charge and mass 1 in the trap, without interaction."""
    half, root = 0.5 * CYCLOTRON, np.sqrt(0.25 * CYCLOTRON**2 - 0.5)
    ions = []
    for index, (slow, fast, height) in enumerate(zip(SLOW, FAST, HEIGHT, strict=True)):
        turn = 2.0 * np.pi * index / len(SLOW)
        outward, ahead = np.array([np.cos(turn), np.sin(turn), 0.0]), np.array([-np.sin(turn), np.cos(turn), 0.0])
        velocity = -((half - root) * slow + (half + root) * fast) * ahead  # both clockwise about B for q > 0
        place = (slow + fast) * outward + (0.0, 0.0, height)
        ions.append(pc.Particles([place], [velocity], charge=1.0, name=f"ion {index + 1}"))
    return pc.Scene(*ions, pc.ElectromagneticField(pc.QuadrupoleTrap(1.0), (0.0, 0.0, CYCLOTRON)))


def main(path: str | os.PathLike[str] = "penning_trap.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate one magnetron period by Boris' method and draw the paths."""
    recording = pc.simulate(scene(), DURATION, fps=10.0, dt=1 / 140, progress=progress)
    pc.film(
        recording,
        path,
        size=(640, 500),
        style=[pc.styles.Paths(width=1.3), pc.styles.Points(color="body", size=13.0, glow=0.8, trail=0.0)],
        camera=Orbit(-60.0, 33.0, target=(0.0, 0.0, 0.0), extent=2.3),
        theme=replace(DARK, bodies=COLORS),
        labels=("time", "energy"),
        speed=5.0,
        max_bytes=3_000_000,
        title="A Penning trap",
        subtitle="Ions draw rosettes: gyration, oscillation and a slow drift",
        progress=progress,
    )
    return {"ions": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The root of the sum of the squared frequencies. They are the phases of the eigenvalues of the linear map between
    frames.

    Source: L. S. Brown, G. Gabrielse, Phys. Rev. A 25, 2423 (1982).
    """
    ions = recordings["ions"]
    states = np.concatenate([ions.positions, ions.velocities], axis=2)
    before, after = states[:-1].reshape(-1, 6), states[1:].reshape(-1, 6)
    roots = np.linalg.eigvals(np.linalg.lstsq(before, after, rcond=None)[0])
    found = float(np.sqrt(0.5 * (np.angle(roots) ** 2).sum()) * ions.fps)
    return Figure("cyclotron frequency", found, CYCLOTRON, "by the theorem of Brown and Gabrielse", 1e-3, "rad/s")
