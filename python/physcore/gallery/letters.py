"""Letters fall down stairs.

The physics checked: what gravity gives becomes motion, and heat of impacts and friction.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import cast

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure, budget

WORDS, SIZE = ("rigid", "bodies"), 1.25
"""Words that fall one after the other, and height of a line of them [m]."""
STEPS, TREAD, RISE = 6, 0.6, 0.5
"""Number of steps, their depth and their height [m]."""
SPEED = 2.5
"""Speed of the letters at the start [m/s]."""

DURATION = 5.5
"""Simulated time [s]."""


def letters(word: str, x: float, y: float) -> list[pc.RigidBody]:
    """The letters of a word that ends at `x` on a line at `y`."""
    shapes = [pc.polygon_from_mask(letter, SIZE) for letter in word]
    bodies = []
    for letter, shape in zip(reversed(word), reversed(shapes), strict=True):
        outlines = [cast(pc.Polygon, each) for each in (shape.shapes if isinstance(shape, pc.Compound) else (shape,))]
        across = np.concatenate([outline.vertices[:, 0] for outline in outlines])
        left, right = float(across.min()), float(across.max())
        place = shape.center + np.array([x - right, y])
        bodies.append(
            pc.RigidBody(shape, place, velocity=(SPEED, 0.0), friction=0.1, restitution=0.4, name=f"{letter} {x:.2f}")
        )
        x -= right - left + 0.12
    return bodies


def scene() -> pc.Scene:
    """Two words above the landing of a flight of stairs, which move towards the steps."""
    falling = letters(WORDS[0], 0.0, 0.02) + letters(WORDS[1], -0.4, 1.5)
    places = [((k + 0.5) * TREAD, -RISE * (k + 1) - 2.0) for k in range(STEPS)]
    stairs = pc.RigidBodies(pc.Rectangle(TREAD, 4.0), places, fixed=range(STEPS), friction=0.1, name="stairs")
    landing = pc.RigidBody(pc.Rectangle(6.0, 4.0), (-3.0, -2.0), fixed=True, friction=0.1, name="landing")
    walls = pc.RigidBodies(pc.Rectangle(0.2, 6.0), [(STEPS * TREAD + 3.2, -1.0)], fixed=[0], name="wall")
    floor = pc.Floor(-RISE * (STEPS + 1), restitution=0.2, friction=0.5)
    return pc.Scene(*falling, stairs, landing, walls, floor, pc.Gravity((0.0, -9.81)))


def main(path: str | os.PathLike[str] = "letters.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=30, dt=1 / 480, progress=progress)
    camera = Window((-3.9, -3.8), (7.0, 2.7))
    style = [pc.styles.Solids(marks=False)]
    pc.film(
        recording,
        path,
        size=(640, 454),
        style=style,
        camera=camera,
        quality="high",
        title="Letters",
        subtitle="They fall down stairs",
        progress=progress,
    )
    return {"letters": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms, mostly heat."""
    return budget(recordings, bound=2e-2)
