"""Balls sink through a Galton board in oil, and their piles follow the binomial distribution, as the dividers do.

The physics checked: the balls spread as the sum of as many choices, left or right, as there are rows.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure

BALLS, ROWS = 300, 12
"""Number of balls and of rows of pegs."""
PITCH, RISE = 0.1, 0.09
"""Distances from peg to peg and from row to row [m]."""
PEG, BALL = 0.015, 0.016
"""Radii of pegs and balls [m]."""
SPEED, APART = 0.92, 0.05
"""Speed at which a ball sinks in the oil [m/s], and distances of the balls at the start [m]."""
BOUNCE = 0.5
"""Coefficient of restitution."""
FILLED = 0.75
"""Area of the balls over that of a pile."""

DURATION = BALLS * APART / SPEED + 4.5
"""Simulated time [s]."""


def heights() -> np.ndarray:
    """Expected heights of the piles (ROWS + 1) [m]."""
    shares = np.array([math.comb(ROWS, k) for k in range(ROWS + 1)]) / 2.0**ROWS
    return BALLS * shares * math.pi * BALL**2 / (FILLED * PITCH)


def scene() -> pc.Scene:
    """A triangle of pegs, bins below it, and a row of balls above it, all of which sink."""
    generator = np.random.default_rng(5)
    places = [(PITCH * (k - 0.5 * row), -RISE * row) for row in range(ROWS) for k in range(row + 1)]
    pegs = pc.RigidBodies(pc.Disc(PEG), places, friction=0.0, fixed=range(len(places)), name="pegs")
    start = np.column_stack([generator.uniform(-0.5, 0.5, BALLS) * BALL, 0.15 + APART * np.arange(BALLS)])
    balls = pc.RigidBodies(
        pc.Disc(BALL), start, velocities=(0.0, -SPEED), friction=0.0, restitution=BOUNCE, name="balls"
    )
    mass = float(balls.mass[0])
    bottom = -RISE * ROWS - 1.15 * heights().max()
    tops = np.maximum(np.append(0.0, heights()), np.append(heights(), 0.0)) + 2.0 * BALL
    dividers = [
        pc.RigidBody(
            pc.Rectangle(0.006, top), (PITCH * (k - 0.5 * (ROWS + 1)), bottom + 0.5 * top), fixed=True, friction=0.0
        )
        for k, top in enumerate(tops)
    ]
    sides = [pc.Plane((s * 0.5 * (ROWS + 1) * PITCH, 0.0), (-s, 0.0), restitution=0.0) for s in (-1.0, 1.0)]
    floor = pc.Floor(bottom, restitution=0.0)
    oil = pc.Drag(linear=mass * 9.81 / SPEED, on=balls)
    return pc.Scene(balls, pegs, *dividers, *sides, floor, oil, pc.Gravity((0.0, -9.81)))


def main(path: str | os.PathLike[str] = "galton.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=8, dt=1 / 480, progress=progress)
    style = pc.styles.Solids({"balls": "#f2b134", "pegs": "#8aa0b8"}, marks=False)
    camera = Window((-0.72, -1.95), (0.72, 0.2))
    pc.film(
        recording,
        path,
        size=(400, 648),
        style=style,
        camera=camera,
        speed=4.0,
        hold=1.0,
        title="A Galton board",
        subtitle="Piles of balls follow the binomial distribution",
        progress=progress,
    )
    return {"balls": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The standard deviation of the bins of all balls, with √n/2 of n rows; it is uncertain to one part in √(2 N)."""
    bins = np.round(recordings["balls"]["balls"].positions[-1, :, 0] / PITCH)
    return Figure("standard deviation of the bins", float(bins.std()), 0.5 * math.sqrt(ROWS), "by the binomial", 0.15)
