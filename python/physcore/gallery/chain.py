"""A chain of forty links swings with a heavy ball at its end; colors show the tension of each link.

The physics checked: without friction the energy is conserved.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import physcore as pc
from physcore.film import DARK, Window
from physcore.gallery.figure import Figure

LINKS, LENGTH = 40, 2.0
"""Number of links, and length of the chain [m]."""
LINK, BALL = 0.01, 3.0
"""Masses of a particle of the chain and of the ball [kg]."""
ANGLE = math.radians(75.0)
"""Initial angle from the downward vertical [rad]."""
SLACK = (255, 209, 102)
"""Color of a link without tension."""

DURATION = 6.0
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """A straight chain, initially at rest."""
    along = np.linspace(0.0, LENGTH, LINKS + 1)
    nodes = np.column_stack([math.sin(ANGLE) * along, -math.cos(ANGLE) * along])
    chain = pc.SpringNetwork(
        nodes,
        np.column_stack([np.arange(LINKS), np.arange(1, LINKS + 1)]),
        stiffness=math.inf,
        mass=[*[LINK] * LINKS, BALL],
        radius=[*[0.0] * LINKS, 0.13],
        fixed=[0],
    )
    return pc.Scene(chain, pc.Gravity((0.0, -9.81)))


def main(path: str | os.PathLike[str] = "chain.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene by RATTLE and draw the links by their tensions."""
    recording = pc.simulate(scene(), DURATION, fps=25, dt=5e-4, progress=progress)
    style = [pc.styles.Paths([-1], fade=1.6, width=4.0), pc.styles.Strain(width=7.0, range=70.0, nodes=True)]
    camera = Window((-2.25, -2.25), (2.25, 0.15))
    pc.film(
        recording,
        path,
        size=(640, 472),
        style=style,
        camera=camera,
        theme=replace(DARK, relaxed=SLACK),
        title="A chain with a heavy ball",
        subtitle="Colors show the tension of each link",
        progress=progress,
    )
    return {"chain": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Ratio of the mechanical energy at the end to that at the start, relative to the chain hanging at rest."""
    energy = recordings["chain"].energy
    lowest = -9.81 * LENGTH * (BALL + 0.5 * LINK * (LINKS - 1))
    found = float((energy.total[-1] - lowest) / (energy.total[0] - lowest))
    return Figure("energy, end over start", found, 1.0, "by its conservation", 1e-3)
