"""One stiff curtain falls by five methods, four of them in steps two hundred times as long; three lose its energy.

The physics checked: BDF2, in steps of half a frame, keeps the hem where Verlet's method has it in short ones.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure

METHODS: dict[str, tuple[pc.Integrator, float | pc.AutoStep]] = {
    "Verlet": (pc.VelocityVerlet(), pc.AutoStep()),
    "BDF2": (pc.BDF2(1e-6), 1 / 50),
    "Euler": (pc.BackwardEuler(1e-6), 1 / 50),
    "XPBD": (pc.XPBD(20), 1 / 50),
    "projective": (pc.ProjectiveDynamics(30), 1 / 50),
}
"""By titles, with the time steps [s]."""

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


def stripes() -> np.ndarray:
    """Down the curtain, eight of each color."""
    _, across = np.indices((16, 480))
    return np.array([(250, 240, 225), (205, 75, 60)], dtype=np.uint8).take(across // 30 % 2, axis=0)


def main(path: str | os.PathLike[str] = "curtain.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it by each method and draw them side by side."""
    recordings = {
        title: pc.simulate(scene(), DURATION, fps=25, integrator=method, dt=dt, progress=progress)
        for title, (method, dt) in METHODS.items()
    }
    pc.film(
        list(recordings.values()),
        path,
        size=(960, 300),
        style=pc.styles.Surface(texture=stripes()),
        camera=Orbit(-65.0, 14.0, target=(0.5, 0.2, -0.4), extent=1.5),
        titles=list(recordings),
        subtitle=f"energy at the end: {', '.join(f'{each.energy.drift[-1]:+.0%}' for each in recordings.values())}",
        quality="high",
        progress=progress,
    )
    return recordings


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The mean depth of the hem over the second half of the film."""
    exact, found, *_ = (float(each.positions[50:, -COLUMNS:, 2].mean()) for each in recordings.values())
    return Figure("mean depth of the hem", found, exact, "by Verlet's method", 0.05, "m")
