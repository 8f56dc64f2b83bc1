"""Newton's cradle: two balls fall in, and two go out on the other side.

The physics checked: the balls return after the period of a pendulum of their length and amplitude.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure
from physcore.gallery.means import arithmetic_geometric

BALLS, RAISED = 5, 2
"""Number of balls, and of those that are raised at the start."""
RADIUS, LENGTH, GAP = 0.1, 0.8, 2e-4
"""Radius of the balls, depth of their centers below the rails, and gaps between them [m]."""
ANGLE, GRAVITY = math.radians(40.0), 9.81
"""Angle at the start [rad], and acceleration of gravity [m/s²]."""
RAIL = 0.3
"""Half the distance of the two rails from which the balls hang [m]."""

DURATION = 3.7
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """A row of steel balls, each of which hangs from two rails by two rods."""
    row = (2.0 * RADIUS + GAP) * (np.arange(BALLS) - 0.5 * (BALLS - 1))
    angles = np.where(np.arange(BALLS) < RAISED, -ANGLE, 0.0)
    swing = LENGTH * np.column_stack([np.sin(angles), np.zeros(BALLS), -np.cos(angles)])
    balls = pc.RigidBodies(
        pc.Ball(RADIUS),
        swing + row[:, np.newaxis] * np.array([1.0, 0.0, 0.0]),
        density=7800.0,
        friction=0.0,
        restitution=1.0,
        name="balls",
    )
    rods = [
        pc.Rod((balls, index), None, [balls.positions[index], (x, side * RAIL, 0.0)])
        for index, x in enumerate(row)
        for side in (-1, 1)
    ]
    span = row[-1] + 0.25
    bar, post = pc.Cuboid(2.0 * span, 0.03, 0.03), pc.Cuboid(0.03, 0.03, LENGTH + 0.2)
    rails = pc.RigidBodies(bar, [(0.0, -RAIL, 0.0), (0.0, RAIL, 0.0)], fixed=[0, 1], name="rails")
    corners = [(x, y, -0.5 * (LENGTH + 0.23)) for x in (-span, span) for y in (-RAIL, RAIL)]
    posts = pc.RigidBodies(post, corners, fixed=range(4), name="posts")
    return pc.Scene(balls, *rods, rails, posts, pc.Gravity((0.0, 0.0, -GRAVITY)), pc.Floor(-LENGTH - 0.22))


def main(path: str | os.PathLike[str] = "cradle.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=30, dt=1 / 960, progress=progress)
    style = pc.styles.Solids({"balls": "#dfe6ee", "rails": "#8d5a3b", "posts": "#8d5a3b"}, marks=False)
    camera = Orbit(-70.0, 9.0, target=(0.0, 0.0, -0.5), extent=1.35)
    pc.film(
        recording,
        path,
        size=(600, 410),
        style=style,
        camera=camera,
        quality="high",
        title="Newton’s cradle",
        subtitle="Two balls fall in, and two go out",
        progress=progress,
    )
    return {"cradle": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The period, from one fall of the first ball through its lowest point to the last such fall.

    The period of small oscillations is divided by M(1, cos θ/2), with the arithmetic–geometric mean M. Balls do
    not turn with their rods, so that they swing as points.
    """
    recording = recordings["cradle"]
    x = recording["balls"].positions[:, 0, 0] + 0.5 * (BALLS - 1) * (2.0 * RADIUS + GAP)
    after = np.flatnonzero((x[:-1] < -0.1) & (x[1:] >= -0.1))
    times = (after + (-0.1 - x[after]) / (x[after + 1] - x[after])) / recording.fps
    period = 2.0 * math.pi * math.sqrt(LENGTH / GRAVITY) / arithmetic_geometric(1.0, math.cos(0.5 * ANGLE))
    return Figure("period", float(np.diff(times).mean()), period, "by theory", 2e-2, "s")
