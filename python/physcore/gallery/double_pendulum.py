"""Forty double pendulums of rods start a hair's breadth apart and swing together, until chaos parts them.

The physics checked: while they are close together, they part as fast as neighbors do by their Lyapunov exponent.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import physcore as pc
from physcore.film import DARK
from physcore.gallery.figure import Figure
from physcore.gallery.rope import rainbow

PENDULUMS = 40
ANGLE, SPREAD = math.radians(127.0), math.radians(0.02)
"""Of the upper rods at the start, from below, and between the first pendulum and the last."""
LENGTHS, ANGLES, MASSES = (1.0, 0.8), (ANGLE, 2.6), (1.0, 0.7)
"""Of the rods, from the upper one down, and of the bobs at their ends [m, rad, kg]."""

DURATION = 11.0
"""[s]"""
NEAR = (2.0, 7.0)
"""When all have turned to the direction in which they part, and when some are five hundredths of a meter apart [s]."""


def scene() -> pc.Scene:
    """All hang from one point and do not feel each other."""
    return pc.Scene(*pendulums(LENGTHS, ANGLES, MASSES, np.linspace(-0.5, 0.5, PENDULUMS) * SPREAD), down())


def pendulums(
    lengths: Sequence[float], angles: Sequence[float], masses: Sequence[float], turns: np.ndarray
) -> list[pc.SpringNetwork]:
    """Pendulums of rods, from the upper one down; the upper rod of each is turned."""
    rods = len(lengths)
    result = []
    for turn in turns:
        tilts = np.array([angles[0] + turn, *angles[1:]])
        ends = np.cumsum(np.multiply(lengths, [np.sin(tilts), -np.cos(tilts)]), axis=1).T
        result.append(
            pc.SpringNetwork(
                np.vstack([(0.0, 0.0), ends]),
                [(rod, rod + 1) for rod in range(rods)],
                stiffness=math.inf,
                mass=[1.0, *masses],
                radius=[0.0, *[0.012] * (rods - 1), 0.035],
                fixed=[0],
            )
        )
    return result


def down() -> pc.Gravity:
    """On Earth."""
    return pc.Gravity((0.0, -9.81))


def main(path: str | os.PathLike[str] = "double_pendulum.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it by RATTLE of order 4, and draw rods and bobs with light behind them."""
    recording = pc.simulate(scene(), DURATION, fps=20, integrator=pc.RATTLE(4), dt=2e-3, progress=progress)
    draw(recording, path, fade=0.5, size=(400, 400), progress=progress)
    return {"pendulums": recording}


def draw(recording: pc.Recording, path: str | os.PathLike[str], *, fade: float, **options: Any) -> None:
    """Draw rods and bobs, each pendulum in a color of its own, and the way of its last bob, which fades [s]."""
    colors = rainbow(recording.scene.bodies)
    style = [pc.styles.Paths([-1], fade=fade, width=1.8), pc.styles.Strain(width=1.5, nodes=True, color=colors)]
    pc.film(recording, path, style=style, theme=replace(DARK, bodies=tuple(colors.values())), **options)


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """How fast neighbors part, and the Lyapunov exponent of the pendulum in the middle over the same time."""
    middle = pc.Scene(*pendulums(LENGTHS, ANGLES, MASSES, np.zeros(1)), down())
    return parting(recordings["pendulums"], middle, PENDULUMS, NEAR)


def parting(recording: pc.Recording, middle: pc.Scene, count: int, near: tuple[float, float]) -> Figure:
    """The time in which `count` pendulums part by e between two times [s], and one of them its neighbors."""
    begin, end = near
    first, last = (round(time * recording.fps) for time in near)
    scales = [(each.max() - each.min()) for each in (recording.positions, recording.velocities)]
    apart = [
        np.diff(each[[first, last]].reshape(2, count, -1, 2), axis=1) / scale
        for each, scale in zip((recording.positions, recording.velocities), scales, strict=True)
    ]
    squares = sum(np.square(each).sum(axis=(2, 3)) for each in apart)
    rate = 0.5 * np.diff(np.log(squares).mean(axis=1))[0] / (end - begin)
    exact = pc.lyapunov(middle, end - begin, begin, 0.01, integrator=pc.RATTLE(4), dt=1e-3, progress=False)
    quantity = f"from {begin:g} s to {end:g} s neighbors part by e in"
    return Figure(quantity, 1.0 / float(rate), 1.0 / float(exact.exponents[0]), "by the Lyapunov exponent", 0.1, "s")
