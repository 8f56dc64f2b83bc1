"""A cloth is let go and hangs from two points; its springs are blue where compressed and red where stretched.

The physics checked: what gravity gives ends up as motion, strain and heat, and the budget of all three closes.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import physcore as pc
from physcore.gallery.figure import Figure, budget

DURATION = 3.0
"""[s]"""


def scene() -> pc.Scene:
    """Hang the cloth by its upper left corner and a point in its upper edge."""
    columns, rows = 32, 22
    corner = (rows - 1) * columns
    cloth = pc.cloth(
        (columns, rows),
        spacing=0.03,
        stiffness=200.0,
        damping=0.03,
        mass=0.002,
        shear_stiffness=40.0,
        bend_stiffness=20.0,
        pinned=[corner, corner + 21],
    )
    return pc.Scene(cloth, pc.Gravity((0.0, -9.81)), pc.Drag(linear=1e-3))


def main(path: str | os.PathLike[str] = "cloth.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(), duration=DURATION, fps=25, progress=progress)
    pc.film(recording, path, size=(640, 480), style=pc.styles.Surface(color="strain"), progress=progress)
    return {"cloth": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """What gravity gave is all there."""
    return budget(recordings, bound=1e-3)
