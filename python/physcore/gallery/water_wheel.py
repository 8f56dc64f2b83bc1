"""Water falls on a wheel, whose brake takes up its power.

The physics checked: what the fall gives becomes work of the brake, motion, and heat in the water.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure
from physcore.scene.solids import Shape

RADIUS, HUB, CUPS = 0.5, 0.14, 8
"""Radii of the wheel and of its hub [m], and number of its cups."""
THICK, LIP = 0.055, 0.2
"""Thickness of the boards of the wheel, and length of the lip of a cup [m]."""
TORQUE = 90.0
"""Torque of the brake [N·m], per meter of depth."""
SPACING = 0.02
"""Spacing of the water [m]."""
CHUTE, GATE, LEVEL = 0.68, 0.09, 0.45
"""Height of the floor of the chute over the axle, opening of its gate, and depth of the water behind it [m]."""

DURATION = 6.0
"""Simulated time [s]."""


def wheel() -> pc.RigidBody:
    """A hub with boards, each of which ends in a lip, so that it holds water while it goes down on the right."""
    parts: list[tuple[Shape, tuple[float, float], float]] = [(pc.Disc(HUB), (0.0, 0.0), 0.0)]
    for angle in 2.0 * math.pi * np.arange(CUPS) / CUPS:
        along = np.array((math.cos(angle), math.sin(angle)))
        across = np.array((-along[1], along[0]))
        middle, end = 0.5 * (HUB + RADIUS) * along, (RADIUS - 0.5 * THICK) * along + 0.5 * (LIP - THICK) * across
        parts.append((pc.Rectangle(RADIUS - HUB + 0.04, THICK), tuple(middle), float(angle)))
        parts.append((pc.Rectangle(THICK, LIP), tuple(end), float(angle)))
    return pc.RigidBody(pc.Compound(parts), (0.0, 0.0), density=500.0, friction=0.0, name="wheel")


def scene() -> pc.Scene:
    """A reservoir with a gate, a chute over the wheel, and a basin below."""
    floor = pc.RigidBody(pc.Rectangle(2.6, 0.1), (-1.42, CHUTE - 0.05), friction=0.0, fixed=True, name="chute")
    gate = pc.RigidBody(pc.Rectangle(0.1, 0.6), (-0.55, CHUTE + GATE + 0.3), friction=0.0, fixed=True, name="gate")
    turning = wheel()
    axle = pc.Hinge(turning, None, (0.0, 0.0))
    water = pc.Fluid.block((-2.7, CHUTE), (-0.6, CHUTE + LEVEL), SPACING, name="water")
    walls = pc.Box((-2.7, -0.85), (1.5, 1.6))
    return pc.Scene(floor, gate, turning, axle, pc.Motor(axle, 0.0, TORQUE), water, walls, pc.Gravity((0.0, -9.81)))


def main(path: str | os.PathLike[str] = "water_wheel.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=25, progress=progress)
    style = [pc.styles.Fluid(surface=True), pc.styles.Solids({"wheel": "#b9854f"}, marks=False)]
    camera = Window((-1.7, -0.9), (1.5, 1.3))
    pc.film(
        recording,
        path,
        size=(640, 512),
        style=style,
        camera=camera,
        quality="high",
        max_bytes=3_000_000,
        title="A water wheel",
        subtitle="A brake takes up its power",
        progress=progress,
    )
    return {"wheel": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The energy of the fall at the end: work of the brake, motion, compression and heat."""
    (energy,) = (recording.energy for recording in recordings.values())
    fall = energy.by_term["gravity"][0] - energy.by_term["gravity"][-1]
    stored = energy.kinetic + energy.internal
    found = stored[-1] - stored[0] + energy.dissipated[-1] - energy.work[-1]
    brake = -energy.work[-1]
    quantity = f"brake ({brake:.0f} J, {brake / DURATION:.0f} W), motion and heat"
    return Figure(quantity, float(found), float(fall), "from the fall", 0.02, "J")
