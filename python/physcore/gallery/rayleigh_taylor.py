"""A heavy fluid lies on a light one, sinks into it as a mushroom and rolls up at its rim; pale is fast.

The physics checked: the first ripple grows nearly as the linear theory has it, and what the heavy fluid loses in
height both have as motion or heat.
"""

from __future__ import annotations

import os

import numpy as np

import physcore as pc

DENSITIES = (1.0, 1.8)
"""Of the light and the heavy fluid [kg/m³]."""
RIPPLE = 0.04
"""The amplitude that the surface between them begins with [m]; its wavelength is the width of the tank, one meter."""

DURATION = 6.0
"""[s]"""


def scene() -> pc.Scene:
    """Fill a tank of two square meters, where gravity is one meter per second squared."""
    spacing, upper = 1 / 64, (1.0, 2.0)
    cells = pc.block((0.0, 0.0), upper, spacing)
    above = cells[:, 1] > 1.0 + RIPPLE * np.cos(2.0 * np.pi * cells[:, 0])
    light, heavy = (
        pc.Fluid(cells[part], spacing, density, name=name)
        for part, density, name in zip((~above, above), DENSITIES, ("light", "heavy"), strict=True)
    )
    return pc.Scene(light, heavy, pc.Gravity((0.0, -1.0)), pc.Box((0.0, 0.0), upper))


def main(path: str | os.PathLike[str] = "rayleigh_taylor.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=15, progress=progress)
    light, heavy = recording.scene.bodies
    styles = [
        pc.styles.Fluid(on=light, colormap="water", top=1.2),
        pc.styles.Fluid(on=heavy, colormap="ember", top=1.2),
    ]
    pc.film(recording, path, size=(400, 720), style=styles, progress=progress)
    return {"fluids": recording}
