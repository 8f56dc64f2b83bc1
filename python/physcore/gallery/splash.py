"""A drop falls into a shallow pool and throws up a crown.

The physics checked: the fall of the drop is all the energy there is, and no drop of the crown is lost.
"""

from __future__ import annotations

import os

import physcore as pc


def main(path: str | os.PathLike[str] = "splash.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Let a drop hit a pool as deep as the drop is wide."""
    spacing = 0.01
    pool = pc.Fluid(pc.block((-0.8, 0.0), (0.8, 0.2), spacing), spacing, name="pool")
    drop = pc.Fluid(pc.ball((0.0, 0.4), 0.11, spacing), spacing, velocities=(0.0, -4.0), name="drop")
    scene = pc.Scene(pool, drop, pc.Gravity((0.0, -9.81)), pc.Box((-0.8, 0.0), (0.8, 1.1)))
    recording = pc.simulate(scene, duration=1.2, fps=100, progress=progress)
    pc.film(recording, path, size=(640, 460), speed=0.25, progress=progress)
    return {"splash": recording}
