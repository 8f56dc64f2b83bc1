"""A sound packet travels along the wall of a round hall, where it is reflected again and again.

The physics checked: the angle traveled is that of rays, which are reflected repeatedly at the wall.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.checks import FloatArray
from physcore.gallery.figure import Figure

DURATION = 9.0
"""Simulated time [s]."""
RADIUS, START = 2.0, 1.8
"""Radius of the hall, and of the circle to which the rays are tangent [m]."""
WAVELENGTH, WIDTH, LENGTH = 0.25, 0.12, 0.35
"""Wavelength of the sound, and standard deviations of the packet across and along its direction [m]."""


def scene() -> pc.Scene:
    """A wave packet at the lowest point of the wall, moving to the right."""
    hall = pc.Grid.over((-2.1, -2.1), (2.1, 2.1), 0.02)
    wall = np.hypot(*hall.coordinates) > RADIUS

    def packet(x: FloatArray, y: FloatArray) -> FloatArray:
        envelope = np.exp(-(((y + START) / WIDTH) ** 2) / 4.0 - (x / LENGTH) ** 2 / 4.0)
        whisper: FloatArray = envelope * np.cos(2.0 * math.pi * x / WAVELENGTH)
        return whisper

    def rate(x: FloatArray, y: FloatArray) -> FloatArray:
        """Initial rate −c ∂u/∂x, for a packet that moves to the right."""
        step = 1e-5
        change: FloatArray = -(packet(x + step, y) - packet(x - step, y)) / (2.0 * step)
        return change

    return pc.Scene(pc.Wave(hall, speed=1.0, displacement=packet, rate=rate, walls=wall, name="whisper"))


def main(
    path: str | os.PathLike[str] = "whispering_gallery.gif", progress: bool | None = None
) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=8, progress=progress)
    style = pc.styles.Field(range=0.6)
    pc.film(
        recording,
        path,
        size=(360, 426),
        style=style,
        speed=1.5,
        quality="high",
        max_bytes=3_000_000,
        title="A whispering gallery",
        subtitle="Sound creeps along the wall",
        progress=progress,
    )
    return {"hall": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The angle around the hall traveled by the packet's energy, and that of rays.

    Rays are chords of half-angle φ and length 2R sin φ, each of which advances by the angle 2φ.
    """
    recording = recordings["hall"]
    (wave,) = recording.scene.grids
    x, y = wave.grid.coordinates
    energy = recording[wave].rate ** 2
    places = np.angle(np.einsum("fxy,xy->f", energy, np.exp(1j * np.arctan2(y, x))))
    half = math.acos(START / RADIUS)
    expected = DURATION * half / (RADIUS * math.sin(half))
    turned = np.unwrap(places)
    return Figure("angle around the hall", float(turned[-1] - turned[0]), expected, "by rays", 0.03, "rad")
