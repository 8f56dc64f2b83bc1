"""A rope is pulled tight in an overhand knot.

The physics checked: the work done on the ends becomes strain and heat, and the budget closes.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Keyframes, Orbit
from physcore.gallery.figure import Figure

DURATION = 4.0
"""Simulated time [s]."""
THICKNESS = 0.03
"""Thickness of the rope [m]."""
SPACING = 0.036
"""Spacing of the particles [m]."""
REACH = 0.7
"""Length of each straight end at the start [m]."""


def centerline() -> np.ndarray:
    """Centerline of a trefoil, cut at its widest point, with straight ends: equidistant points (N, 3) [m]."""
    t = np.linspace(np.pi, 3.0 * np.pi, 4001)
    x, y = np.sin(t) + 2.0 * np.sin(2.0 * t), np.cos(t) - 2.0 * np.cos(2.0 * t)
    wide = np.column_stack([x, y, -1.2 * np.sin(3.0 * t)])
    # The two ends cross one above the other where the trefoil was cut.
    wide[:, 2] += 0.5 * np.cos(0.5 * (t - np.pi)) ** 7
    loop = 0.1 * wide
    path = np.vstack([loop[0] - (REACH, 0.0, 0.0), loop, loop[-1] + (REACH, 0.0, 0.0)])
    length = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))]
    at = np.linspace(0.0, length[-1], round(length[-1] / SPACING) + 1)
    return np.column_stack([np.interp(at, length, path[:, axis]) for axis in range(3)])


def scene() -> pc.Scene:
    """A rope with a knot, whose ends are pulled apart and yield as the knot tightens."""
    points = centerline()
    count = len(points)
    velocities = np.zeros_like(points)
    velocities[[0, -1], 0] = -0.3, 0.3
    rope = pc.SpringNetwork(
        points,
        np.column_stack([np.arange(count - 1), np.arange(1, count)]),
        stiffness=400.0,
        damping=0.1,
        mass=0.002,
        velocities=velocities,
        fixed=[0, count - 1],
    )
    return pc.Scene(rope, pc.Drag(linear=0.01), pc.SelfContact(rope, THICKNESS, friction=0.1))


def main(path: str | os.PathLike[str] = "knot.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=30, progress=progress)
    first = Orbit(azimuth=-90.0, elevation=65.0, target=(0.0, 0.0, 0.0), extent=0.8)
    last = Orbit(azimuth=-60.0, elevation=50.0, target=(0.0, 0.0, 0.0), extent=0.36)
    camera = Keyframes({0.0: first, DURATION: last})
    style = pc.styles.Tube("#e0b05a", strands=3)
    pc.film(
        recording,
        path,
        size=(640, 400),
        style=style,
        title="Pulling a knot tight",
        subtitle="Friction locks an overhand knot in a rope",
        camera=camera,
        labels=(),
        quality="high",
        max_bytes=3_000_000,
        progress=progress,
    )
    return {"rope": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Energy gained and lost by the rope, relative to the work done on its ends."""
    energy = recordings["rope"].energy
    gained = energy.total[-1] - energy.total[0] + energy.dissipated[-1]
    return Figure(
        "energy gained and lost over work done", float(gained / energy.work[-1]), 1.0, "by its conservation", 1e-2
    )
