"""The number of steps ahead, where steps follow the motion."""

from __future__ import annotations

import math
import warnings

import pytest

import physcore as pc
from physcore.studies.forecast import forecast

pytestmark = pytest.mark.usefixtures("clock_of_work")

CENTER = pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0)
"""A unit mass at the origin; periods are 2π."""


def orbit(eccentricity: float, side: float) -> pc.Scene:
    """An ellipse of semi-axis 1 from its periapsis (side −1) or its apocenter (side 1)."""
    speed = math.sqrt((1.0 - side * eccentricity) / (1.0 + side * eccentricity))
    return pc.Scene(pc.Particles([[1.0 + side * eccentricity, 0.0]], [[0.0, speed]]), CENTER)


TRIO = pc.Particles([[1.0, 0.0], [-0.5, 0.866], [-0.5, -0.8]], [[0.0, 0.6], [-0.52, -0.3], [0.5, -0.3]])
HIT = pc.Particles([[0.0, 0.0], [2.0, 0.0]], [[0.5, 0.0], [-0.5, 0.0]], radius=0.2)

SCENES = {
    "periapsis": (orbit(0.9, -1.0), 300.0),
    "apocenter": (orbit(0.9, 1.0), 300.0),
    "grazing periapsis": (orbit(0.999, -1.0), 400.0),
    "grazing apocenter": (orbit(0.999, 1.0), 400.0),
    "circle": (orbit(0.0, 1.0), 300.0),
    "bouncing": (pc.Scene(pc.Particles([[0.0, 1.0]]), pc.Gravity(), pc.Floor()), 20.0),
    "hit": (pc.Scene(HIT, pc.SoftSpheres(stiffness=1e3)), 10.0),
    "trio": (pc.Scene(TRIO, pc.Gravitation(1.0)), 50.0),
}


@pytest.mark.parametrize("name", SCENES)
def test_steps_that_follow_the_motion_are_foreseen_within_a_factor_of_three(name):
    scene, duration = SCENES[name]
    simulation = pc.Simulation(scene, dt=pc.AdaptiveStep())
    ahead = forecast(simulation, duration)
    assert simulation.steps == 0
    simulation.run(duration)
    assert 1.0 / 3.0 < ahead.steps / simulation.steps < 3.0


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_errors_that_choose_steps_are_foreseen_too(side):
    simulation = pc.Simulation(orbit(0.9, side), "DormandPrince5", pc.AdaptiveStep(tolerance=1e-8))
    ahead = forecast(simulation, 300.0)
    simulation.run(300.0)
    assert 1.0 / 3.0 < ahead.steps / simulation.steps < 3.0


def test_a_run_is_not_called_long_for_its_first_step():
    # The first steps are 7e-7 s, so that they alone would be 10⁹; the run takes some 10⁵.
    scene, duration = SCENES["grazing periapsis"]
    with warnings.catch_warnings():
        warnings.simplefilter("error", pc.SceneWarning)
        pc.Simulation(scene, dt=pc.AdaptiveStep()).run(duration)


def test_a_long_run_is_called_so():
    with pytest.warns(pc.SceneWarning, match=r"are [1-4]\.\de\+08 steps"):
        pc.Simulation(orbit(0.0, 1.0), dt=pc.AdaptiveStep(safety=1e-5))._stepper.warn_if_long(100.0)


def test_what_a_rehearsal_does_not_tell_is_said_to_be_unknown():
    # Its 20 000 steps end when the planet leaves its periapsis, and steps still grow.
    ahead = forecast(pc.Simulation(orbit(0.99999, -1.0), dt=pc.AdaptiveStep(safety=0.02)), 100.0)
    assert ahead.steps is None
    assert "unknown" in str(ahead)


def test_free_motion_is_timed_in_finite_time():
    free = pc.Scene(pc.Particles([[0.0, 0.0]], [[1.0, 0.0]]))
    ahead = forecast(pc.Simulation(free, "DormandPrince5", pc.AdaptiveStep(tolerance=1e-8)), 1.0)
    assert 1 <= ahead.steps <= 100
