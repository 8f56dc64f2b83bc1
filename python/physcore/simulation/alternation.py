"""Functions of time in a scene that change faster than its time step."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from physcore.checks import FloatArray, array, called
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.items import Force
from physcore.scene.scene import Scene

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
        for name, function in system.timed():
            yield f"systems[{index}].{name}", function


def _of_forces(scene: Scene) -> Iterator[tuple[str, Callable[[float], object]]]:
    """The functions of forces."""
    for index, force in enumerate(scene.forces):
        for name in force.timed:
            value, path = getattr(force, name), f"forces[{index}].{name}"
            place = _place(scene, force)
            if callable(value) and not getattr(force, "by_place", False):
                yield path, value
            elif callable(value) and place is not None:
                yield path, partial(_at, value, place)


def _place(scene: Scene, force: Force) -> FloatArray | None:
    """The first position of a body that a force acts on, (1, D); None if there is none."""
    bodies: list[Body] = [scene.bodies[scene.index(key)] for key in force.bodies() or scene.bodies]
    return next((body.positions[:1] for body in bodies if len(body)), None)


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
