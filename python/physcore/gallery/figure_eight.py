"""Three stars of equal mass follow each other on one figure eight, by their gravitation alone.

The physics checked: the orbit closes after the period given by Chenciner and Montgomery.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure

PERIOD = 6.32591398
"""Period for G = m = 1 [s]. Source: A. Chenciner, R. Montgomery, Ann. of Math. 152, 881 (2000), with the initial values
of C. Simó.
"""
DURATION = 2.0 * PERIOD
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """One star in the middle, the two others to its left and right."""
    place, velocity = np.array([0.97000436, -0.24308753]), np.array([0.93240737, 0.86473146])
    stars = [
        pc.Particles([place], [0.5 * velocity], name="right"),
        pc.Particles([-place], [0.5 * velocity], name="left"),
        pc.Particles([0.0 * place], [-velocity], name="middle"),
    ]
    return pc.Scene(*stars, pc.Gravitation(1.0), units=pc.units.dimensionless)


def main(path: str | os.PathLike[str] = "figure_eight.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate two periods to rounding precision, and draw them."""
    recording = pc.simulate(scene(), DURATION, fps=100 / PERIOD, integrator=pc.GaussRadau15(), progress=progress)
    pc.film(
        recording,
        path,
        size=(640, 392),
        style=pc.styles.Points(color="body", size=16.0, trail=0.3 * PERIOD, glow=0.8),
        camera=Window((-1.25, -0.5), (1.25, 0.5)),
        labels=("time", "energy"),
        speed=PERIOD / 4.0,
        title="Figure eight",
        subtitle="Three equal stars follow each other on one curve",
        progress=progress,
    )
    return {"stars": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Period: twice the time of the middle star's first return to the middle."""
    stars = recordings["stars"]
    along = stars.positions[:, 2] @ np.array([0.93240737, 0.86473146])
    # The position along the chosen direction changes its sign from − to + after half a period.
    back = int(np.flatnonzero((along[1:-1] < 0.0) & (along[2:] >= 0.0))[0]) + 1
    share = along[back] / (along[back] - along[back + 1])
    return Figure("period", 2.0 * float(stars.times[back] + share / stars.fps), PERIOD, "by Simó", 1e-3)
