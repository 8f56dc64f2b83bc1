"""A few drops of a substance that feeds on another grow into a labyrinth, which fills the dish.

The physics checked: the amount at the end is the initial amount, plus that formed by the reaction, minus that used up.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.gallery.figure import Figure

DURATION = 4800.0
"""Simulated time [s]."""
DROPS = ((0.62, 0.55), (1.95, 0.42), (1.28, 1.12), (0.38, 1.52), (2.22, 1.46), (1.5, 1.72))
"""Centers of the drops [m]."""


def scene() -> pc.Scene:
    """Drops in a dish with a constant feed."""
    grid = pc.Grid.over((0.0, 0.0), (2.6, 2.0), 0.008, periodic=True)
    x, y = grid.coordinates
    drops = np.max([np.exp(-((x - a) ** 2 + (y - b) ** 2) / (2.0 * 0.035**2)) for a, b in DROPS], axis=0)
    start = {"u": 1.0 - 0.5 * drops, "v": 0.3 * drops}
    dish = pc.ReactionDiffusion(grid, pc.GrayScott.pearson("theta"), {"u": 2e-5, "v": 1e-5}, start)
    return pc.Scene(dish, units=pc.units.dimensionless)


def main(path: str | os.PathLike[str] = "labyrinth.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=0.02, precision="f32", progress=progress)
    pc.film(
        recording,
        path,
        size=(468, 450),
        style=pc.styles.Field(relief=0.3),
        speed=750.0,
        max_bytes=3_000_000,
        title="A labyrinth grows",
        subtitle="A substance that feeds on another (Gray–Scott)",
        progress=progress,
    )
    return {"dish": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The amount of v at the end, compared with the initial amount plus the supply minus the removal."""
    budget = recordings["dish"].budgets["v"]
    expected = budget.total[0] + budget.supplied[-1] - budget.removed[-1]
    return Figure("substance at the end", float(budget.total[-1]), float(expected), "from its budget", 1e-4)
