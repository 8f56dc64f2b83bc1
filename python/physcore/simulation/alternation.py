"""Functions of time in a scene that change faster than its time step."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial

import numpy as np

from physcore.checks import FloatArray, array, called
from physcore.errors import SceneError
from physcore.forces import Drag, ElectromagneticField, Gravity, Wind
from physcore.scene.bodies import Body
from physcore.scene.edges import Valued
from physcore.scene.grid import GridSystem
from physcore.scene.items import Force
from physcore.scene.scene import Scene
from physcore.systems.flows import Flow
from physcore.systems.tracers import Tracers
from physcore.systems.wave import Wave

STEPS = 16
"""Number of steps that are looked at."""
SHARES = (np.arange(8) + np.sqrt([0.0, 2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0]) % 1.0) / 8.0
"""Times within a step, as fractions of it: eighths, each moved by the fractional part of a root.

At equal parts, a function with nearly a period in each looks slow. These roots are linearly independent over the
rational numbers, so that no frequency has whole periods between all times.
"""
RESOLVED = 0.1
"""Largest deviation from a line between the ends of a step, over the range of the function. A sine with eight steps in
its period deviates by 0.04, with four by 0.15.
"""
OFTEN = 0.25
"""Fraction of steps beyond this that is noted. A function that jumps now and then has fewer."""


def alternating(scene: Scene, dt: float) -> list[str]:
    """Notes on functions of the time that alternate faster than steps of `dt` seconds, from the start on."""
    return [
        f"{path}: alternates within steps of {dt:.3g} s, which do not resolve it; take a smaller dt"
        for path, function in _functions(scene)
        if _missed(function, path, dt) >= OFTEN
    ]


def _functions(scene: Scene) -> Iterator[tuple[str, Callable[[float], object]]]:
    """The functions of time with their paths; fields at the place of the first particle."""
    yield from _of_forces(scene)
    for index, system in enumerate(scene.systems):
        path = f"systems[{index}]"
        if isinstance(system, Tracers) and isinstance(system.flow, Flow) and len(system.positions):
            yield f"{path}.flow", partial(_at, system.flow, system.positions[:1])
        if isinstance(system, Wave):
            for number, source in enumerate(system.sources):
                if callable(source.signal):
                    yield f"{path}.sources[{number}].signal", source.signal
        if isinstance(system, GridSystem):
            yield from _of_edges(system, path)


def _of_forces(scene: Scene) -> Iterator[tuple[str, Callable[[float], object]]]:
    """The functions of forces."""
    names = {Gravity: ("acceleration",), Drag: ("wind",), Wind: ("velocity",)}
    for index, force in enumerate(scene.forces):
        fields = isinstance(force, ElectromagneticField)
        for name in ("electric", "magnetic") if fields else names.get(type(force), ()):
            value, path = getattr(force, name), f"forces[{index}].{name}"
            place = _place(scene, force)
            if callable(value) and not (fields or getattr(force, "by_place", False)):
                yield path, value
            elif callable(value) and place is not None:
                yield path, partial(_at, value, place)


def _place(scene: Scene, force: Force) -> FloatArray | None:
    """The first position of a body that a force acts on, (1, D); None if there is none."""
    bodies: list[Body] = [scene.bodies[scene.index(key)] for key in force.bodies() or scene.bodies]
    return next((body.positions[:1] for body in bodies if len(body)), None)


def _of_edges(system: GridSystem, path: str) -> Iterator[tuple[str, Callable[[float], object]]]:
    """The functions of edge conditions; those that several species share have the path of the first."""
    seen: set[int] = set()
    for field in system.units:
        species = f"[{field!r}]" if isinstance(system.edges, Mapping) else ""
        for side, condition in zip(system.grid.sides, system.conditions(field), strict=True):
            if not isinstance(condition, Valued):
                continue
            value = getattr(condition, condition.key)
            if callable(value) and id(value) not in seen:
                seen.add(id(value))
                yield f"{path}.edges{species}[{side!r}].{condition.key}", value


def _at(field: Callable[[float, FloatArray], object], place: FloatArray, time: float) -> object:
    """A field at a place, of which the function gets a copy."""
    return field(time, place.copy())


def _missed(function: Callable[[float], object], path: str, dt: float) -> float:
    """The fraction of steps within which a function deviates from the line between their ends."""
    times = np.append(dt * (np.arange(STEPS)[:, np.newaxis] + SHARES), dt * STEPS)
    try:
        values = np.stack([array(called(function, path, float(time)), path).ravel() for time in times])
    except (SceneError, ValueError):
        return 0.0  # The run itself names it.
    ends = values[:: len(SHARES)]
    share = SHARES[:, np.newaxis]
    lines = ends[:-1, np.newaxis] * (1.0 - share) + ends[1:, np.newaxis] * share
    apart = np.abs(values[:-1].reshape(lines.shape) - lines).max(axis=(1, 2))
    extent = float(np.ptp(values, axis=0).max())
    return float((apart > RESOLVED * extent).mean()) if 0.0 < extent < np.inf else 0.0
