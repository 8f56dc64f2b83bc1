"""Functions of time in a scene that change faster than its time step."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from physcore.checks import FloatArray, array, called
from physcore.errors import SceneError
from physcore.forces import Drag, ElectromagneticField, Gravity, Wind
from physcore.scene.scene import Scene

STEPS, PARTS = 16, 8
"""Number of steps that are looked at, and of equal parts of each."""
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
    for index, force in enumerate(scene.forces):
        if isinstance(force, ElectromagneticField):
            bodies = [scene.bodies[scene.index(key)] for key in force.bodies() or scene.bodies]
            place = next((body.positions[:1] for body in bodies if len(body)), None)
            for name in ("electric", "magnetic"):
                field = getattr(force, name)
                if callable(field) and place is not None:
                    yield f"forces[{index}].{name}", partial(_at, field, place)
            continue
        names = {Gravity: "acceleration", Drag: "wind", Wind: "velocity"}
        value = getattr(force, names.get(type(force), ""), None)
        if callable(value):
            yield f"forces[{index}].{names[type(force)]}", value


def _at(field: Callable[[float, FloatArray], object], place: FloatArray, time: float) -> object:
    """A field at a place, of which the function gets a copy."""
    return field(time, place.copy())


def _missed(function: Callable[[float], object], path: str, dt: float) -> float:
    """The fraction of steps within which a function deviates from the line between their ends."""
    times = dt / PARTS * np.arange(STEPS * PARTS + 1)
    try:
        values = np.stack([array(called(function, path, float(time)), path).ravel() for time in times])
    except (SceneError, ValueError):
        return 0.0  # The run itself names it.
    ends = values[::PARTS]
    share = (np.arange(PARTS) / PARTS)[:, np.newaxis]
    lines = ends[:-1, np.newaxis] * (1.0 - share) + ends[1:, np.newaxis] * share
    apart = np.abs(values[:-1].reshape(lines.shape) - lines).max(axis=(1, 2))
    extent = float(np.ptp(values, axis=0).max())
    return float((apart > RESOLVED * extent).mean()) if 0.0 < extent < np.inf else 0.0
