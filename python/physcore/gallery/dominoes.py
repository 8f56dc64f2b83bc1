"""A marble topples a row of dominoes on a winding way.

The physics checked: the wave has a speed of its own, which is the same in the second half of the row as in the first.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure

HEIGHT, WIDTH, THICKNESS, SPACING = 0.24, 0.12, 0.035, 0.095
"""Size of a domino, and distance from one to the next [m]."""
DOMINOES = 48
"""Number of dominoes."""
MARBLE, SPEED = 0.05, 1.5
"""Radius [m] and speed [m/s] of the marble."""

DURATION = 3.4
"""Simulated time [s]."""


def way() -> tuple[np.ndarray, np.ndarray]:
    """Positions (N, 2) [m] and directions (N,) [rad] of the dominoes, on arcs to one side and the other."""
    along = SPACING * (np.arange(DOMINOES) - 0.5 * (DOMINOES - 1))
    directions = 0.85 * np.cos(2.0 * math.pi * along / (SPACING * DOMINOES / 1.5))
    steps = SPACING * np.column_stack([np.cos(directions), np.sin(directions)])
    return np.cumsum(steps, axis=0) - 0.5 * steps.sum(axis=0), directions


def scene() -> pc.Scene:
    """Dominoes that stand on the floor, and a marble that rolls towards the first of them."""
    places, directions = way()
    half = 0.5 * directions
    dominoes = pc.RigidBodies(
        pc.Cuboid(THICKNESS, WIDTH, HEIGHT),
        np.column_stack([places, np.full(DOMINOES, 0.5 * HEIGHT)]),
        orientations=np.column_stack([np.cos(half), 0.0 * half, 0.0 * half, np.sin(half)]),
        density=600.0,
        friction=0.3,
        name="dominoes",
    )
    forward = np.array([math.cos(directions[0]), math.sin(directions[0]), 0.0])
    marble = pc.RigidBody(
        pc.Ball(MARBLE),
        (*(places[0] - 0.4 * forward[:2]), MARBLE),
        velocity=SPEED * forward,
        angular_velocity=SPEED / MARBLE * np.cross((0.0, 0.0, 1.0), forward),
        density=2500.0,
        name="marble",
    )
    return pc.Scene(dominoes, marble, pc.Gravity(), pc.Floor(0.0, restitution=0.0, friction=0.5))


def main(path: str | os.PathLike[str] = "dominoes.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=30, dt=1 / 960, progress=progress)
    style = [pc.styles.Solids("index", on="dominoes"), pc.styles.Solids("#f4f4f0", on="marble")]
    pc.film(
        recording,
        path,
        size=(640, 350),
        style=style,
        camera=Orbit(-72.0, 24.0, target=(0.0, 0.0, -0.05), extent=1.75),
        color_bar=False,
        quality="high",
        title="Dominoes",
        subtitle="A marble topples a row on a winding way",
        progress=progress,
    )
    return {"dominoes": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Dominoes per second in the second half of the row, with that in the first half.

    Source: W. J. Stronge, Proc. R. Soc. Lond. A 409, 199 (1987).
    """
    recording = recordings["dominoes"]
    _, x, y, _ = recording["dominoes"].orientations.transpose(2, 0, 1)
    tilted = 1.0 - 2.0 * (x * x + y * y) < math.cos(0.3)
    times = recording.times[np.argmax(tilted, axis=0)]
    middle = DOMINOES // 2
    parts = slice(8, middle), slice(middle, -2)
    first, last = (np.polyfit(times[part], np.arange(DOMINOES)[part], 1)[0] for part in parts)
    return Figure("dominoes per second in the second half", float(last), float(first), "in the first half", 0.05)
