"""Forty double pendulums of rods start a hair's breadth apart and swing together, until chaos parts them.

The physics checked: while they are close together, they part as fast as neighbors do by their Lyapunov exponent.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence

import numpy as np

import physcore as pc
from physcore.gallery.figure import Figure

PENDULUMS = 40
ANGLE, SPREAD = math.radians(127.0), math.radians(0.02)
"""Of the upper rods at the start, from below, and between the first pendulum and the last."""
LENGTHS, ANGLES, MASSES = (1.0, 0.8), (ANGLE, 2.6), (1.0, 0.7)
"""Of the rods, from the upper one down, and of the bobs at their ends [m, rad, kg]."""

DURATION = 12.0
"""[s]"""
NEAR = (2.0, 7.0)
"""When all have turned to the direction in which they part, and when some are five hundredths of a meter apart [s]."""


def scene() -> pc.Scene:
    """All hang from one point and do not feel each other."""
    return pc.Scene(pendulums(LENGTHS, ANGLES, MASSES, np.linspace(-0.5, 0.5, PENDULUMS) * SPREAD), down())


def pendulums(
    lengths: Sequence[float], angles: Sequence[float], masses: Sequence[float], turns: np.ndarray
) -> pc.SpringNetwork:
    """Pendulums of rods, node by node: first all that are fixed, last the lowest bobs. The upper rods are turned."""
    count = len(turns)
    nodes = [np.zeros((count, 2))]
    for length, angle, turned in zip(lengths, angles, (turns, *(0.0 * turns for _ in lengths[1:])), strict=True):
        nodes.append(nodes[-1] + length * np.column_stack([np.sin(angle + turned), -np.cos(angle + turned)]))
    first = np.arange(count * len(lengths))
    return pc.SpringNetwork(
        np.concatenate(nodes),
        np.column_stack([first, first + count]),
        stiffness=math.inf,
        mass=np.repeat([1.0, *masses], count),
        radius=np.repeat([0.0, *[0.012] * (len(lengths) - 1), 0.035], count),
        fixed=np.arange(count),
    )


def down() -> pc.Gravity:
    """On Earth."""
    return pc.Gravity((0.0, -9.81))


def main(path: str | os.PathLike[str] = "double_pendulum.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate it by RATTLE of order 4, and draw rods and bobs with light behind them."""
    recording = pc.simulate(scene(), DURATION, fps=20, integrator=pc.RATTLE(4), dt=2e-3, progress=progress)
    style = [pc.styles.Paths(fade=0.9, width=1.6), pc.styles.Strain(width=1.5, nodes=True)]
    pc.film(recording, path, size=(400, 400), style=style, progress=progress)
    return {"pendulums": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """How fast neighbors part, and the Lyapunov exponent of the pendulum in the middle over the same time."""
    middle = pc.Scene(pendulums(LENGTHS, ANGLES, MASSES, np.zeros(1)), down())
    return parting(recordings["pendulums"], middle, PENDULUMS, NEAR)


def parting(recording: pc.Recording, middle: pc.Scene, count: int, near: tuple[float, float]) -> Figure:
    """The time in which `count` pendulums part by e between two times [s], and one of them its neighbors."""
    begin, end = near
    first, last = (round(time * recording.fps) for time in near)
    scales = [(each.max() - each.min()) for each in (recording.positions, recording.velocities)]
    apart = [
        np.diff(each[[first, last]].reshape(2, -1, count, 2), axis=2) / scale
        for each, scale in zip((recording.positions, recording.velocities), scales, strict=True)
    ]
    squares = sum(np.square(each).sum(axis=(1, 3)) for each in apart)
    rate = 0.5 * np.diff(np.log(squares).mean(axis=1))[0] / (end - begin)
    exact = pc.lyapunov(middle, end - begin, begin, 0.01, integrator=pc.RATTLE(4), dt=1e-3, progress=False)
    quantity = f"from {begin:g} s to {end:g} s neighbors part by e in"
    return Figure(quantity, 1.0 / float(rate), 1.0 / float(exact.exponents[0]), "by the Lyapunov exponent", 0.1, "s")
