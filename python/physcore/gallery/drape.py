"""A cloth falls over a sphere in three dimensions, and friction holds it there.

The physics checked: contacts, friction and damping take the energy released by gravity, and the budget closes.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget

DURATION = 3.0
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """Drop a square cloth onto a sphere."""
    cloth = pc.cloth(
        (48, 48),
        spacing=0.025,
        stiffness=150.0,
        damping=0.02,
        mass=0.001,
        origin=(-0.6, -0.6, 0.45),
        axes=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        bend_stiffness=15.0,
    )
    ball = pc.Sphere((0.0, 0.0, 0.0), radius=0.35, restitution=0.0, friction=0.5)
    floor = pc.Floor(-0.5, restitution=0.0, friction=0.8)
    return pc.Scene(cloth, pc.Gravity((0.0, 0.0, -9.81)), pc.Drag(linear=5e-4), ball, floor)


def gingham() -> np.ndarray:
    """Texture of a tablecloth: red stripes, darker where they cross."""
    stripe = np.arange(480) // 24 % 2
    white, pink, red = (250, 246, 240), (228, 130, 120), (186, 40, 40)
    colors = np.array([white, pink, red], dtype=np.uint8)
    return colors.take(stripe[:, np.newaxis] + stripe, axis=0)


def main(path: str | os.PathLike[str] = "drape.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=25, progress=progress)
    style = pc.styles.Surface(texture=gingham())
    camera = Orbit(azimuth=-60.0, elevation=24.0, target=(0.0, 0.0, 0.0), extent=1.3)
    pc.film(
        recording,
        path,
        size=(640, 500),
        style=style,
        camera=camera,
        labels=(),
        quality="high",
        title="A cloth drapes a ball",
        subtitle="Friction holds it there",
        progress=progress,
    )
    return {"cloth": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms, mostly heat."""
    return budget(recordings, bound=2e-2)
