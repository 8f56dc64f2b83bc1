"""Validation: water in violent moments, with the defaults of `pc.Fluid` and long steps.

There are no figures for a splash. But whatever it looks like, it ends, nothing leaves its tank, and its energy is all
there: that is asked of each scene at the default time step and close to the limit.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import physcore as pc
from validation.flows import GRAVITY, hole, start

pytestmark = [
    pytest.mark.validation,
    pytest.mark.long,
    # Single drops are thrown up faster than anything that was to be expected.
    pytest.mark.filterwarnings("ignore::physcore.MachWarning"),
]

FALL = pc.Gravity((0.0, 0.0, -9.81))

Build = Callable[[], tuple[float, tuple[object, ...]]]


def broken_dam() -> tuple[float, tuple[object, ...]]:
    """It runs up the far wall and falls back over itself."""
    water = pc.Fluid(pc.block((0.0, 0.0), (1.0, 2.0), 0.04), 0.04)
    return 3.0, (water, GRAVITY, pc.Box((0.0, 0.0), (4.0, 3.0)))


def fallen_block() -> tuple[float, tuple[object, ...]]:
    """A block falls flat on its floor, and runs up both walls to the ceiling."""
    water = pc.Fluid(pc.block((1.0, 1.0), (2.0, 2.0), 1.0 / 30.0), 1.0 / 30.0)
    return 2.0, (water, GRAVITY, pc.Box((0.0, 0.0), (3.0, 3.0)))


def block_on_a_ball() -> tuple[float, tuple[object, ...]]:
    """A cube of water falls on a ball."""
    water = pc.Fluid(pc.block((0.5, 0.5, 0.9), (1.1, 1.1, 1.5), 0.06), 0.06)
    return 1.5, (water, FALL, pc.Sphere((0.8, 0.8, 0.5), radius=0.25), pc.Box((0.0,) * 3, (1.6,) * 3))


def splash_in_a_sphere() -> tuple[float, tuple[object, ...]]:
    """A drop falls to the bottom of a sphere and is thrown up along its wall."""
    water = pc.Fluid(pc.ball((0.2, 0.4), 0.45, 0.03), 0.03)
    return 2.0, (water, GRAVITY, pc.Sphere((0.0, 0.0), radius=1.0, inside=True))


def jets() -> tuple[float, tuple[object, ...]]:
    """Two jets meet head on, and burst into a sheet that is thinner than the support of the particles."""
    half = [pc.cylinder((0.0, 0.0, base), 0.25, 0.8, 0.06) for base in (0.1, -0.9)]
    streams = [
        pc.Fluid(cells, 0.06, velocities=(0.0, 0.0, speed)) for cells, speed in zip(half, (-5.0, 5.0), strict=True)
    ]
    return 0.6, (*streams, pc.Box((-1.5,) * 3, (1.5,) * 3))


@pytest.mark.parametrize("safety", [0.5, 0.8])
@pytest.mark.parametrize("build", [broken_dam, fallen_block, block_on_a_ball, splash_in_a_sphere, jets])
def test_violent_scenes_run_to_their_end_and_close_their_budget(build: Build, safety: float, record_property):
    """At the limit ω dt = 2 of the fastest sound a leapfrog errs by (ω dt)²/8 of its energy: by safety²/2 of what is in
    such waves. In an impact that may be a tenth of the energy, for a moment.
    """
    duration, items = build()
    run = start(*items, dt=pc.AutoStep(safety=safety))
    recording = run.record(duration, fps=50.0, channels=("positions",))
    record_property("budget", f"{hole(recording.energy):.1e}")
    assert np.isfinite(recording.positions).all()
    assert hole(recording.energy) <= 0.1 * safety**2 / 2.0
