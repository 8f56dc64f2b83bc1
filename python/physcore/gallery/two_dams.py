"""Two dams break in opposite corners of a tank, and the waves meet along its diagonal; white is fast.

`physcore demo two_dams --particles 1000000` is the same in as much detail as there is time for: with n particles the
steps go with n^⅓, and the time with n^(4/3). The command says beforehand how long it takes.

The physics checked: what the water loses in height it has as motion or heat.
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
"""[s]"""
METHOD = pc.WeaklyCompressible(kernel=pc.WendlandC2(smoothing=1.25))
"""How the water is computed."""
NUMERICS: Options = {"fluids": METHOD, "dt": pc.AutoStep(safety=0.8)}
"""Steps of 0.8 of the limit instead of the half that is usual."""
PARTICLES = 20_000
"""How many particles there are, to a percent or so; `--particles` of the command line asks for others."""
FEWEST = 1000
"""With fewer a dam is no three particles high."""
WIDTH, HEIGHT = 0.9, 0.2
"""Of the water behind a dam [m]."""
SIDE, TALL = 2.0, 0.6
"""Of the tank [m]."""


def scene(particles: int = PARTICLES) -> pc.Scene:
    """Take away both dams; each holds back 160 liters."""
    particles = count(particles, "particles", least=FEWEST)
    across = round((particles * WIDTH / (2.0 * HEIGHT)) ** (1.0 / 3.0))
    spacing = WIDTH / across  # so that particles stand half of it off all walls
    dams = [
        pc.Fluid(pc.block((x, x, 0.0), (x + WIDTH, x + WIDTH, HEIGHT), spacing), spacing, name=name)
        for x, name in ((0.0, "near"), (SIDE - WIDTH, "far"))
    ]
    return pc.Scene(*dams, pc.Gravity((0.0, 0.0, -9.81)), pc.Box((0.0, 0.0, 0.0), (SIDE, SIDE, TALL)))


def main(
    path: str | os.PathLike[str] = "two_dams.gif", progress: bool | None = None, particles: int = PARTICLES
) -> dict[str, pc.Recording]:
    """Simulate it and draw it."""
    recording = pc.simulate(scene(particles), duration=DURATION, fps=60, progress=progress, **NUMERICS)
    camera = Orbit(azimuth=-62.0, elevation=30.0, target=(1.0, 1.0, 0.15), extent=2.4)
    style = pc.styles.Fluid(surface=True, top=2.5)
    pc.film(recording, path, size=(640, 420), style=style, camera=camera, speed=0.4, progress=progress)
    return {"water": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """What the water has lost in height is all there."""
    return budget(recordings, bound=2e-2)
