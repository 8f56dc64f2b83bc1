"""A wrecking ball swings into a tower of bricks.

The physics checked: what gravity gives becomes motion, and heat of impacts and friction.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget

BRICK = (0.48, 0.24, 0.16)
"""Size of a brick [m]."""
LAYERS = 10
"""Number of layers of the tower."""
RADIUS, ROPE = 0.3, 2.2
"""Radius of the ball, and length of its rope [m]."""

DURATION = 3.5
"""Simulated time [s]."""


def tower() -> tuple[np.ndarray, np.ndarray]:
    """Positions (N, 3) [m] and directions (N,) [rad] of the bricks, four around a shaft in each layer."""
    long, wide, high = BRICK
    places, directions = [], []
    for layer in range(LAYERS):
        along, across = 0.5 * wide * (1.0 if layer % 2 else -1.0), 0.5 * long
        for turn in 0.5 * math.pi * np.arange(4):
            x = along * math.cos(turn) - across * math.sin(turn)
            y = along * math.sin(turn) + across * math.cos(turn)
            places.append((x, y, (layer + 0.5) * high))
            directions.append(turn)
    return np.array(places), np.array(directions)


def scene() -> pc.Scene:
    """A tower of bricks, and a ball on a rod that is let go at the side."""
    places, directions = tower()
    half = 0.5 * directions
    bricks = pc.RigidBodies(
        pc.Cuboid(BRICK[0] - 0.004, BRICK[1] - 0.004, BRICK[2]),
        places,
        orientations=np.column_stack([np.cos(half), 0.0 * half, 0.0 * half, np.sin(half)]),
        density=400.0,
        friction=0.6,
        name="bricks",
    )
    pivot = np.array([-0.72, 0.0, 1.0 + ROPE])
    angle = math.radians(75.0)
    ball = pc.RigidBody(
        pc.Ball(RADIUS),
        pivot - ROPE * np.array([math.sin(angle), 0.0, math.cos(angle)]),
        density=1500.0,
        friction=0.4,
        restitution=0.1,
        name="ball",
    )
    rope = pc.Rod(ball, None, [ball.positions[0], pivot])
    return pc.Scene(bricks, ball, rope, pc.Gravity(), pc.Floor(0.0, restitution=0.0, friction=0.6))


def main(path: str | os.PathLike[str] = "wrecking_ball.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=30, dt=1 / 480, progress=progress)
    style = pc.styles.Solids({"bricks": "#c65d3b", "ball": "#8fa3bd"}, marks=False)
    camera = Orbit(-60.0, 14.0, target=(0.8, 0.0, 0.85), extent=2.9)
    pc.film(
        recording,
        path,
        size=(600, 440),
        style=style,
        camera=camera,
        quality="high",
        title="A wrecking ball",
        subtitle="It swings into a tower of bricks",
        progress=progress,
    )
    return {"tower": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy released by gravity with its final forms."""
    return budget(recordings, bound=2e-2)
