"""Toys fall into a basin, make waves, and come to rest at the depths at which they float.

The physics checked: 45 % of a box of 45 % of the density of water is under water, by Archimedes' principle.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure
from physcore.scene.solids import Capsule

WIDTH, DEPTH, SPACING = 3.0, 0.6, 1 / 44
"""Width of the basin, depth of the water and its spacing [m]."""
LENGTH, HEIGHT, DENSITY, WATER = 0.48, 0.28, 450.0, 1000.0
"""Length and height of the box [m], its density and that of water [kg/m³]."""

DURATION = 7.0
"""Simulated time [s]."""


def duck(size: float) -> np.ndarray:
    """The outline of a toy duck (V, 2) [m]."""
    body = [(0.62 * math.cos(a), 0.36 * math.sin(a)) for a in np.linspace(0.9 * math.pi, 2.12 * math.pi, 22)]
    head = [(0.42 + 0.24 * math.cos(a), 0.5 + 0.24 * math.sin(a)) for a in np.linspace(-0.3, 1.2 * math.pi, 16)]
    beak = [(0.86, 0.47), (0.9, 0.53)]
    return size * np.array([*body, *head[:1], *beak, *head[1:]])


def toys() -> list[pc.RigidBody]:
    """The box, and other toys above the water."""
    angles = 0.2 * math.pi * np.arange(10)
    star = np.where(np.arange(10) % 2, 0.1, 0.17)[:, np.newaxis] * np.column_stack([np.cos(angles), np.sin(angles)])
    return [
        pc.RigidBody(pc.Rectangle(LENGTH, HEIGHT), (1.1, 0.95), angle=0.5, density=DENSITY, name="box"),
        pc.RigidBody(pc.Polygon(duck(0.42)), (2.05, 1.05), angle=-0.3, density=300.0, name="duck"),
        pc.RigidBody(pc.Disc(0.14), (0.5, 1.25), density=180.0, restitution=0.4, name="ball"),
        pc.RigidBody(Capsule(0.34, 0.075), (1.55, 1.35), angle=1.2, density=650.0, name="log"),
        pc.RigidBody(pc.Polygon(star), (2.62, 1.4), angular_velocity=3.0, density=850.0, name="star"),
    ]


def scene() -> pc.Scene:
    """Toys above a basin of water."""
    water = pc.Fluid.block((0.0, 0.0), (WIDTH, DEPTH), SPACING, viscosity=1.0, name="water")
    basin = pc.Box((0.0, 0.0), (WIDTH, 2.0), restitution=0.1, friction=0.2)
    return pc.Scene(*toys(), water, basin, pc.Gravity((0.0, -9.81)))


def main(path: str | os.PathLike[str] = "floating_box.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=25, progress=progress)
    colors: dict[pc.Body | str, str | tuple[int, int, int]] = {
        "box": "#c98a4b",
        "duck": "#f6c945",
        "ball": "#e2574c",
        "log": "#8a6a4f",
        "star": "#b57edc",
    }
    style = [pc.styles.Fluid(surface=True), pc.styles.Solids(colors, marks=False)]
    camera = Window((-0.06, -0.06), (WIDTH + 0.06, 1.6))
    pc.film(
        recording,
        path,
        size=(640, 416),
        style=style,
        camera=camera,
        quality="high",
        max_bytes=3_000_000,
        title="Toys in a basin",
        subtitle="Each floats as deep as its density says",
        progress=progress,
    )
    return {"toys": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The share of the box that is under water, in the mean of the last two seconds.

    All toys float, and displace their mass of water. The level of the water follows, to half of its spacing after the
    splash. This is 4 % of the height of the box.
    """
    recording = recordings["toys"]
    level = sum(float(body.mass.sum()) for body in recording.scene.bodies) / WATER / WIDTH
    box, last = recording["box"], slice(-50, None)
    x, y = pc.block((-0.5 * LENGTH, -0.5 * HEIGHT), (0.5 * LENGTH, 0.5 * HEIGHT), 0.01).T
    angle = box.angles[last]
    height = box.positions[last, :, 1] + np.sin(angle) * x + np.cos(angle) * y
    return Figure("share of the box under water", float((height < level).mean()), DENSITY / WATER, "by Archimedes", 0.1)
