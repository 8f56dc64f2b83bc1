"""Fuzzing of the user's functions: forces, potentials and wind that give anything or raise."""

from __future__ import annotations

from functools import partial
from typing import Any

from hypothesis import strategies as st
from oracle import Target, attempt, require, require_finite
from values import ATOM, evaluate

import physcore as pc
from physcore.integrators import INTEGRATORS

RESULTS = [
    *(
        "-x",
        "-x",
        "0 * x",
        "x * np.nan",
        "x * np.inf",
        "x * 1e308",
        "x.astype(complex)",
        "x + 1j",
        "x.tolist()",
        "x[:1]",
        "x.T",
    ),
    *(
        "x[0]",
        "x[..., np.newaxis]",
        "x.astype('f4')",
        "x.astype('>f8')",
        "np.asfortranarray(x)",
        "x.astype(object)",
        "x.astype(str)",
    ),
    *(
        "np.ma.masked_array(x, x > 0)",
        "np.ma.array(x)",
        "x > 0",
        "x[::-1]",
        "np.zeros_like(x, dtype=int)",
        "[list(row) for row in x]",
    ),
    *(
        "x.ravel()",
        "x.sum()",
        "float(x.sum())",
        "x.setflags(write=True)",
        "x.__setitem__(0, 1e300)",
        "np.matrix(x)",
        "iter(x)",
    ),
    *(
        "boom(ValueError('a'))",
        "boom(TypeError('a'))",
        "boom(OverflowError('a'))",
        "boom(StopIteration())",
        "boom(SystemExit(1))",
    ),
    *(
        "boom(MemoryError())",
        "boom(RecursionError())",
        "boom(pc.SceneError('a'))",
        "boom(KeyError('a'))",
        "boom(GeneratorExit())",
    ),
    *(
        "BOX[0].step(1)",
        "BOX[0].set(velocities=1.0)",
        "BOX[0].energy()",
        "BOX[0].state_hash()",
        "BOX[0].positions",
        "1 / 0",
    ),
]
"""What a function may do with positions x, velocities v and the time."""
REFUSED = [
    *(
        "x.astype(complex)",
        "x + 1j",
        "x[:1]",
        "x[0]",
        "x[..., np.newaxis]",
        "x.astype(str)",
        "np.ma.masked_array(x, x > 0)",
    ),
    *("x.ravel()", "x.sum()", "float(x.sum())", "None", "'x'"),
]
"""What is no force on each particle, whatever NumPy could make of it."""
RESULT = st.one_of(st.sampled_from(RESULTS), st.sampled_from(RESULTS), ATOM)
WHEN = st.sampled_from(["", "", "-x if time < 2e-3 else "])
WIND = "wind"
"""In place of a potential: the function is the wind of a drag, not a force."""
POTENTIAL = st.one_of(st.none(), st.just("0.5 * float((x * x).sum())"), RESULT, st.just(WIND))
INTEGRATOR = st.sampled_from([kind.__name__ for kind in INTEGRATORS if kind.advances("Wave")])
EXAMPLES = st.tuples(WHEN, RESULT, POTENTIAL, INTEGRATOR, st.sampled_from(["1e-3", "'auto'", "pc.AdaptiveStep()"]))


class Raised(BaseException):
    """What the user's function raised came out as it was."""


def check(example: tuple[str, str, str | None, str, str]) -> int:
    """A run with such a force ends well, or with an error, and then stands at a finite state."""
    when, result, potential, integrator, dt = example
    box: list[Any] = []
    try:
        if potential == WIND:
            source = f"pc.Drag(1.0, 0.5, wind=lambda time, x: {when}{result})"
        else:
            second = "" if potential is None else f", lambda x: {potential}"
            source = f"pc.CustomForce(lambda time, x, v: {when}{result}{second})"
        force = evaluate(source, BOX=box)
    except SyntaxError:
        return 0
    script = (
        f"force = {source}\n"
        f"    simulation = BOX[0] = pc.Simulation(pc.Scene(PARTICLES, force), pc.{integrator}(), {dt})"
    )
    own = _own(result) + _own(potential or "")
    scene = pc.Scene(pc.Particles([[0.0, 0.5], [0.4, 0.5]], velocities=[0.1, 0.0]), force)
    chosen, rule = evaluate(f"pc.{integrator}()"), evaluate(dt)
    simulation = attempt(lambda: pc.Simulation(scene, chosen, rule, threads=1), script, allowed=own)
    if simulation is None:
        return 1
    require(when != "" or result not in REFUSED, "what is no array of forces is accepted", script)
    box.append(simulation)
    for doing in ("run(5e-3)", "energy().balance", "set(velocities=0.3)", "run(1e-3)"):
        shown, call = (
            f"{script}\n    simulation.{doing}",
            partial(evaluate, f"simulation.{doing}", simulation=simulation),
        )
        attempt(call, shown, allowed=own, long=True)
        require_finite([simulation.positions, simulation.velocities], "the state is", shown)
    require(simulation.steps >= 0, "steps", script)
    return 5


def _own(source: str) -> tuple[type[BaseException], ...]:
    """What a function raises itself may come out as it is."""
    if "1 / 0" in source:
        return (ZeroDivisionError,)
    return tuple(type(evaluate(source[5:-1])) for start in ("boom(",) if source.startswith(start))


TARGET = Target("functions", EXAMPLES, check, share=0.05, quick=80)
