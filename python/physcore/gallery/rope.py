"""A rope falls from the horizontal, swings by one end, and cracks like a whip.

The physics checked: nothing but damping and drag takes energy, and the budget says how much each of them took.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure, budget

DURATION = 5.0
"""[s]"""


def scene() -> pc.Scene:
    """Let go of a horizontal rope that hangs by one end."""
    rope = pc.rope(80, length=1.0, stiffness=8000.0, damping=0.3, mass=0.004, pinned="start")
    return pc.Scene(rope, pc.Gravity((0.0, -9.81)), pc.Drag(linear=5e-4))


def main(path: str | os.PathLike[str] = "rope.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    # The tip cracks with frequencies close to the limit of stability: a fifth of it keeps the budget closed there too.
    recording = pc.simulate(scene(), duration=DURATION, fps=30, dt=pc.AutoStep(safety=0.2), progress=progress)
    style, camera = pc.styles.Strain(width=4.0), Window((-1.15, -1.2), (1.15, 0.85))  # for the diagram above the rope
    pc.film(recording, path, size=(640, 600), style=style, camera=camera, inset="energy", progress=progress)
    return {"rope": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """What gravity gave is all there, after the whip too."""
    return budget(recordings, bound=5e-3)
