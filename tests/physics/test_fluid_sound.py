"""The default speed of sound: fast enough for dams and falls, so that none of them warns of its Mach number."""

from __future__ import annotations

import math
import re
import warnings

import numpy as np
import pytest

import physcore as pc

G = 9.81


def dam(width: float, height: float, tank: float, across: int, *, at: float = 0.0) -> pc.Scene:
    """A column with a number of particles across its shorter side, in a tank of a width; it begins at a height."""
    spacing = min(width, height) / across
    water = pc.Fluid.block((0.0, at), (width, at + height), spacing)
    return pc.Scene(water, pc.Gravity(), pc.Box((0.0, 0.0), (tank, 2.0 * (at + height))))


def thrown(velocity: tuple[float, float]) -> pc.Scene:
    """A block that starts with a velocity."""
    water = pc.Fluid(pc.block((0.2, 0.5), (0.7, 1.0), 0.05), 0.05, velocities=velocity)
    return pc.Scene(water, pc.Gravity(), pc.Box((0.0, 0.0), (3.0, 3.0)))


POOL = np.concatenate([pc.block((0.0, 0.0), (2.0, 0.5), 0.05), pc.block((0.8, 1.2), (1.2, 1.6), 0.05)])
TWO = [pc.Fluid.block((at, 0.0), (at + 0.5, 1.0), 0.05) for at in (0.0, 2.5)]

SCENES = {
    "dam 1:2": dam(0.5, 1.0, 2.0, 10),
    "dam 1:5": dam(0.2, 1.0, 1.6, 8),
    "dam 1:10 in a narrow tank": dam(0.2, 2.0, 0.4, 6),
    "dam 1:1": dam(1.0, 1.0, 3.0, 16),
    "dam 10:1": dam(2.0, 0.2, 4.0, 6),
    "dam beside a near wall": dam(0.6, 0.6, 0.9, 16),
    "dam of 10 cm": dam(0.05, 0.1, 0.2, 10),
    "dam of 20 m": dam(10.0, 20.0, 60.0, 10),
    "two dams": pc.Scene(*TWO, pc.Gravity(), pc.Box((0.0, 0.0), (3.0, 2.0))),
    "block from 2 m": dam(0.5, 0.5, 2.5, 12, at=2.0),
    "block from 8 m": dam(0.5, 0.5, 2.5, 10, at=8.0),
    "flat block from 1 m": dam(1.5, 0.4, 2.5, 8, at=1.0),
    "block onto a floor": pc.Scene(pc.Fluid.block((0.0, 2.0), (0.5, 2.5), 0.05), pc.Gravity(), pc.Floor()),
    "block into a pool": pc.Scene(pc.Fluid(POOL, 0.05), pc.Gravity(), pc.Box((0.0, 0.0), (2.0, 2.0))),
    "thrown forward": thrown((4.0, 0.0)),
    "thrown up": thrown((1.0, 4.0)),
}


@pytest.mark.parametrize("name", SCENES)
def test_no_default_scene_warns_of_its_mach_number(name):
    scene = SCENES[name]
    # Until the first run-up or splash is over: three times of a fall from the top.
    height = max(float(np.ptp(body.positions[:, 1]) + body.positions[:, 1].min()) for body in scene.bodies)
    with warnings.catch_warnings():
        warnings.simplefilter("error", pc.MachWarning)
        pc.Simulation(scene).run(3.0 * math.sqrt(2.0 * height / G))


def sound(scene: pc.Scene) -> float:
    """The speed of sound [m/s] that the plan states."""
    found = re.search(r"sound at (\S+) m/s", str(pc.Simulation(scene).plan))
    assert found is not None
    return float(found[1])


def test_a_dam_has_ten_times_the_speed_of_a_fall_from_its_top():
    # The highest particle is half a spacing, 0.025 m, below the top.
    assert sound(SCENES["dam 1:2"]) == pytest.approx(10.0 * math.sqrt(2.0 * G * 0.975), rel=1e-5)


def test_an_impact_counts_for_its_jets():
    # The lowest particles are half a spacing above the lower side.
    assert sound(SCENES["block onto a floor"]) == pytest.approx(17.5 * math.sqrt(2.0 * G * 2.025), rel=1e-5)
    assert sound(SCENES["thrown up"]) == pytest.approx(17.5 * math.sqrt(17.0 + 2.0 * G * 0.525), rel=1e-5)


def test_a_fluid_that_is_too_fast_still_warns():
    slow = pc.WeaklyCompressible(sound_speed=20.0)
    with pytest.warns(pc.MachWarning, match="faster than Mach 0.15 where sound has 20 m/s"):
        pc.Simulation(SCENES["dam 1:2"], fluids=slow).run(0.6)
