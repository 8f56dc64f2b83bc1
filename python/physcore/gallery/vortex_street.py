"""Two rows of vortices, as in the wake of a cylinder, move on and wind dye of two colors into spirals.

The physics checked: the vortex street moves at the speed found by von Kármán.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Keyframes, Window
from physcore.gallery.figure import Figure

PAIRS = 40
SPACING = 1.0
"""Distance a of neighbors in a row [m]."""
WIDTH = SPACING * math.asinh(1.0) / math.pi
"""Distance b of the rows at which the street is stable [m]. Source: T. von Kármán, Nachr. Ges. Wiss. Göttingen (1911)
509.
"""
CIRCULATION = 2.0
"""Circulation Γ of a vortex [m²/s]."""
SPEED = CIRCULATION / (2.0 * SPACING) * math.tanh(math.pi * WIDTH / SPACING)
"""Speed of an infinite street, Γ/(2 a) tanh(π b/a) [m/s]."""
CORE = 0.05
"""Core radius of a vortex, within which dye rotates rigidly [m]."""
DURATION = 3.0
"""Simulated time [s]."""
DYE = 200_000
"""Approximate number of tracers of each color."""
LAYER = 0.35
"""Thickness of a layer of dye [m]."""
SHOWN = 3.4
"""Length of the street in the picture [m]."""


def scene(dye: int = DYE) -> pc.Scene:
    """Two rows of vortices: counterclockwise in the upper row and clockwise in the lower one, so that they move to the
    right.
    """
    along = SPACING * (np.arange(PAIRS) - 0.5 * (PAIRS - 1))
    upper, lower = np.column_stack([along, 0.0 * along + WIDTH / 2]), np.column_stack([along, 0.0 * along - WIDTH / 2])
    lower[:, 0] += 0.5 * SPACING
    turns = np.repeat([CIRCULATION, -CIRCULATION], PAIRS)
    street = pc.PointVortices(np.concatenate([upper, lower]), turns, CORE, name="street")
    # Range of the dye: the picture during the whole film.
    left, right = -SHOWN / 2 - SPACING, SHOWN / 2 + SPACING + SPEED * DURATION
    layer = pc.block((left, 0.0), (right, LAYER), math.sqrt((right - left) * LAYER / dye))
    above, below = (pc.Tracers(layer * (1.0, sign), street, name=name) for sign, name in ((1, "above"), (-1, "below")))
    return pc.Scene(street, above, below)


def main(
    path: str | os.PathLike[str] = "vortex_street.gif", progress: bool | None = None, dye: int = DYE
) -> dict[str, pc.Recording]:
    """Simulate the scene while it is drawn, with a camera that moves along, and record the street."""
    whole = scene(dye)
    street, above, below = whole.systems

    def window(time: float) -> Window:
        middle = SPEED * time
        return Window((middle - SHOWN / 2, -0.17 * SHOWN), (middle + SHOWN / 2, 0.17 * SHOWN))

    pc.film(
        whole,
        path,
        duration=DURATION,
        fps=30,
        speed=0.6,
        size=(496, 254),
        style=[
            pc.styles.Density(colormap="ember", on=above),
            pc.styles.Density(colormap="water", on=below),
            pc.styles.Trails(duration=0.0, size=4.0, on=street),
        ],
        camera=Keyframes({0.0: window(0.0), DURATION: window(DURATION)}, easing="linear"),
        dt=0.0025,
        precision="f32",
        max_bytes=3_000_000,
        title="A vortex street",
        subtitle="Two rows of vortices wind up dye of two colors",
        progress=progress,
    )
    return {"street": pc.simulate(scene(100), DURATION, fps=20, dt=0.0025, progress=progress)}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Speed of the middle of the street in the first half; a street with n pairs on each side is slower by 1/(π n)."""
    street = recordings["street"]["street"].positions
    middle = street[:, [PAIRS // 2 - 1, PAIRS // 2, PAIRS + PAIRS // 2 - 1, PAIRS + PAIRS // 2], 0].mean(axis=1)
    times = recordings["street"].times
    return Figure(
        "speed", float((middle[40] - middle[0]) / (times[40] - times[0])), SPEED, "by von Kármán", 0.05, "m/s"
    )
