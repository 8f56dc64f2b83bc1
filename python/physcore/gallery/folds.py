"""A ribbon of cloth is lowered onto a floor and folds upon itself, layer upon layer.

The physics checked: contacts, friction, drag and damping take the energy released by gravity, and the budget closes.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import physcore as pc
from physcore.film import Keyframes, Orbit
from physcore.gallery.figure import Figure, budget

DURATION = 2.4
"""Simulated time [s]."""
SPACING = 0.02
"""Spacing of the particles of the ribbon [m]."""
THICKNESS = 0.008
"""Thickness of the ribbon [m]."""


def scene() -> pc.Scene:
    """A ribbon above the floor, slightly inclined, at rest."""
    ribbon = pc.cloth(
        (13, 64),
        SPACING,
        stiffness=120.0,
        damping=0.01,
        bend_stiffness=30.0,
        mass=2e-4,
        origin=(-6 * SPACING, 0.0, 0.02),
        axes=((1.0, 0.0, 0.0), (0.0, 0.08, 1.0)),
    )
    return pc.Scene(
        ribbon,
        pc.Gravity((0.0, 0.0, -9.81)),
        pc.Drag(linear=1.5e-3),
        pc.Floor(0.0, restitution=0.0, friction=0.5),
        pc.SelfContact(ribbon, THICKNESS, friction=0.3),
    )


def main(path: str | os.PathLike[str] = "folds.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=30, progress=progress)
    style = pc.styles.Surface("#ec6246")
    first = Orbit(azimuth=-62.0, elevation=6.0, target=(0.0, 0.05, 0.62), extent=1.35)
    last = Orbit(azimuth=-68.0, elevation=14.0, target=(0.0, 0.0, 0.07), extent=0.5)
    camera = Keyframes({0.0: first, 0.5: first, 1.8: last})
    pc.film(
        recording,
        path,
        size=(480, 520),
        style=style,
        camera=camera,
        quality="high",
        title="A ribbon folds",
        subtitle="Lowered onto a floor, layer upon layer",
        progress=progress,
    )
    return {"ribbon": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms, mostly heat."""
    return budget(recordings, bound=1e-2)
