"""Plane waves run through a round lens whose wave speed is lowest in the middle, and focus on its far rim.

The physics checked: the focus of a Luneburg lens is on its rim.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.checks import FloatArray
from physcore.gallery.figure import Figure

DURATION = 7.5
"""Simulated time [s]."""
RADIUS = 1.5
"""Radius of the lens [m]."""
WAVELENGTH = 0.3
"""Wavelength [m]."""


def speed(x: FloatArray, y: FloatArray) -> FloatArray:
    """Speed of waves [m/s]: c = 1/√(2 − (r/R)²) within the lens, and 1 m/s around it.

    Source: R. K. Luneburg, "Mathematical Theory of Optics", 1944, section 29.
    """
    inside = np.minimum((x**2 + y**2) / RADIUS**2, 1.0)
    slowed: FloatArray = 1.0 / np.sqrt(2.0 - inside)
    return slowed


def scene() -> pc.Scene:
    """A row of oscillating cells beside the lens."""
    plane = pc.Grid.over((-2.5, -2.1), (3.1, 2.1), 0.02)
    x, _ = plane.coordinates
    lamp = pc.Source(np.abs(x + 2.2) < 0.01, amplitude=40.0, frequency=1.0 / WAVELENGTH, phase=math.pi / 2)
    around = np.linspace(0.0, 2.0 * math.pi, 181)
    rim = pc.Particles(RADIUS * np.column_stack([np.cos(around), np.sin(around)]), fixed=True)  # the outline
    edges = {"x": "absorbing", "y": "free"}
    return pc.Scene(pc.Wave(plane, speed=speed, sources=lamp, edges=edges), rim)  # type: ignore[arg-type]


def main(path: str | os.PathLike[str] = "lens.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=6, progress=progress)
    style = [pc.styles.Field(), pc.styles.Points(color="body", size=2.0)]
    pc.film(
        recording,
        path,
        size=(440, 412),
        style=style,
        speed=2.0,
        max_bytes=3_000_000,
        title="A lens of slow sound",
        subtitle="Plane waves focus on the far rim",
        progress=progress,
    )
    return {"light": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Distance from the middle of the lens to the largest waves on the axis; the focus is about a wavelength long."""
    recording = recordings["light"]
    (wave,) = recording.scene.grids
    x, middle = wave.grid.coordinates[0][:, 0], wave.grid.cells[1] // 2
    periods = round(8 * WAVELENGTH * recording.fps)
    brightness = np.mean(recording[wave].displacement[-periods:, :, middle] ** 2, axis=0)
    return Figure("distance of the focus", float(x[np.argmax(brightness)]), RADIUS, "by Luneburg", 0.1, "m")
