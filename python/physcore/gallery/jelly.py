"""A block of jelly is thrown into a box, spinning, and bounces until damping and walls have taken its energy.

The physics checked: total + dissipated energy stays constant through every bounce.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure, budget

DURATION = 4.0
"""[s]"""


def scene() -> pc.Scene:
    """Throw the jelly at the right wall with six radians per second."""
    nodes, spacing, corner = 14, 0.03, (-0.6, 0.2)
    x, y = np.meshgrid(np.arange(nodes) - (nodes - 1) / 2, np.arange(nodes) - (nodes - 1) / 2)
    spin = 6.0 * spacing * np.stack([-y.ravel(), x.ravel()], axis=1)
    jelly = pc.soft_body(
        (nodes, nodes),
        spacing,
        stiffness=2500.0,
        damping=0.5,
        mass=0.004,
        origin=corner,
        velocities=np.array([3.0, 2.0]) + spin,
    )
    box = pc.Box((-0.8, -0.6), (0.8, 0.8), restitution=0.6, friction=0.1)
    return pc.Scene(jelly, pc.Gravity((0.0, -9.81)), box)


def main(path: str | os.PathLike[str] = "jelly.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    # Every impact rings at frequencies close to the limit of stability: a quarter of it resolves them.
    recording = pc.simulate(scene(), duration=DURATION, fps=30, dt=pc.AutoStep(safety=0.25), progress=progress)
    style = pc.styles.Surface(color="strain", range=0.1)
    camera = Window((-0.84, -0.64), (1.98, 0.84))  # for the diagram beside the box
    pc.film(recording, path, size=(640, 370), style=style, camera=camera, inset="energy", progress=progress)
    return {"jelly": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """What the throw and gravity gave is all there, after every bounce."""
    return budget(recordings, bound=5e-3)
