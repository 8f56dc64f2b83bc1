"""A cloth falls over a sphere in three dimensions, and friction holds it there.

The physics checked: contacts, friction and damping take the energy that gravity gave, and the budget closes.
"""

from __future__ import annotations

import os

import physcore as pc

DURATION = 3.0
"""[s]"""


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


def main(path: str | os.PathLike[str] = "drape.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=30, progress=progress)
    pc.film(recording, path, size=(640, 480), progress=progress)
    return {"cloth": recording}
