"""A drop falls into a shallow pool and throws up a crown, eight times slower than in life.

The physics checked: the fall of the drop is all the energy there is, and no bead of the crown is lost.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget

DURATION = 0.55
"""[s]"""


def scene() -> pc.Scene:
    """Let a drop hit a pool half as deep as the drop is wide."""
    spacing, kernel = 1 / 60, pc.WendlandC2(smoothing=1.25)
    pool = pc.Fluid(pc.block((-0.5, -0.5, 0.0), (0.5, 0.5, 5 * spacing), spacing), spacing, kernel=kernel, name="pool")
    drop = pc.Fluid(
        pc.ball((0.0, 0.0, 0.19), 0.09, spacing), spacing, velocities=(0.0, 0.0, -5.0), kernel=kernel, name="drop"
    )
    tank = pc.Box((-0.5, -0.5, 0.0), (0.5, 0.5, 0.42))
    return pc.Scene(pool, drop, pc.Gravity((0.0, 0.0, -9.81)), tank)


def main(path: str | os.PathLike[str] = "splash.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=200, progress=progress)
    pc.film(recording, path, size=(640, 440), camera=Orbit(elevation=24.0), speed=0.125, progress=progress)
    return {"splash": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The fall of the drop is all there."""
    return budget(recordings, bound=1e-2)
