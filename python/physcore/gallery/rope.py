"""A fan of ropes, released at all angles, closes and opens again; the outer ones crack like whips.

The physics checked: only damping and drag dissipate energy, and the budget lists both.
"""

from __future__ import annotations

import colorsys
import math
import os
from collections.abc import Mapping, Sequence

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure, budget

ROPES = 31

DURATION = 2.0
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """Ropes held at one end, at rest, at angles over a semicircle; the first and the last are horizontal."""
    ropes = [
        pc.rope(
            50,
            length=1.0,
            stiffness=5000.0,
            damping=1.5,
            mass=0.004,
            direction=(math.cos(angle), math.sin(angle)),
            pinned="start",
        )
        for angle in np.radians(np.linspace(-180.0, 0.0, ROPES))
    ]
    return pc.Scene(*ropes, pc.Gravity((0.0, -9.81)), pc.Drag(linear=2e-3))


def rainbow(bodies: Sequence[pc.Body]) -> dict[pc.Body | str, tuple[int, int, int]]:
    """A color for each body, along the circle of hues without its last sixth."""
    hues = [colorsys.hsv_to_rgb(0.83 * index / (len(bodies) - 1), 0.72, 1.0) for index in range(len(bodies))]
    colors = [(round(255 * red), round(255 * green), round(255 * blue)) for red, green, blue in hues]
    return dict(zip(bodies, colors, strict=True))


def main(path: str | os.PathLike[str] = "rope.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    # The tips oscillate at frequencies close to the limit of stability. With a fifth of it the budget closes too.
    recording = pc.simulate(scene(), duration=DURATION, fps=60, dt=pc.AutoStep(safety=0.2), progress=progress)
    style = pc.styles.Strain(width=4.0, color=rainbow(recording.scene.bodies))
    camera = Window((-1.1, -1.1), (1.1, 0.1))
    pc.film(
        recording,
        path,
        size=(640, 440),
        style=style,
        camera=camera,
        speed=0.4,
        max_bytes=3_000_000,
        title="A fan of ropes",
        subtitle="Released at all angles; the outer ones crack like whips",
        progress=progress,
    )
    return {"ropes": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms, after the cracks of the whips."""
    return budget(recordings, bound=5e-3)
