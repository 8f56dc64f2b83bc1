"""Above the limit of stability a run fails at one step, however its steps were asked for, and stands before it."""

from __future__ import annotations

import math
import warnings
from functools import cache

import numpy as np
import pytest

import physcore as pc
from contracts.comparison import state
from contracts.scenes import RIGID, SCENES
from physcore.scene.fields import FIELDS, GAUGES

TOTAL = 300
CUTTINGS = {"one by one": [1] * TOTAL, "unequal": [1, 7, 64, 3, 25, 200], "halves": [TOTAL // 2] * 2}
FACTORS = [1.05, 3.0]
"""Time steps over their limit."""


@cache
def limit(name: str) -> float:
    """The limit of stability of a case [s]: where steps follow the motion, that of its start."""
    return SCENES[name].simulation().plan.dt_limit


LIMITED = [name for name, case in SCENES.items() if not case.adaptive and 0.0 < limit(name) < math.inf]
BOUNDED = {
    "network BlanesMoan6": "is unstable between narrow limits only",
    "ripples beside a network": "takes as many substeps as the limit asks for",
    "swarm star": "flies apart, away from what limits its steps",
    "swarm star f32": "likewise",
    "swarm power": "likewise",
    "swarm GaussRadau15": "likewise",
    "cluster": "is limited by accuracy, at a hundredth of a period",
    **dict.fromkeys(("cluster f32", "plasma 2D", "plasma f32 RungeKutta4", "trio", "cluster GaussRadau15"), "likewise"),
    "years in days": "likewise",
    **dict.fromkeys(("cluster by a tree", "cluster by a tree f32", "plasma by a tree 2D"), "likewise"),
    **dict.fromkeys(("selected", "selected f32 RungeKutta4"), "likewise"),
    "grains": "bounce off each other, and lose more than they gain",
    **dict.fromkeys(("grains f32", "grains by restitution", "grains by restitution f32"), "likewise"),
    **dict.fromkeys(("torn", "torn f32 RungeKutta4", "torn XPBD"), "breaks, and what is left is soft"),
    "cloth ProjectiveDynamics f32": "is limited by its drag alone, which its springs bear",
    "packet": "is limited by accuracy, and its steps are unitary",
    **dict.fromkeys(
        ("packet f32 order 4", "packet 3D interacting", "packet CrankNicolson", "packet in the open"), "likewise"
    ),
    **dict.fromkeys(
        ("butterfly", "butterfly f32 ExplicitEuler", "band RungeKuttaChebyshev", "loops f32 BogackiShampine3"),
        "is limited by accuracy, on an attractor",
    ),
    **dict.fromkeys(("stirred", "whirl", "whirl with cores f32"), "is limited by accuracy"),
    "dish RungeKuttaChebyshev": "is limited by its reaction, whose values stay within bounds",
    "heated f32 RungeKuttaChebyshev": "likewise",
    **dict.fromkeys(
        (
            "charges",
            "charges 3D f32 RungeKutta4",
            "trap",
            "trap alone",
            "trap alone f32",
            "bottle f32",
            "bottle exact",
            "by function",
        ),
        "is limited by accuracy, and turns velocities at any step",
    ),
    "wires of order 4": "is limited by accuracy, and never leaves its wires",
    **dict.fromkeys(("wires XPBD", "wires ProjectiveDynamics"), "likewise"),
    **dict.fromkeys(RIGID, "is limited by accuracy, as far as bodies turn and fall in a step"),
    "layers": "is limited as if the heaviest fluid pushed all of the net",
}
"""Who comes through three times the limit."""


def read(run: pc.Simulation, name: str) -> np.ndarray:
    """A field of a run by its whole name."""
    if hasattr(run, name):
        return getattr(run, name)
    path, _, own = name.rpartition(".")
    if path:
        values = run[path].fields[own]
        return np.stack([values.real, values.imag], axis=-1) if np.iscomplexobj(values) else values
    if FIELDS[name].element == "rigid bodies":
        return np.concatenate([getattr(run[body], FIELDS[name].part) for body in run.scene.bodies if body.is_rigid])
    rows = [getattr(run[body], name, np.full(len(body), np.nan)) for body in run.scene.bodies if not body.is_rigid]
    return np.concatenate(rows)


def outcome(run: pc.Simulation, pieces: list[int]) -> dict[str, object]:
    """How a run ends whose steps are asked for in pieces: what is said of a divergence, and where it then stands."""
    said, error = None, None
    try:
        for piece in pieces:
            run.step(piece)
    except pc.SimulationDiverged as caught:
        error = caught
    if error is not None:
        assert error.step == run.steps + 1
        assert error.last_good is not None
        assert error.last_good.time == run.time < error.time
        for name, values in error.last_good.fields.items():
            held = name in FIELDS and FIELDS[name].element in ("beads", "joints", "ties")
            if held or name in {*GAUGES, *GAUGES.values()}:
                continue  # of boundaries, probes and constraints
            assert np.array_equal(values, read(run, name), equal_nan=True)
        said = (error.step, error.time, error.particle, error.quantity, error.cause, error.hint)
    assert all(np.isfinite(values).all() for values in state(run))
    assert math.isfinite(run.energy().balance)
    return {"said": said, "steps": run.steps, "time": run.time, "hash": run.state_hash(), "energy": vars(run.energy())}


def cutting(name: str, factor: float) -> list[int]:
    """How the steps of a scene are asked for: it takes two of the ways, each with one factor."""
    return list(CUTTINGS.values())[(LIMITED.index(name) + FACTORS.index(factor)) % len(CUTTINGS)]


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("name", LIMITED)
def test_the_step_that_fails_does_not_depend_on_how_steps_were_asked_for(name, factor):
    """The diagnosis is a function of the trajectory, and after it, all is as one step earlier."""
    case = SCENES[name]
    dt = factor * limit(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pc.MachWarning)
        run = case.simulation(dt=dt)
        whole = outcome(run, [TOTAL])
        assert outcome(case.simulation(dt=dt), cutting(name, factor)) == whole
        if whole["said"] is None:
            return
        for pieces in ([1], [5]):  # tried again
            again = outcome(run, pieces)
            assert again["said"][:4] == whole["said"][:4]
            assert {**again, "said": None} == {**whole, "said": None}
        plain = case.simulation(dt=dt)
        if run.steps > 0:
            plain.step(run.steps)
    assert all((one == other).all() for one, other in zip(state(plain), state(run), strict=True))
    assert run.steps == 0 or plain.state_hash() == run.state_hash()


@pytest.mark.filterwarnings("ignore::physcore.MachWarning")
@pytest.mark.parametrize("name", LIMITED)
def test_a_first_step_that_fails_always_fails(name):
    """Far above the limit a failed step leaves enormous forces behind, which are not those of the start."""
    run = SCENES[name].simulation(dt=40.0 * limit(name))
    start, said = run.state_hash(), set()
    try:
        run.step()
    except pc.SimulationDiverged as error:
        said.add(str(error))
    for _ in range(2 * len(said)):
        with pytest.raises(pc.SimulationDiverged) as again:
            run.step()
        said.add(str(again.value))
    assert len(said) < 2
    assert run.steps == 1 or run.state_hash() == start


@pytest.mark.parametrize("name", [name for name in LIMITED if name not in BOUNDED])
def test_at_three_times_the_limit_it_fails(name):
    with pytest.raises(pc.SimulationDiverged):
        SCENES[name].simulation(dt=3.0 * limit(name)).step(TOTAL)
