"""Two dams break in opposite corners of a tank, and the waves meet along its diagonal; white is fast.

`physcore demo two_dams --particles 1000000` runs the same scene in more detail. With n particles the number of steps
grows like n^⅓, and the time like n^(4/3). The command prints an estimate of the time beforehand.

The physics checked: the energy from the fall of the water becomes motion and heat.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import physcore as pc
from physcore.checks import count
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget
from physcore.numerics.choices import Options

DURATION = 0.8
"""Simulated time [s]."""
METHOD = pc.WeaklyCompressible(kernel=pc.WendlandC2(smoothing=1.25))
"""Method of the fluid."""
NUMERICS: Options = {"fluids": METHOD, "dt": pc.AutoStep(safety=0.8)}
"""Numerics: steps of 0.8 of the limit, instead of the default 0.5."""
PARTICLES = 20_000
"""Approximate number of particles, to 1 %; `--particles` of the command line changes it."""
FEWEST = 1000
"""Least number of particles; with fewer, a column would be less than three particles high."""
WIDTH, HEIGHT = 0.9, 0.2
"""Width and height of the water behind a dam [m]."""
SIDE, TALL = 2.0, 0.6
"""Side and height of the tank [m]."""


def scene(particles: int = PARTICLES) -> pc.Scene:
    """Remove both dams; each holds 160 liters."""
    particles = count(particles, "particles", least=FEWEST)
    across = round((particles * WIDTH / (2.0 * HEIGHT)) ** (1.0 / 3.0))
    spacing = WIDTH / across  # so that all walls are half a spacing away
    dams = [
        pc.Fluid(pc.block((x, x, 0.0), (x + WIDTH, x + WIDTH, HEIGHT), spacing), spacing, name=name)
        for x, name in ((0.0, "near"), (SIDE - WIDTH, "far"))
    ]
    return pc.Scene(*dams, pc.Gravity((0.0, 0.0, -9.81)), pc.Box((0.0, 0.0, 0.0), (SIDE, SIDE, TALL)))


def main(
    path: str | os.PathLike[str] = "two_dams.gif", progress: bool | None = None, particles: int = PARTICLES
) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(particles), duration=DURATION, fps=60, progress=progress, **NUMERICS)
    camera = Orbit(azimuth=-62.0, elevation=30.0, target=(1.0, 1.0, 0.15), extent=2.4)
    style = pc.styles.Fluid(surface=True, top=2.5)
    pc.film(
        recording,
        path,
        size=(640, 460),
        style=style,
        camera=camera,
        speed=0.4,
        title="Two dams break",
        subtitle="Their waves meet along the diagonal; white is fast",
        progress=progress,
    )
    return {"water": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms."""
    return budget(recordings, bound=2e-2)
