"""One end of a hanging chain falls faster than a free ball, because the chain pulls it down; red is tension.

The physics checked: the end falls faster than free fall, by the time that energy conservation gives for a folded chain.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import physcore as pc
from physcore.film import DARK, Window
from physcore.gallery.figure import Figure

LINKS, LENGTH, MASS = 120, 2.0, 1.0
"""Number of links, length [m] and mass [kg] of the chain."""
TURN = 20
"""Number of links in the semicircle at the lowest point."""
GRAVITY = 9.81
"""Acceleration of gravity [m/s²]."""
DEPTH = 0.9
"""Depth of the timed fall, as a fraction of the length."""
SLACK = (255, 209, 102)
"""Color of a link without tension."""

DURATION = 0.64
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """A chain with its ends side by side, one of them held, and a ball at the height of the free end."""
    link, turn = LENGTH / LINKS, math.pi / TURN
    arms = (LINKS - TURN) // 2
    angles = np.clip(turn * (np.arange(LINKS) + 0.5 - arms), 0.0, math.pi) - 0.5 * math.pi
    steps = link * np.column_stack([np.cos(angles), np.sin(angles)])
    nodes = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
    chain = pc.SpringNetwork(
        nodes,
        np.column_stack([np.arange(LINKS), np.arange(1, LINKS + 1)]),
        stiffness=math.inf,
        mass=MASS / LINKS,
        fixed=[0],
        name="chain",
    )
    ball = pc.Particles(nodes[-1:] + np.array([0.16, 0.0]), radius=0.05, name="ball")
    return pc.Scene(chain, ball, pc.Gravity((0.0, -GRAVITY)))


def main(path: str | os.PathLike[str] = "falling_chain.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene by RATTLE and draw the links by their tensions, ten times slower than real time."""
    recording = pc.simulate(scene(), DURATION, fps=240, dt=1e-4, progress=progress)
    chain, ball = recording.scene.bodies
    style = [pc.styles.Strain(width=9.0, range=25.0, on=chain), pc.styles.Points(color="#4cc9f0", on=ball)]
    camera = Window((-0.5, -2.05), (0.8, 0.1))
    pc.film(
        recording,
        path,
        size=(360, 646),
        style=style,
        camera=camera,
        theme=replace(DARK, relaxed=SLACK),
        speed=0.1,
        title="Faster than free fall",
        subtitle="The chain pulls its own end down",
        progress=progress,
    )
    return {"chain": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The time in which the end falls nine tenths of the length, relative to that of the ball: ∫dx/v over √(2x/g).

    Energy conservation gives the speed of the falling arm of a folded chain, v² = g x (2L − x)/(L − x).

    Source: M. G. Calkin, R. H. March, Am. J. Phys. 57, 154 (1989).
    """
    recording = recordings["chain"]

    def fall(places: np.ndarray) -> float:
        fallen = (places[0, 1] - places[:, 1]) / LENGTH
        after = int(np.argmax(fallen > DEPTH))
        share = (DEPTH - fallen[after - 1]) / (fallen[after] - fallen[after - 1])
        return float(recording.times[after - 1] + share / recording.fps)

    chain, ball = fall(recording["chain"].positions[:, -1]), fall(recording["ball"].positions[:, 0])
    s = math.sqrt(DEPTH) * (np.arange(10_000) + 0.5) / 10_000  # x = L s² removes the singularity of dx/v
    expected = float(np.mean(np.sqrt((1.0 - s * s) / (2.0 - s * s))) * math.sqrt(2.0))
    return Figure("time to fall, over that of the ball", chain / ball, expected, "by energy", 0.02)
