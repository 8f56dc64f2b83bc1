"""Fuzzing of scenes: small ones of everything, with parameters over many decades, under every choice of numerics."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from oracle import Target, attempt, require, require_finite
from values import evaluate

import physcore as pc
from physcore.integrators import INTEGRATORS

Example = tuple[str, str, tuple[str, ...], int]
"""A scene, numerics, what is done between steps, and how many steps, all but the last as texts."""

MANTISSA, EXPONENT = st.sampled_from(["1", "2.5", "7"]), st.integers(-6, 6)
FAR = st.sampled_from([-300, -150, -40, -20, 20, 40, 150, 300])
PLAIN = st.builds("{}e{}".format, MANTISSA, EXPONENT)
RARE = st.one_of(st.builds("{}e{}".format, MANTISSA, FAR), st.just("0.0"), st.just("0.0"))
NUMBER = st.integers(0, 19).flatmap(lambda number: RARE if number == 7 else PLAIN)
"""A number of any size: within six decades of 1 in most scenes."""
SIZE = st.one_of(st.just("1.0"), st.just("1.0"), NUMBER)
GRAVITY = {2: "(0.0, -9.81)", 3: "(0.0, 0.0, -9.81)"}
STATES = ("positions", "velocities")


@st.composite
def scenes(draw: st.DrawFn) -> str:
    """A scene as a text."""
    dimension = draw(st.sampled_from([2, 2, 3]))
    items = [draw(_body(dimension)) for _ in range(draw(st.sampled_from([1, 1, 2])))]
    items += [draw(_acting(dimension)) for _ in range(draw(st.integers(0, 3)))]
    if draw(st.integers(0, 5)) == 5:
        side = draw(SIZE)
        items.append(f"pc.Periodic([-2 * {side}] * {dimension}, [2 * {side}] * {dimension})")
    return f"pc.Scene({', '.join(items)})"


@st.composite
def _body(draw: st.DrawFn, dimension: int) -> str:
    size = draw(SIZE)
    vector = st.builds("[{}]".format, st.lists(NUMBER, min_size=dimension, max_size=dimension).map(", ".join))
    match draw(st.sampled_from(["particles", "particles", "rope", "soft", "network", "fluid"])):
        case "particles":
            count = draw(st.integers(1, 5))
            corners = f"pc.block([0.0] * {dimension}, [{count}.0] + [1.0] * {dimension - 1}, 1.0) * {size}"
            radius = draw(st.sampled_from(["0.0", f"0.5 * {size}", f"0.6 * {size}"]))
            charge = draw(st.sampled_from(["0.0", "1e-6"]))
            return (
                f"pc.Particles({corners}, {draw(vector)}, mass={draw(NUMBER)}, radius={radius}, charge={charge}, "
                f"fixed={draw(st.sampled_from(['None', '[0]']))})"
            )
        case "rope":
            start = f"start=[0.0] * {dimension}"
            return (
                f"pc.rope({draw(st.integers(2, 5))}, {size}, {draw(NUMBER)}, {draw(NUMBER)}, {draw(NUMBER)}, {start})"
            )
        case "soft":
            return f"pc.soft_body({(2,) * dimension}, {size}, {draw(NUMBER)}, {draw(NUMBER)}, {draw(NUMBER)})"
        case "network":
            points = draw(st.lists(vector, min_size=3, max_size=3))
            return (
                f"pc.SpringNetwork([{', '.join(points)}], [[0, 1], [1, 2], [2, 0]], {draw(NUMBER)}, rest_length={size})"
            )
    return (
        f"pc.Fluid(pc.block([0.0] * {dimension}, [2.0 * {size}] * {dimension}, {size}), {size}, {draw(NUMBER)}, "
        f"viscosity={draw(NUMBER)}, velocities={draw(vector)}, "
        f"surface_tension={draw(st.sampled_from(['0.0', '0.072']))})"
    )


@st.composite
def _acting(draw: st.DrawFn, dimension: int) -> str:
    zero, number = f"[0.0] * {dimension}", lambda: draw(NUMBER)
    makers: list[Callable[[], str]] = [
        lambda: f"pc.Gravity({GRAVITY[dimension]})",
        lambda: f"pc.Gravity([{number()}] * {dimension})",
        lambda: f"pc.Drag({number()}, {number()})",
        lambda: f"pc.Drag({number()}, wind=[{number()}] * {dimension})",
        lambda: f"pc.CentralForce([0.3] * {dimension}, {number()}, {draw(st.integers(-3, 2))}, softening={number()})",
        lambda: f"pc.LennardJones({number()}, {number()})",
        lambda: f"pc.Gravitation({number()}, {number()})",
        lambda: f"pc.Coulomb({number()}, {number()})",
        lambda: (
            f"pc.ElectromagneticField([{number()}] * {dimension}, {['', '', number(), f'[{number()}] * 3'][dimension]})"
        ),
        lambda: f"pc.SoftSpheres({number()}, {number()}, {draw(st.sampled_from(['0.0', '0.5']))})",
        lambda: f"pc.SoftSpheres({number()}, restitution={number()}, exponent={draw(st.sampled_from(['1', '1.5']))})",
        lambda: f"pc.Floor(-{number()}, restitution={draw(st.sampled_from(['0.0', '0.5', '1.0']))})",
        lambda: f"pc.Box([-{number()}] * {dimension}, [9e9] * {dimension})",
        lambda: f"pc.Sphere({zero}, 1e9, inside=True)",
    ]
    return draw(st.sampled_from(makers))()


@st.composite
def numerics(draw: st.DrawFn) -> str:
    """How to compute it, as keyword arguments."""
    kind = draw(st.sampled_from([kind for kind in INTEGRATORS if kind.advances("Wave")])).__name__
    if draw(st.integers(0, 3)) == 0:
        kind = "VelocityVerlet"
    dt = draw(st.one_of(st.sampled_from(["'auto'", "'auto'", "1e-3", "pc.AdaptiveStep()"]), NUMBER))
    rule = draw(st.sampled_from(["raise", "raise", "raise", "ignore", "substep"]))
    precision = draw(st.sampled_from(["auto", "f64", "f32"]))
    return f"integrator=pc.{kind}(), dt={dt}, precision='{precision}', on_divergence='{rule}'"


DOINGS = (
    *("energy()", "momentum()", "angular_momentum()", "plan", "state_hash()", "provenance", "[0]", "dt", "time"),
    *("set(velocities=0.5)", "set(velocities=1e300)", "set(positions=0.0)", "copy", "save", "record(1e-3, 1e4)"),
)
EXAMPLES = st.tuples(
    scenes(), numerics(), st.lists(st.sampled_from(DOINGS), max_size=3).map(tuple), st.sampled_from([1, 2, 5, 40])
)


def check(example: Example) -> int:
    """Build it twice, on one thread and on two; step one at once and the other step by step; the bits are the same."""
    text, choices, doings, steps = example
    script = f"scene = {text}\n    simulation = pc.Simulation(scene, {choices}"
    scene = attempt(lambda: evaluate(text), text)
    if scene is None:
        return 1
    chosen = evaluate(f"dict({choices})")
    one = attempt(lambda: pc.Simulation(scene, threads=1, **chosen), f"{script})")
    if one is None:
        return 2
    other = attempt(lambda: pc.Simulation(scene, threads=2, **chosen), f"{script}, threads=2)")
    require(other is not None, "another number of threads is refused", script)
    adaptive = isinstance(chosen["dt"], pc.AdaptiveStep)
    move = (lambda each, n: each.run(1e-4 * n)) if adaptive else (lambda each, n: each.step(n))
    done = f"{script})\n    simulation.{f'run({1e-4 * steps})' if adaptive else f'step({steps})'}"
    fate = _fate(lambda: move(one, steps), done)
    _look(one, done)
    if fate != "late":
        single = "fine"
        for _ in range(1 if adaptive else steps):
            single = _fate(lambda: move(other, steps if adaptive else 1), done)
            if single != "fine":
                break
        if single != "late":
            require(
                fate == single, f"one call: {_kind(fate)}, step by step: {_kind(single)}", f"{done}  # {fate}; {single}"
            )
            require(one.state_hash() == other.state_hash(), f"other bits step by step ({_kind(fate)})", done)
    for doing in doings:
        _do(one, doing, done)
    return 4 + steps + len(doings)


def _fate(move: Callable[[], Any], script: str) -> str:
    """How steps end: "fine", "late", or how they were refused."""
    outcome: list[str] = []

    def told() -> None:
        try:
            move()
        except pc.SimulationDiverged as error:
            outcome.append(f"diverged at step {error.step}")
            if error.last_good is not None:
                require_finite([error.last_good.positions, error.last_good.velocities], "last_good is", script)
        except pc.PhyscoreError as error:
            outcome.append(f"{type(error).__name__}: {error}")
            raise
        outcome.append("fine")

    attempt(told, script, long=True)
    return outcome[0] if outcome else "late"


def _kind(fate: str) -> str:
    return fate.partition(" at ")[0].partition(": ")[0]


def _do(simulation: pc.Simulation, doing: str, script: str) -> None:
    match doing:
        case "copy":
            twin = attempt(lambda: copy.copy(simulation), f"{script}\n    copy.copy(simulation)")
            require(twin is not None and twin.state_hash() == simulation.state_hash(), "a copy has other bits", script)
        case "save":
            path = Path("saved.physcore")
            attempt(lambda: simulation.save(path), f"{script}\n    simulation.save('x')")
            twin = attempt(lambda: pc.load(path), f"{script}\n    simulation.save('x'); pc.load('x')")
            require(
                twin is not None, "a checkpoint is not read back", f"{script}\n    simulation.save('x'); pc.load('x')"
            )
            require(twin.state_hash() == simulation.state_hash(), "a checkpoint has other bits", script)
        case _:
            source = f"simulation{'' if doing[0] == '[' else '.'}{doing}"
            result, told = _told(lambda: evaluate(source, simulation=simulation), f"{script}\n    {source}")
            if isinstance(result, pc.Recording):
                result = [result.positions, result.velocities, result.energy.drift]
            if not told:
                require_finite(result, f"{doing} is", f"{script}\n    {source}")
            _look(simulation, f"{script}\n    {source}")


def _told(look: Callable[[], Any], script: str) -> tuple[Any, bool]:
    """What a call gives, and whether a warning says that it is not finite."""
    told: list[str] = []

    def with_warnings() -> Any:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            result = look()
        told.extend(str(warning.message) for warning in caught)
        return result

    result = attempt(with_warnings, script, long=True)
    return result, any("beyond the range of numbers" in message for message in told)


def _look(simulation: pc.Simulation, script: str) -> None:
    """The state is finite, whatever happened, and its energy too, or a warning says that it is not."""
    require_finite([simulation.positions, simulation.velocities], "the state is", script)
    energy, told = _told(simulation.energy, f"{script}\n    simulation.energy()")
    if energy is not None and not told:
        for name in ("kinetic", "potential", "internal", "dissipated", "work"):
            value = getattr(energy, name)
            require(
                bool(np.isfinite(value)),
                f"energy().{name} is not finite",
                f"{script}\n    simulation.energy()  # {value}",
            )


TARGET = Target("scenes", EXAMPLES, check, share=0.1, quick=30)
