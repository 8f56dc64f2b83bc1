"""Fuzzing of files: damaged ones, and whole ones whose content makes no sense."""

from __future__ import annotations

import copy
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from entrances import prepare as prepare_scene
from hypothesis import strategies as st
from oracle import Target, attempt, require_finite
from values import NAMES, evaluate

import physcore as pc
from physcore.storage import archive

BASES = ("checkpoint", "recording", "adaptive", "wet")
LEAF = [
    *(
        "None",
        "True",
        "0",
        "-1",
        "1",
        "2**64",
        "10**30",
        "0.5",
        "-1.0",
        "float('nan')",
        "float('inf')",
        "1e308",
        "''",
        "'x'",
    ),
    *(
        "'VelocityVerlet'",
        "[]",
        "{}",
        "[1.0]",
        "{'kind': 'Drag', 'fields': {}}",
        "{'kind': 'x', 'fields': {}}",
        "{'$array': 'x'}",
    ),
    *(
        "{'$array': 7}",
        "{'$bytes': 'header'}",
        "b'x'",
        "np.array(1.0)",
        "np.empty(0)",
        "np.zeros(3)",
        "np.ones((2, 2))",
    ),
    *("np.array([1, 2])", "np.full(2, np.nan)", "np.array([2**63], 'u8')", "np.ones(3, complex)", "np.array(['a'])"),
]
"""What may stand in a file, or almost."""
CHANGES = (
    "value[:-1]",
    "value[:0]",
    "value * np.nan",
    "value * 0",
    "-value",
    "value * 1e300",
    "value.astype('f4')",
    "value.T",
    "value + 1",
)
"""What becomes of an array."""
MIXED = ("'drop'", "'swap'", "'more'")

NUMBER = st.integers(0, 2**31)
DAMAGE = st.one_of(st.tuples(st.just("cut"), NUMBER, NUMBER), st.tuples(st.just("flip"), NUMBER, NUMBER))
CHANGE = st.tuples(st.sampled_from([*LEAF, *CHANGES, *MIXED]), NUMBER, NUMBER)
EXAMPLES = st.tuples(
    st.sampled_from(BASES), st.lists(CHANGE, min_size=1, max_size=2), st.one_of(st.none(), st.none(), st.none(), DAMAGE)
)


def prepare() -> None:
    """Write the files that are to be damaged."""
    prepare_scene()
    simulation = pc.Simulation(NAMES["SCENE"], dt=pc.AdaptiveStep(), threads=1)
    simulation.run(0.01)
    simulation.save("adaptive")
    water = pc.Scene(
        pc.Fluid(pc.block((0, 0), (0.4, 0.2), 0.1), 0.1), pc.Box((0, 0), (0.4, 0.4)), pc.Gravity((0, -9.81))
    )
    pc.Simulation(water, threads=1).save("wet")


@cache
def _content(name: str) -> tuple[str, Any, bytes]:
    return *archive.read(name), Path(name).read_bytes()


def _places(tree: Any, place: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where there is something in a tree."""
    keys = list(tree) if isinstance(tree, dict) else range(len(tree)) if isinstance(tree, list) else []
    return [inner for key in keys for inner in ((*place, key), *_places(tree[key], (*place, key)))]


def _at(tree: Any, place: tuple[Any, ...]) -> Any:
    for key in place:
        tree = tree[key]
    return tree


def check(example: tuple[str, list[tuple[str, int, int]], tuple[str, int, int] | None]) -> int:
    """Damage a file, or write another content with the right checksum: FileError, or a thing that works."""
    base, changes, damage = example
    kind, tree, data = _content(base)
    if damage is not None:
        what, first, second = damage
        data = data[: first % len(data)] if what == "cut" else _flipped(data, first % len(data), second % 8)
        Path("damaged").write_bytes(data)
        script = f"{what} of {base}: {first % len(_content(base)[2])}, {second % 8}"
    else:
        tree, script = copy.deepcopy(tree), f"kind, tree = archive.read({base!r})"
        for change, where, other in changes:
            places = _places(tree)
            place, second_place = places[where % len(places)], places[other % len(places)]
            if change in CHANGES and not isinstance(_at(tree, place), np.ndarray):
                arrays = [inner for inner in places if isinstance(_at(tree, inner), np.ndarray)]
                place = arrays[where % len(arrays)] if arrays else place
            script += f"; tree{_written(place)} = {change}"
            if change == "'swap'":
                script += f" with tree{_written(second_place)}"
            try:
                _change(tree, change, place, second_place)
                archive.write("damaged", kind, tree)
            except Exception:
                return 0
    thing = attempt(lambda: _loaded(Path("damaged")), f"{script}; pc.load")
    if thing is not None:
        _use(thing, f"{script}; pc.load")
    return 1


def _loaded(path: Path) -> Any:
    """What load gives; all that it may raise is FileError."""
    try:
        return pc.load(path)
    except pc.PhyscoreError as error:
        if not isinstance(error, pc.FileError):
            raise RuntimeError(f"{type(error).__name__}: {error}") from error
        raise


def _change(tree: Any, change: str, place: tuple[Any, ...], other: tuple[Any, ...]) -> None:
    holder, key = _at(tree, place[:-1]), place[-1]
    value = holder[key]
    match change:
        case "'drop'":
            del holder[key]
        case "'swap'":
            second, name = _at(tree, other[:-1]), other[-1]
            holder[key], second[name] = second[name], value
        case "'more'":
            _at(tree, place[:-1])["surplus"] = 1.0
        case _ if change in CHANGES:
            with np.errstate(all="ignore"):
                holder[key] = evaluate(change, value=value)
        case _:
            holder[key] = evaluate(change)


def _flipped(data: bytes, place: int, bit: int) -> bytes:
    return data[:place] + bytes([data[place] ^ (1 << bit)]) + data[place + 1 :]


def _written(place: tuple[Any, ...]) -> str:
    return "".join(f"[{key!r}]" for key in place)


def _use(thing: Any, script: str) -> None:
    """What was loaded goes on, is shown and is saved."""
    if isinstance(thing, pc.Simulation):
        state = "[simulation.positions, simulation.velocities, simulation.time, simulation.dt]"
        uses = [
            state,
            "simulation.energy().balance",
            "simulation.plan",
            "simulation.provenance",
            "simulation.run(1e-4)",
            state,
        ]
    else:
        uses = ["simulation.energy.drift", "simulation[0].positions", "len(simulation)", "simulation.provenance"]
    for use in [*uses, "simulation.save('again')", "repr(simulation)"]:
        shown = f"{script}; {use}"
        result = attempt(partial(evaluate, use, simulation=thing), shown, long=True)
        if use[0] == "[":
            require_finite(result, "what was loaded is", shown)


TARGET = Target("files", EXAMPLES, check, share=0.04, quick=120, prepare=prepare)
