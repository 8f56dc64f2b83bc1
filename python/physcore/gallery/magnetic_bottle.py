"""Protons are trapped between two coils: where the field grows, their circles shrink and they turn back.

The physics checked: the mean of the magnetic moments m v⊥²/2B is the same at the end as at the start.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import physcore as pc
from physcore.film import DARK, Orbit
from physcore.gallery.figure import Figure
from physcore.units import elementary_charge, proton_mass

DURATION = 36e-6
"""Simulated time [s]."""
RADIUS, APART, CURRENT = 0.16, 0.56, 1.5e4
"""Radius of the coils and distance between them [m], and their current [A]."""
MIDDLE = 4e-7 * np.pi * CURRENT * RADIUS**2 / (RADIUS**2 + 0.25 * APART**2) ** 1.5
"""Magnetic field B on the axis between the coils [T]."""
SPEED = 3e4
"""Speed of the protons [m/s]."""
PROTONS = 24
COLORS = ((170, 120, 80), (170, 120, 80), (110, 200, 255), (255, 190, 90), (240, 110, 170))


def scene() -> pc.Scene:
    """Protons of equal speed, in three beams at different angles to the field; the coils are only drawn."""
    generator = np.random.default_rng(8)
    angles = np.linspace(0.0, 2.0 * np.pi, 240, endpoint=False)
    ring = RADIUS * np.column_stack([0.0 * angles, np.cos(angles), np.sin(angles)])
    coils = [pc.Particles(ring + 0.5 * APART * np.array([side, 0.0, 0.0]), fixed=True) for side in (-1.0, 1.0)]
    beams = []
    for name, pitch in (("steep", 62.0), ("middle", 46.0), ("flat", 36.0)):
        count = PROTONS // 3
        turn, tilt = generator.uniform(0.0, 2.0 * np.pi, (2, count)), np.radians(pitch)
        across = np.column_stack([np.zeros(count), np.cos(turn[0]), np.sin(turn[0])])
        velocities = SPEED * (np.sin(tilt) * across + np.cos(tilt) * np.array([1.0, 0.0, 0.0]))
        velocities[::2, 0] *= -1.0
        away = 0.075 * np.sqrt(generator.uniform(size=count))
        places = np.column_stack([np.zeros(count), away * np.cos(turn[1]), away * np.sin(turn[1])])
        beams.append(
            pc.Particles(places, velocities, mass=proton_mass, charge=elementary_charge, name=f"{name} protons")
        )
    west, east = (
        pc.CurrentLoop(RADIUS, CURRENT, (side * 0.5 * APART, 0.0, 0.0), (1.0, 0.0, 0.0)) for side in (-1.0, 1.0)
    )
    return pc.Scene(*coils, *beams, pc.ElectromagneticField(magnetic=(west, east), on=beams))


def main(path: str | os.PathLike[str] = "magnetic_bottle.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene by Boris' method and draw the paths."""
    recording = pc.simulate(scene(), DURATION, fps=7.5e6, dt=1 / 52.5e6, progress=progress)
    coils, beams = recording.scene.bodies[:2], recording.scene.bodies[2:]
    style = [
        pc.styles.Paths(fade=6e-6, width=2.0, on=beams),
        pc.styles.Points(color="body", size=6.0, trail=0.0, on=coils),
        pc.styles.Points(color="body", size=8.0, glow=0.5, trail=0.0, on=beams),
    ]
    pc.film(
        recording,
        path,
        size=(640, 400),
        style=style,
        camera=Orbit(-73.0, 16.0, target=(0.0, 0.0, 0.0), extent=0.39),
        theme=replace(DARK, bodies=COLORS),
        labels=("energy",),
        speed=3.5e-6,
        max_bytes=3_000_000,
        title="A magnetic bottle",
        subtitle="Protons turn back where the field grows",
        progress=progress,
    )
    return {"protons": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Ratio of the mean magnetic moment in the last passages through the middle plane to that at the start.

    Source: J. D. Jackson, Classical Electrodynamics, 3rd edition (1999), § 12.5.
    """
    protons = recordings["protons"]
    fixed = sum(map(len, protons.scene.bodies[:2]))
    x, v = protons.positions[:, fixed:], protons.velocities[:, fixed:]
    moments = (v[..., 1] ** 2 + v[..., 2] ** 2) / SPEED**2
    late = len(x) // 2
    last = []
    for index in range(x.shape[1]):
        passages = late + np.flatnonzero(x[late:-1, index, 0] * x[late + 1 :, index, 0] < 0.0)
        last.extend(moments[passages, index])
    found = float(np.mean(last) / np.mean(moments[0]))
    return Figure("magnetic moment, end over start", found, 1.0, "by its adiabatic invariance", 0.05, "")
