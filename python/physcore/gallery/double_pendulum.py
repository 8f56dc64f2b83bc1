"""Forty double pendulums with almost equal initial angles swing together, until chaos separates them.

The physics checked: as long as they are close, they separate at the rate given by the Lyapunov exponent.
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
"""Initial angle of the upper rods from the downward vertical, and range of these angles over all pendulums [rad]."""
LENGTHS, ANGLES, MASSES = (1.0, 0.8), (ANGLE, 2.6), (1.0, 0.7)
"""Lengths and angles of the rods, and masses of the bobs, from the upper one down [m, rad, kg]."""

DURATION = 11.0
"""Simulated time [s]."""
NEAR = (2.0, 7.0)
"""Interval of the measurement [s]. At its start all separations have the direction of fastest growth; at its end some
are 0.05 m.
"""


def scene() -> pc.Scene:
    """All pendulums at one pivot, without interaction."""
    return pc.Scene(*pendulums(LENGTHS, ANGLES, MASSES, np.linspace(-0.5, 0.5, PENDULUMS) * SPREAD), down())


def pendulums(
    lengths: Sequence[float], angles: Sequence[float], masses: Sequence[float], turns: np.ndarray
) -> list[pc.SpringNetwork]:
    """Pendulums of rods, with lengths, angles and masses from the upper one down. `turns` are added to the upper
    angles.
    """
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
    """Gravity on Earth."""
    return pc.Gravity((0.0, -9.81))


def main(path: str | os.PathLike[str] = "double_pendulum.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene by RATTLE of order 4, and draw rods and bobs with fading paths."""
    recording = pc.simulate(scene(), DURATION, fps=20, integrator=pc.RATTLE(4), dt=2e-3, progress=progress)
    options = {"title": "Forty double pendulums", "subtitle": "They swing together, until chaos parts them"}
    draw(recording, path, fade=0.5, size=(640, 440), progress=progress, **options)
    return {"pendulums": recording}


def draw(recording: pc.Recording, path: str | os.PathLike[str], *, fade: float, **options: Any) -> None:
    """Draw rods and bobs, each pendulum in its own color, with the path of its last bob, which fades in `fade` [s],
    and the spread of these bobs.
    """
    colors = rainbow(recording.scene.bodies)
    style = [pc.styles.Paths([-1], fade=fade, width=1.8), pc.styles.Strain(width=1.5, nodes=True, color=colors)]
    curve = pc.Curve(spread, "spread", unit="m", logarithmic=True)
    theme = replace(DARK, bodies=tuple(colors.values()))
    pc.film(recording, path, style=style, theme=theme, inset=curve, max_bytes=3_000_000, **options)


def spread(recording: pc.Recording) -> np.ndarray:
    """The standard deviation of the places of the last bobs at each frame [m]."""
    tips = np.stack([recording[body].positions[:, -1] for body in recording.scene.bodies])
    apart: np.ndarray = np.sqrt(tips.var(axis=0).sum(axis=1))
    return apart


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The rate at which neighbors separate, and the Lyapunov exponent of the middle pendulum over the same time."""
    middle = pc.Scene(*pendulums(LENGTHS, ANGLES, MASSES, np.zeros(1)), down())
    return parting(recordings["pendulums"], middle, PENDULUMS, NEAR)


def parting(recording: pc.Recording, middle: pc.Scene, count: int, near: tuple[float, float]) -> Figure:
    """The time in which the separation of `count` pendulums grows by e, between two times [s], with its value from the
    Lyapunov exponent.
    """
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
