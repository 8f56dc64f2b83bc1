"""One stiff curtain falls four times in steps of a frame, by methods of which each has its own damping.

The physics checked: projective dynamics and backward Euler, which solve one equation, bring it down alike.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure

METHODS: dict[str, pc.Integrator] = {
    "backward Euler": pc.BackwardEuler(1e-6),
    "BDF2": pc.BDF2(1e-6),
    "XPBD, 20 parts": pc.XPBD(20),
    "projective": pc.ProjectiveDynamics(30),
}
"""By titles."""

COLUMNS, ROWS, SPACING = 24, 18, 0.05
"""Of its particles [m]."""

DURATION = 4.0
"""[s]"""


def scene() -> pc.Scene:
    """Held along one edge at a few rings, level at the start; some damping brings it to rest."""
    rings = [*range(0, COLUMNS, 6), COLUMNS - 1]
    curtain = pc.cloth(
        (COLUMNS, ROWS),
        SPACING,
        stiffness=2e4,
        damping=1.0,
        bend_stiffness=2.0,
        mass=0.004,
        axes=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        pinned=rings,
    )
    return pc.Scene(curtain, pc.Gravity((0.0, 0.0, -9.81)), pc.Drag(0.002))


def main(path: str | os.PathLike[str] = "curtain.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it by each method and draw them side by side."""
    recordings = {
        title: pc.simulate(scene(), DURATION, fps=25, integrator=method, dt=1 / 50, progress=progress)
        for title, method in METHODS.items()
    }
    pc.film(
        list(recordings.values()),
        path,
        size=(720, 280),
        style=pc.styles.Surface(),
        camera=Orbit(-55.0, 12.0, target=(0.58, 0.2, -0.4), extent=1.7),
        titles=list(recordings),
        progress=progress,
    )
    return recordings


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The mean depth of the hem over the second half of the film."""
    hems = {title: each.positions[50:, -COLUMNS:, 2].mean() for title, each in recordings.items()}
    return Figure(
        "mean depth of the hem", float(hems["projective"]), float(hems["backward Euler"]), "of its equation", 0.05, "m"
    )
