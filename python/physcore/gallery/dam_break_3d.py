"""A column of water collapses in a tank and breaks against the far wall, in three dimensions.

The physics checked: what the water loses in height it has as motion or heat, and no drop leaves the tank.
"""

from __future__ import annotations

import os

import physcore as pc
from physcore.film import Orbit


def main(path: str | os.PathLike[str] = "dam_break_3d.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Take away the dam in front of a cube of a cubic meter, or nearly so."""
    spacing = 0.045
    water = pc.Fluid(pc.block((0.0, 0.0, 0.0), (0.81, 0.9, 0.99), spacing), spacing)
    scene = pc.Scene(water, pc.Gravity((0.0, 0.0, -9.81)), pc.Box((0.0, 0.0, 0.0), (2.4, 0.9, 1.35)))
    recording = pc.simulate(scene, duration=2.8, fps=25, progress=progress)
    camera = Orbit(azimuth=-62.0, elevation=18.0)
    pc.film(recording, path, size=(640, 440), style=pc.styles.Fluid(), camera=camera, progress=progress)
    return {"water": recording}
