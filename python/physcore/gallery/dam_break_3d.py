"""A column of water collapses in a tank, flows around a ball and breaks against the far wall; white is fast.

The physics checked: the energy from the fall of the water becomes motion and heat, and no drop leaves the tank.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget

DURATION = 2.6
"""Simulated time [s]."""
METHOD = pc.WeaklyCompressible(sound_speed=66.0, kernel=pc.WendlandC2(smoothing=1.25), artificial_viscosity=0.05)
"""Method with more viscosity and a larger speed of sound than by default. The viscosity is for the foot of the ball,
where the flow splits and particles meet head-on. The speed of sound is for the jet up the far wall, which is 1.5 times
as fast as the fall.
"""


def scene() -> pc.Scene:
    """Remove the dam in front of 700 kg of water."""
    spacing = 0.04
    column = pc.block((0.0, 0.0, 0.0), (0.8, 0.88, 1.0), spacing)
    water = pc.Fluid(column, spacing)
    ball = pc.Sphere((1.45, 0.35, 0.15), radius=0.22)
    return pc.Scene(water, pc.Gravity((0.0, 0.0, -9.81)), ball, pc.Box((0.0, 0.0, 0.0), (2.4, 0.88, 1.5)))


def main(path: str | os.PathLike[str] = "dam_break_3d.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=25, progress=progress, fluids=METHOD)
    style, camera = pc.styles.Fluid(surface=True), Orbit(-62.0, 22.0, target=(1.2, 0.44, 0.72), extent=2.3)
    pc.film(
        recording,
        path,
        size=(640, 480),
        style=style,
        camera=camera,
        max_bytes=3_000_000,
        title="A dam breaks in a tank",
        subtitle="The water flows around a ball; white is fast",
        progress=progress,
    )
    return {"water": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms."""
    return budget(recordings, bound=2e-2)
