"""One stiff curtain falls by five methods, and says what each makes of its energy and where it leaves the hem.

The physics checked: BDF2, in steps of half a frame, keeps the hem where Verlet's method has it in short ones.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure

EXACT = "Verlet, 0.1 ms"
METHODS: dict[str, tuple[pc.Integrator, float | pc.AutoStep]] = {
    EXACT: (pc.VelocityVerlet(), pc.AutoStep()),
    "BDF2": (pc.BDF2(1e-6), 1 / 50),
    "backward Euler": (pc.BackwardEuler(1e-6), 1 / 50),
    "XPBD, 20 parts": (pc.XPBD(20), 1 / 50),
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


def main(path: str | os.PathLike[str] = "curtain.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it by each method and draw them side by side."""
    recordings = {
        title: pc.simulate(scene(), DURATION, fps=25, integrator=method, dt=dt, progress=progress)
        for title, (method, dt) in METHODS.items()
    }
    pc.film(
        list(recordings.values()),
        path,
        size=(1200, 400),
        style=pc.styles.Surface("#e07a5f"),
        camera=Orbit(-55.0, 12.0, target=(0.4, 0.25, -0.42), extent=1.85),
        titles=[f"{title}: {_verdict(each, recordings[EXACT])}" for title, each in recordings.items()],
        progress=progress,
    )
    return recordings


def _verdict(recording: pc.Recording, exact: pc.Recording) -> str:
    """The drift of the energy balance at the end, and the mean distance of particles from where they should be."""
    off = float(np.linalg.norm(recording.positions - exact.positions, axis=-1).mean())
    drift = 100.0 * float(recording.energy.drift[-1])
    return "reference" if recording is exact else f"{drift:+.0f} %, {100.0 * off:.0f} cm off"


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The mean depth of the hem over the second half of the film."""
    hems = {title: each.positions[50:, -COLUMNS:, 2].mean() for title, each in recordings.items()}
    return Figure("mean depth of the hem", float(hems["BDF2"]), float(hems[EXACT]), "by Verlet's method", 0.05, "m")
