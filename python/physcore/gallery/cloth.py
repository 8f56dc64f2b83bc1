"""A cloth falls from the horizontal, held by two corners, and swings.

The physics checked: the energy released by gravity becomes motion, strain and heat, and the budget closes.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget

SIDE = 41
"""Number of particles along each edge."""

DURATION = 3.0
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """A square meter of cloth above the ground, held by its two far corners."""
    cloth = pc.cloth(
        (SIDE, SIDE),
        spacing=0.025,
        stiffness=200.0,
        damping=0.02,
        mass=2e-4,
        origin=(-0.5, -0.5, 1.1),
        axes=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        shear_stiffness=30.0,
        bend_stiffness=2.0,
        pinned="top corners",
    )
    return pc.Scene(cloth, pc.Gravity((0.0, 0.0, -9.81)), pc.Drag(linear=2e-4), pc.Floor(0.0))


def stripes() -> np.ndarray:
    """Nine stripes along the cloth, from yellow to violet and back, which make folds visible."""
    _, across = np.indices((16, 450))
    colors = [(84, 2, 163), (156, 23, 158), (213, 84, 110), (248, 149, 64), (244, 230, 50)]
    return np.array(colors, dtype=np.uint8).take(abs(across // 50 - 4), axis=0)


def main(path: str | os.PathLike[str] = "cloth.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=25, progress=progress)
    style = pc.styles.Surface(texture=stripes())
    camera = Orbit(-58.0, 14.0, target=(0.0, 0.2, 0.53), extent=1.3)
    pc.film(
        recording,
        path,
        size=(640, 500),
        style=style,
        camera=camera,
        quality="high",
        max_bytes=3_000_000,
        title="A cloth swings",
        subtitle="Held at two corners, it falls from the horizontal",
        progress=progress,
    )
    return {"cloth": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms."""
    return budget(recordings, bound=1e-3)
