"""Two opposite charges orbit each other; their field lines run from one to the other.

The physics checked: the period of two attracting charges obeys Kepler's third law.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.film.colors.themes import DARK
from physcore.gallery.figure import Figure

CHARGE, MASS = 1e-6, 1e-3
"""Charge [C] and mass [kg] of each particle."""
APART, SLOW = 1.0, 0.8
"""Initial distance [m], and the initial speed relative to that of a circular orbit."""

STRENGTH = pc.Coulomb().constant * CHARGE**2
"""Strength of the attraction, k q² [N·m²]."""
AXIS = APART / (2.0 - SLOW**2)
"""Semi-major axis of the relative orbit, from the initial energy [m]."""
PERIOD = 2.0 * math.pi * math.sqrt(0.5 * MASS * AXIS**3 / STRENGTH)
"""Orbital period [s]."""
DURATION = PERIOD
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """Two charges at their largest distance."""
    speed = 0.5 * SLOW * math.sqrt(STRENGTH / (0.5 * MASS * APART))
    ends = np.array([[-0.5, 0.0], [0.5, 0.0]]) * APART
    names = ("positive", "negative")
    charges = [
        pc.Particles([at], [[0.0, math.copysign(speed, at[0])]], MASS, sign * CHARGE, 0.045, name=name)
        for at, sign, name in zip(ends, (1.0, -1.0), names, strict=True)
    ]
    return pc.Scene(*charges, pc.Coulomb())


def main(path: str | os.PathLike[str] = "dipole.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw it with field lines and equipotentials."""
    recording = pc.simulate(scene(), DURATION, fps=48.0 / PERIOD, integrator=pc.GaussRadau15(), progress=progress)
    style = [
        pc.styles.Equipotentials(17, strength=0.3),
        pc.styles.FieldLines(lines=20, strength=0.75),
        pc.styles.Points(color="body", glow=0.9, trail=0.0),
    ]
    pc.film(
        recording,
        path,
        size=(560, 484),
        style=style,
        camera=Window((-1.15, -0.86), (1.15, 0.86)),
        theme=replace(DARK, bodies=((255, 96, 84), (86, 156, 255))),
        speed=PERIOD / 2.4,
        title="Two charges",
        subtitle="Opposite ones orbit each other, with their field",
        progress=progress,
    )
    return {"charges": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Period: twice the time of the periapsis, at which the distance is smallest."""
    charges = recordings["charges"]
    apart = charges.positions[:, 0] - charges.positions[:, 1]
    rate = ((charges.velocities[:, 0] - charges.velocities[:, 1]) * apart).sum(axis=1)
    middle = len(rate) // 2
    near = slice(middle - 1, middle + 2)
    found = 2.0 * float(np.interp(0.0, rate[near], charges.times[near]))
    return Figure("period", found, PERIOD, "by Kepler's third law", 1e-5, "s")
