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
    "wind by place": lambda f: pc.Drag(0.1, wind=lambda t, x: np.broadcast_to(wave(f)(t), x.shape)),
    "electric": lambda f: pc.ElectromagneticField(electric=lambda t, x: np.tile(wave(f)(t), (len(x), 1))),
    "magnetic": lambda f: pc.ElectromagneticField(magnetic=lambda t, x: np.full(len(x), wave(f)(t)[0])),
}


@pytest.mark.parametrize("name", FORCES)
@pytest.mark.parametrize(("periods", "told"), [(0.05, False), (0.125, False), (0.5, True), (1.0, True), (7.3, True)])
def test_functions_of_time_that_steps_do_not_resolve_are_named(name, periods, told):
    """By the number of periods in a step of 10 ms. One whole period looks constant at the ends of the steps."""
    notes = noted(0.01, FORCES[name](periods / 0.01))
    path = f"forces[0].{name.removesuffix(' by place')}"
    assert notes == [f"{path}: alternates within steps of 0.01 s, which do not resolve it; take a smaller dt"] * told


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


@pytest.mark.parametrize("periods", [*range(1, 41), 7.957747, 7.995, 63.99, 64.0, 127.9])
def test_no_frequency_is_hidden_by_the_times_that_are_looked_at(periods):
    """7.96 periods in a step are those of sin(1000 t) in 0.05 s: eight equal parts of a step see a slow wave."""
    assert len(noted(0.05, pc.Drag(0.1, wind=wave(periods / 0.05)))) == 1


def test_a_wind_on_faces_that_depends_on_the_place_is_named():
    flag = pc.cloth((3, 3), 0.1, 20.0, 0.01, origin=(0.0, 0.0, 0.0))
    wind = pc.Wind(velocity=lambda t, x: np.sin(1000.0 * t) * np.ones_like(x))
    notes = pc.Simulation(pc.Scene(flag, wind), dt=0.05, integrator="BackwardEuler").plan.notes
    assert [note.split(":")[0] for note in notes if "alternates" in note] == ["forces[0].velocity"]


def fast(time):
    return math.sin(1000.0 * time)


LINE, DISH = pc.Grid(20, spacing=1.0), pc.Grid((4, 3), spacing=1.0)
RATES = {"reaction": pc.GrayScott(0.03, 0.06), "diffusion": {"u": 1e-3, "v": 1e-3}, "initial": {"u": 1.0, "v": 0.0}}
SYSTEMS = {
    "edges['x+'].value": pc.Wave(LINE, 1.0, edges={"x-": pc.Dirichlet(math.sin), "x+": pc.Dirichlet(fast)}),
    "edges['y-'].gradient": pc.Wave(DISH, 1.0, edges={"y-": pc.Neumann(lambda t: fast(t) * np.ones(4))}),
    "edges['x-'].value": pc.ReactionDiffusion(LINE, edges={"x-": pc.Dirichlet(fast)}, **RATES),
    "edges['v']['x-'].value": pc.ReactionDiffusion(LINE, edges={"v": {"x-": pc.Dirichlet(fast)}}, **RATES),
    "sources[0].signal": pc.Wave(LINE, 1.0, sources=pc.Source((10.0,), 1.0, signal=fast)),
    "flow": pc.Tracers([[1.0, 0.0]], pc.Flow(lambda t, x: fast(t) * x)),
}


@pytest.mark.parametrize("path", SYSTEMS)
def test_functions_of_systems_are_named_once(path):
    notes = pc.Simulation(pc.Scene(SYSTEMS[path]), dt=0.05).plan.notes
    assert [note.partition(": ")[0] for note in notes if "alternates" in note] == [f"systems[0].{path}"]
