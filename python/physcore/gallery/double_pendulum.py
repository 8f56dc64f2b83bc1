"""Forty double pendulums of rods start a hair's breadth apart and swing together, until chaos parts them.

The physics checked: without friction the energy stays what it was.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.gallery.figure import Figure

PENDULUMS = 40
ANGLE, SPREAD = math.radians(127.0), math.radians(0.02)
"""Of the upper rods at the start, from below, and between the first pendulum and the last."""
UPPER, LOWER = 1.0, 0.8
"""Lengths of the rods [m]."""

DURATION = 12.0
"""[s]"""


def scene() -> pc.Scene:
    """All hang from one point and do not feel each other."""
    upper = ANGLE + SPREAD * np.linspace(-0.5, 0.5, PENDULUMS)
    elbows = UPPER * np.column_stack([np.sin(upper), -np.cos(upper)])
    bobs = elbows + LOWER * np.array([math.sin(2.6), -math.cos(2.6)])
    index = np.arange(PENDULUMS)
    rods = pc.SpringNetwork(
        np.concatenate([np.zeros((PENDULUMS, 2)), elbows, bobs]),
        np.concatenate([np.column_stack([index + k * PENDULUMS, index + (k + 1) * PENDULUMS]) for k in (0, 1)]),
        stiffness=math.inf,
        mass=np.repeat([1.0, 1.0, 0.7], PENDULUMS),
        radius=np.repeat([0.0, 0.012, 0.035], PENDULUMS),
        fixed=index,
    )
    return pc.Scene(rods, pc.Gravity((0.0, -9.81)))


def main(path: str | os.PathLike[str] = "double_pendulum.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it by RATTLE of order 4, and draw rods and bobs with light behind them."""
    recording = pc.simulate(scene(), DURATION, fps=20, integrator=pc.RATTLE(4), dt=2e-3, progress=progress)
    style = [pc.styles.Paths(fade=0.9, width=1.6), pc.styles.Strain(width=1.5, nodes=True)]
    pc.film(recording, path, size=(400, 400), style=style, progress=progress)
    return {"pendulums": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The kinetic and potential energy at the end, above that of hanging at rest, over that at the start."""
    energy = recordings["pendulums"].energy
    lowest = -9.81 * PENDULUMS * (1.0 * UPPER + 0.7 * (UPPER + LOWER))
    found = float((energy.total[-1] - lowest) / (energy.total[0] - lowest))
    return Figure("energy, end over start", found, 1.0, "by its conservation", 1e-4)
