"""A column of water collapses, runs up the far wall and falls back as a breaking wave; bright is fast.

The physics checked: what the water loses in height it has as motion or heat, and no drop leaves the tank.
"""

from __future__ import annotations

import os

import physcore as pc

DURATION = 3.6
"""[s]"""


def scene() -> pc.Scene:
    """Take away the dam in front of a column twice as high as it is wide."""
    spacing = 1 / 55
    # The jet up the far wall is twice as fast as the fall, from which the speed of sound would be chosen.
    water = pc.Fluid(pc.block((0.0, 0.0), (1.0, 2.0), spacing), spacing, sound_speed=120.0)
    return pc.Scene(water, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (4.0, 3.0)))


def main(path: str | os.PathLike[str] = "dam_break.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=25, progress=progress)
    pc.film(recording, path, size=(640, 500), progress=progress)
    return {"water": recording}
