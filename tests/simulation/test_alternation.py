"""Functions of time that alternate faster than the time step are noted."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc

pytestmark = pytest.mark.filterwarnings("ignore::physcore.SceneWarning", "ignore::physcore.StabilityWarning")

CHARGE = pc.Particles([[0.0, 0.0]], [[1.0, 0.0]], charge=1.0)


def noted(dt: float, *forces: pc.Force) -> list[str]:
    """The notes on alternating functions, with steps of `dt` seconds."""
    notes = pc.Simulation(pc.Scene(CHARGE, *forces), dt=dt, integrator="VelocityVerlet").plan.notes
    return [note for note in notes if "alternates" in note]


def wave(frequency: float):
    """cos(2πft) along x."""
    return lambda time: (math.cos(math.tau * frequency * time), 0.0)


FORCES = {
    "acceleration": lambda f: pc.Gravity(wave(f)),
    "wind": lambda f: pc.Drag(linear=0.1, wind=wave(f)),
    "electric": lambda f: pc.ElectromagneticField(electric=lambda t, x: np.tile(wave(f)(t), (len(x), 1))),
    "magnetic": lambda f: pc.ElectromagneticField(magnetic=lambda t, x: np.full(len(x), wave(f)(t)[0])),
}


@pytest.mark.parametrize("name", FORCES)
@pytest.mark.parametrize(("periods", "told"), [(0.05, False), (0.125, False), (0.5, True), (1.0, True), (7.3, True)])
def test_functions_of_time_that_steps_do_not_resolve_are_named(name, periods, told):
    """By the number of periods in a step of 10 ms. One whole period looks constant at the ends of the steps."""
    notes = noted(0.01, FORCES[name](periods / 0.01))
    assert notes == (
        [f"forces[0].{name}: alternates within steps of 0.01 s, which do not resolve it; take a smaller dt"] * told
    )


@pytest.mark.parametrize(
    "function",
    [
        lambda time: (0.0, -9.81),
        lambda time: (3.0 * time, 0.0),
        lambda time: (5.0 if time > 0.033 else 0.0, 0.0),
        lambda time: (math.exp(-time), 0.0),
    ],
    ids=["constant", "ramp", "switch", "decay"],
)
def test_slow_functions_and_single_jumps_are_not(function):
    assert noted(0.01, pc.Gravity(function)) == []


def test_a_function_that_fails_later_is_left_to_the_run():
    assert noted(0.01, pc.Gravity(lambda time: (1.0, 0.0) if time < 0.05 else (math.inf, 0.0))) == []
