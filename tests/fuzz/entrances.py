"""The public callables, found by name and signature: what is new in physcore is fuzzed without a new line here."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from values import NAMES

import physcore as pc

TRIANGLE = "[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]"

VALID = {
    **{
        "positions": TRIANGLE,
        "points": TRIANGLE,
        "pairs": "[[0, 1], [1, 2]]",
        "lower": "(0.0, 0.0)",
        "upper": "(1.0, 1.0)",
        "particles": "4",
    },
    **{"tracers": f"pc.Tracers({TRIANGLE}, pc.Flow(lambda time, x: -x))"},
    **{
        "Event.function": "lambda state: state.time - 0.5",
        "Event.axis": "'x'",
        "Event.a": "('balls', 0)",
        "Event.b": "1",
    },
    **{"flow": "pc.Flow(lambda time, x: -x)", "Flow.function": "lambda time, x: -x", "centers": TRIANGLE},
    **{"cells": "(3, 4)", "grid": "pc.Grid((3, 4), 0.5)", "where": "(0.5, 0.5)"},
    **{"reaction": "pc.GrayScott(0.04, 0.06)", "diffusion": "{'u': 0.1, 'v': 0.05}", "initial": "{'u': 1.0, 'v': 0.0}"},
    **{
        "wave_function": "np.ones((3, 4))",
        "Reaction.species": "('n',)",
        "Reaction.function": "lambda n: (n * (1 - n),)",
    },
    **{"center": "(0.0, 0.0)", "point": "(0.0, -9.0)", "normal": "(0.0, 1.0)", "acceleration": "(0.0, -9.81)"},
    **{"shape": "(3, 3)", "function": "lambda time, x, v: -x", "scene": "SCENE", "recording": "RECORDING", "key": "0"},
    **{
        "integrator": "pc.VelocityVerlet()",
        "path": "'out.physcore'",
        "duration": "0.01",
        "spacing": "0.5",
        "body": "0",
        "item": "0",
    },
    **{
        "cameras": "{0.0: film.Window((0, 0), (1, 1))}",
        "item": "pc.Gravity((0.0, -9.81))",
        "items": "pc.Gravity((0.0, 0.0))",
    },
    **{"by_term": "{}", "dissipated_by": "{}", "channels": "{}", "bodies": "0", "part": "(0.0, 1.0)", "budget": "0.01"},
    **{
        "cylinder.center": "(0.0, 0.0, 0.0)",
        "Box.lower": "(-9.0, -9.0)",
        "Box.upper": "(9.0, 9.0)",
        "Theme.bodies": "((1, 2, 3),)",
        "SelfContact.body": "pc.cloth((3, 3), 1.0, 1.0, origin=(0.0, 0.0, 0.0))",
        "Dihedral.on": "pc.cloth((3, 3), 1.0, 1.0, origin=(0.0, 0.0, 0.0))",
    },
    **{
        "Periodic.lower": "(-9.0, -9.0)",
        "Periodic.upper": "(9.0, 9.0)",
        "Sphere.center": "(9.0, 9.0)",
        "CentralForce.center": "(5.0, 5.0)",
    },
    **{
        "field": "(0.0, 1.0)",
        "moment": "(0.0, 0.0, 1.0)",
        "amplitude": "(0.0, 1.0)",
        "wave_vector": "(1.0, 0.0)",
        "PaulTrap.alternating": "1.0",
        **dict.fromkeys(
            tuple(f"{name}.center" for name in ("QuadrupoleTrap", "PaulTrap", "MagneticDipole", "CurrentLoop")),
            "(0.0, 0.0, 0.0)",
        ),
    },
    **{"Corotating.first": "0", "Corotating.second": "(0, 1)"},
    **{"build": "lambda stiffness: SCENE", "parameters": "{'stiffness': [1.0, 2.0]}"},
    **{"film.path": "'out.png'", "export.path": "'out.xyz'", "Tradeoff.path": "'out.json'"},
    **{
        "Floor.height": "-1.0",
        "load.path": "'checkpoint'",
        "provenance.path": "'film.gif'",
        "Simulation.path": "'out.physcore'",
    },
    **dict.fromkeys(
        ("background", "surface", "edge", "solid", "text", "label", "compressed", "relaxed", "stretched"), "(1, 2, 3)"
    ),
    "film.background": "'#102030'",
}
"""A valid argument by the name of the parameter, or of its owner and it; 1.0 where nothing is said."""

QUIET = {"progress": "False"}
ALWAYS: dict[str, dict[str, str]] = {
    "film": {"size": "(32, 32)", **QUIET},
    "gif_bytes": {"size": "(32, 32)"},
    "Source": {"frequency": "1.0"},
    "cloth": {"stiffness": "1.0"},
    "tradeoff": {"budget": "0.01", **QUIET},
    "sweep": {"measure": "lambda recording: 1.0", **QUIET},
    **dict.fromkeys(("export", "simulate", "Simulation.record"), QUIET),
}
"""Optional arguments that are given: calls take no time then, and are valid."""

RECEIVERS = {
    "Simulation": "pc.Simulation(SCENE, dt=1e-3, threads=1)",
    "Recording": "RECORDING",
    "Scene": "SCENE",
    "Event": "pc.Event",
}
"""Instances, and classes, whose methods are called."""

SLOW = ("lyapunov", "film", "gif_bytes", "export", "simulate", "sweep", "tradeoff", "record", "save", "stability_limit")
"""Calls that take milliseconds."""

LONG = (
    "step",
    "run",
    "record",
    "frames",
    "simulate",
    "film",
    "gif_bytes",
    "export",
    "sweep",
    "tradeoff",
    "lyapunov",
    "stability_limit",
    "plot",
    "ball",
    "block",
    "cylinder",
    "cloth",
    "rope",
    "soft_body",
)
"""Calls that may be asked for a long run, or for millions of particles."""

PARTS = (
    "Amount",
    "AmountSeries",
    "Diagnosis",
    "Finding",
    "Part",
    "Energy",
    "EnergySeries",
    "Events",
    "Frame",
    "MeasuredLimit",
    "Occurrences",
    "Plan",
    "Recording",
    "Snapshot",
    "Sweep",
    "Tradeoff",
    "Painter",
)
"""Results: nobody but physcore makes them, and they take what they are given."""

OPEN = ("Panel", "live")
"""Names that leave threads and a page open; `tests/panel` tries their arguments and messages."""
INTERNAL = ("from_content", "packed")
"""Methods that only physcore calls."""


@dataclass(frozen=True)
class Entrance:
    """Something to call."""

    source: str
    """The text before the parentheses."""
    name: str
    parameters: dict[str, str | None]
    """By name: a valid argument as a text; None: left out."""
    rest: str | None
    """The parameter that takes all positional arguments, if there is one."""
    numerics: tuple[str, ...] = ()
    """The parameters that are handed on to Simulation."""
    keys: bool = False
    """Whether it raises KeyError for what is not there."""

    @property
    def slow(self) -> bool:
        """Whether it takes milliseconds."""
        return self.name.rpartition(".")[2] in SLOW

    @property
    def long(self) -> bool:
        """Whether it may be asked for more than can be waited for."""
        return self.name.rpartition(".")[2] in LONG

    def call(self, arguments: dict[str, str]) -> str:
        """The call as a text; valid arguments where none are given."""
        given = {name: value for name, value in self.parameters.items() if value is not None} | arguments
        first = [f"*[PARTICLES, {given.pop(self.rest)}]"] if self.rest in given else []
        return f"{self.source}({', '.join([*first, *(f'{name}={value}' for name, value in given.items())])})"


def entrances() -> list[Entrance]:
    """Everything public that can be called."""
    return list(_all())


def _all() -> Iterator[Entrance]:
    film = sys.modules["physcore.film"]
    for module, prefix in ((pc, "pc"), (film, "film"), (pc.styles, "styles")):
        for name in module.__all__:
            thing = getattr(module, name)
            if name in OPEN or not callable(thing) or (prefix != "pc" and getattr(pc, name, None) is thing):
                continue
            if isinstance(thing, type) and (
                issubclass(thing, BaseException) or inspect.isabstract(thing) or name in PARTS
            ):
                continue
            yield _entrance(thing, f"{prefix}.{name}", f"{prefix}.{name}".removeprefix("pc."), name)
    for name, receiver in RECEIVERS.items():
        kind = getattr(pc, name)
        for method in dir(kind):
            thing = getattr(kind, method)
            if thing is getattr(pc, method, None):
                continue  # A function of the package that is a method too.
            if (not method.startswith("_") or method == "__getitem__") and callable(thing) and method not in INTERNAL:
                keys = method in ("__getitem__", "first_spring", "index", "parts", "path", "place", "slice")
                yield _entrance(thing, f"{receiver}.{method}", f"{name}.{method}", name, keys=keys)


def _entrance(thing: Any, source: str, name: str, owner: str, *, keys: bool = False) -> Entrance:
    parameters: dict[str, str | None] = {}
    rest: str | None = None
    numerics: tuple[str, ...] = ()
    for parameter in inspect.signature(thing).parameters.values():
        match parameter.kind:
            case parameter.VAR_KEYWORD:
                numerics = tuple(option for option in inspect.signature(pc.Simulation).parameters if option != "scene")
                parameters |= dict.fromkeys(numerics)
            case parameter.VAR_POSITIONAL:
                rest = parameter.name
                parameters[rest] = VALID[rest]
            case _ if parameter.name != "self":
                needed = parameter.default is parameter.empty
                valid = VALID.get(f"{owner}.{parameter.name}", VALID.get(parameter.name, "1.0"))
                parameters[parameter.name] = valid if needed else None
    return Entrance(source, name, {**parameters, **ALWAYS.get(name.removeprefix("film."), {})}, rest, numerics, keys)


def prepare() -> None:
    """Make what the texts name: a scene, a recording, and files of them in the present folder.

    Modules that are imported late are imported here: a call that is stopped during an import leaves half a module.
    """
    for name in (
        "matplotlib.pyplot",
        "matplotlib.colors",
        "h5py",
        "imageio_ffmpeg",
        "PIL.Image",
        "physcore.studies.sweep",
        "physcore.studies.tradeoff",
    ):
        with suppress(ImportError):
            import_module(name)
    particles = pc.Particles([[0.0, 0.5], [0.4, 0.5]], velocities=[0.1, 0.0], radius=0.01, name="balls")
    rope = pc.rope(3, 1.0, 100.0, 0.1, name="rope")
    scene = pc.Scene(particles, rope, pc.Gravity((0.0, -9.81)), pc.Floor(-1.0))
    simulation = pc.Simulation(scene, dt=1e-3, threads=1)
    recording = simulation.record(0.06, 50)
    simulation.save("checkpoint")
    recording.save("recording")
    pc.film(recording, "film.gif", size=(32, 32), sidecar=False)
    solid = pc.simulate(
        pc.Scene(pc.Particles([[0.0, 0.0, 0.0], [1.0, 0.0, 0.5]], [0.1, 0.2, 0.0])), 0.1, progress=False
    )
    NAMES.update(SCENE=scene, RECORDING=recording, PARTICLES=particles, RECORDING_3D=solid)
