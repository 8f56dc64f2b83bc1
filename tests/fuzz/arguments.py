"""Fuzzing of arguments: every public callable with hostile values for one parameter or more."""

from __future__ import annotations

from functools import partial
from itertools import islice
from typing import Any
from zlib import crc32

from entrances import Entrance, entrances, prepare
from hypothesis import strategies as st
from oracle import Fault, Target, attempt, require_finite
from values import HOSTILE, NAMES, evaluate

import physcore as pc

ENTRANCES = {entrance.name: entrance for entrance in entrances()}
CHEAP = [name for name, entrance in ENTRANCES.items() if not entrance.slow and entrance.parameters]
SLOW = [name for name, entrance in ENTRANCES.items() if entrance.slow and entrance.parameters]
NAME = {True: st.sampled_from(SLOW), False: st.sampled_from(CHEAP)}
PARAMETER = {
    name: st.sampled_from(list(entrance.parameters)) for name, entrance in ENTRANCES.items() if entrance.parameters
}
RARELY, COUNT = st.integers(0, 49).map(lambda number: number == 7), st.sampled_from([1, 1, 1, 1, 2, 2, 3])

Example = tuple[str, dict[str, str]]
"""The name of an entrance, and what is given to some of its parameters."""


@st.composite
def examples(draw: st.DrawFn) -> Example:
    """A call: one hostile argument more often than several."""
    name = draw(NAME[draw(RARELY)])
    return name, {draw(PARAMETER[name]): draw(HOSTILE) for _ in range(draw(COUNT))}


def check(example: Example) -> int:
    """Make the call; with fewer hostile arguments, if the fault is the same."""
    name, given = example
    try:
        return _call(ENTRANCES[name], given)
    except Fault as fault:
        for parameter in list(given):
            fewer = {key: value for key, value in given.items() if key != parameter}
            try:
                _call(ENTRANCES[name], fewer)
            except Fault as smaller:
                if smaller.kind == fault.kind:
                    fault, given = smaller, fewer
        raise fault from None


def _call(entrance: Entrance, given: dict[str, str]) -> int:
    script = entrance.call(given)
    values: dict[str, Any] = {}
    for name, source in {**entrance.parameters, **given}.items():
        if source is not None:
            try:
                values[name] = evaluate(source)
            except Exception:
                return 0  # NumPy does not make such a value.
    try:
        function = evaluate(entrance.source)
        rest = [NAMES["PARTICLES"], values.pop(entrance.rest)] if entrance.rest else []
    except Exception:
        return 0
    options: dict[str, Any] = {"long": entrance.long, "seconds": 0.1 if entrance.long else 2.0}
    if entrance.keys:
        options["allowed"] = (KeyError, IndexError)
    result = attempt(lambda: _finished(function(*rest, **values)), script, **options)
    if result is not None:
        _use(result, script)
    return 1


def _finished(result: Any) -> Any:
    """Of what comes piece by piece, the first pieces."""
    return list(islice(result, 3)) if hasattr(result, "__next__") else result


def _use(result: Any, script: str) -> None:
    """What was accepted works: in a scene that takes two steps, or in a picture."""
    require_finite(result, "the result is", script)
    numerics: dict[str, Any] = {"dt": 1e-3, "threads": 1}
    match result:
        case pc.Simulation():
            simulation = result
            attempt(lambda: simulation.step(2), f"{script}.step(2)", long=True, seconds=0.1)
            return _look(simulation, f"{script}.step(2)")
        case pc.Scene():
            scene, used = result, script
        case pc.Particles() | pc.SpringNetwork() | pc.Fluid():
            if len(result) > 1000:
                return
            used = f"pc.Scene({script}, pc.Gravity({(0.0, -9.81, 0.0)[: result.dimension]}))"
            gravity = pc.Gravity((0.0, -9.81, 0.0)[: result.dimension])
            scene = attempt(lambda: pc.Scene(result, gravity), used)
        case pc.Force() | pc.Boundary() | pc.Periodic():
            used = f"pc.Scene(PARTICLES, {script})"
            scene = attempt(lambda: pc.Scene(NAMES["PARTICLES"], result), used)
        case pc.AutoStep() | pc.AdaptiveStep():
            scene, used, numerics = NAMES["SCENE"], f"SCENE, dt={script}", {"dt": result, "threads": 1}
        case _ if crc32(script.encode("utf-8", "backslashreplace")) % 4 == 0:
            return _show(result, script)
        case _:
            return
    if scene is None:
        return
    used = f"pc.Simulation({used}{'' if isinstance(numerics['dt'], (pc.AutoStep, pc.AdaptiveStep)) else ', dt=1e-3'})"
    simulation = attempt(lambda: pc.Simulation(scene, **numerics), used)
    if simulation is not None:
        attempt(lambda: simulation.run(2e-3), f"{used}.run(2e-3)", long=True, seconds=0.1)
        _look(simulation, f"{used}.run(2e-3)")


def _show(result: Any, script: str) -> None:
    """A camera, style or theme that was accepted shows something."""
    film = NAMES["film"]
    kinds: dict[str, tuple[type, ...]] = {
        "style": (pc.styles.Style,),
        "camera": (film.Window, film.Orbit, film.Keyframes, film.Follow, film.Corotating),
        "theme": (film.Theme,),
    }
    for name, kind in kinds.items():
        if isinstance(result, kind):
            deep = isinstance(result, film.Orbit) or (
                isinstance(result, film.Keyframes) and not isinstance(result(0.0), film.Window)
            )
            recording = "RECORDING_3D" if deep else "RECORDING"
            options = {name: result, "size": (32, 32), "sidecar": False, "progress": False}
            call = partial(pc.film, NAMES[recording], "shown.png", **options)
            attempt(call, f"pc.film({recording}, 'shown.png', {name}={script})", seconds=5.0)


def _look(simulation: pc.Simulation, script: str) -> None:
    """The state is finite, whatever happened to it."""
    require_finite([simulation.positions, simulation.velocities], "the state is", script)
    energy = attempt(simulation.energy, f"{script}; .energy()")
    if energy is not None:
        require_finite([energy.kinetic, energy.total, energy.balance], "the energy is", f"{script}; .energy()")


TARGET = Target("arguments", examples(), check, share=0.8, quick=600, prepare=prepare)
