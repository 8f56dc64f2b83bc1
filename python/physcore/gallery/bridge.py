"""A car crosses a bridge of planks, which breaks under the lorry that follows.

The physics checked: before they come, the hinges at the banks bear the tension of a hanging chain.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure
from physcore.scene.items import Constraint

PLANKS, LENGTH, THICKNESS, DENSITY = 16, 0.5, 0.1, 500.0
"""Number of planks, their length and thickness [m], and their density [kg/m³]."""
SPAN, DEPTH = 7.9, 3.0
"""Width and depth of the gorge [m]."""
STRENGTH, WEAK = 1e5, (6, 3e4)
"""Force at which a hinge breaks [N]; a hinge that breaks at a smaller force, and this force [N]."""
SPEED, TORQUE = 2.0, 150.0
"""Speed of the vehicles [m/s], and largest torque of the motor of a wheel [N·m]."""
GRAVITY = 9.81
"""Acceleration of gravity [m/s²]."""
PLANK = DENSITY * LENGTH * THICKNESS * GRAVITY
"""Weight of a plank [N]."""

DURATION = 7.5
"""Simulated time [s]."""


def tension() -> float:
    """The horizontal component of the tension of a chain of planks across the gorge [N], by bisection.

    The weight of the planks between a plank and the lowest one is carried by its ends: tan θ = k w/H.
    """
    low, high = 1e-3 * PLANK, 1e6 * PLANK
    for _ in range(200):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if LENGTH * np.cos(angles(middle)).sum() < SPAN else (low, middle)
    return middle


def angles(pull: float) -> np.ndarray:
    """The angles of the planks under a horizontal tension [rad]."""
    turns: np.ndarray = np.arctan(PLANK * (np.arange(PLANKS) - 0.5 * (PLANKS - 1)) / pull)
    return turns


def vehicle(name: str, x: float, size: float, density: float) -> list[pc.Body | Constraint]:
    """A car that begins at `x` on the bank: a body on two driven wheels."""
    wheel, base = 0.22 * size, 0.75 * size
    outline = size * np.array(
        [(-0.7, 0.0), (0.7, 0.0), (0.7, 0.25), (0.35, 0.3), (0.15, 0.6), (-0.6, 0.6), (-0.7, 0.3)]
    )
    shape = pc.Polygon(outline)
    place = shape.center + np.array([x, 1.3 * wheel])
    body = pc.RigidBody(shape, place, density=density, velocity=(SPEED, 0.0), name=name)
    parts: list[pc.Body | Constraint] = [body]
    for side in (-1.0, 1.0):
        axis = (x + 0.5 * side * base, wheel)
        disc = pc.RigidBody(
            pc.Disc(wheel),
            axis,
            density=density,
            friction=0.9,
            velocity=(SPEED, 0.0),
            angular_velocity=-SPEED / wheel,
            name=f"{name} wheel {side:+.0f}",
        )
        axle = pc.Hinge(disc, body, axis)
        parts += [disc, axle, pc.Motor(axle, -SPEED / wheel, TORQUE)]
    return parts


def scene() -> pc.Scene:
    """A bridge that hangs at rest between two banks, and a car and a lorry on the left bank."""
    turns = angles(tension())
    nodes = np.concatenate([[[0.0, 0.0]], np.cumsum(LENGTH * np.column_stack([np.cos(turns), np.sin(turns)]), axis=0)])
    nodes -= (0.5 * SPAN, 0.5 * THICKNESS)
    planks = pc.RigidBodies(
        pc.Rectangle(0.98 * LENGTH, THICKNESS),
        0.5 * (nodes[1:] + nodes[:-1]),
        angles=turns,
        mass=PLANK / GRAVITY,
        friction=0.8,
        name="planks",
    )
    bank = pc.Rectangle(16.0, DEPTH)
    places = [(side * (0.5 * SPAN + 8.0), -0.5 * DEPTH) for side in (-1.0, 1.0)]
    banks = pc.RigidBodies(bank, places, fixed=[0, 1], friction=0.8, name="banks")
    ends = [(banks, 0), *((planks, k) for k in range(PLANKS)), (banks, 1)]
    hinges = [
        pc.Hinge(one, other, node, breaking_force=WEAK[1] if index == WEAK[0] else STRENGTH)
        for index, (one, other, node) in enumerate(zip(ends[:-1], ends[1:], nodes, strict=True))
    ]
    car = vehicle("car", -0.5 * SPAN - 1.0, 0.8, 150.0)
    lorry = vehicle("lorry", -0.5 * SPAN - 7.5, 1.4, 200.0)
    floor = pc.Floor(-DEPTH, restitution=0.1, friction=0.6)
    return pc.Scene(planks, banks, *hinges, *car, *lorry, floor, pc.Gravity((0.0, -GRAVITY)))


def main(path: str | os.PathLike[str] = "bridge.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=30, dt=1 / 2000, progress=progress)
    camera = Window((-6.4, -3.3), (6.4, 2.3))
    wheels = [f"{name} wheel {side}" for name in ("car", "lorry") for side in ("-1", "+1")]
    style = [
        pc.styles.Solids("#c8955a", on="planks", marks=False),
        pc.styles.Solids("#3fb98f", on="car", marks=False),
        pc.styles.Solids("#e0603a", on="lorry", marks=False),
        pc.styles.Solids("#9fb0c4", on=wheels),
        pc.styles.Solids(on="banks", marks=False, joints=False),
    ]
    pc.film(
        recording,
        path,
        size=(640, 350),
        style=style,
        camera=camera,
        quality="high",
        title="A bridge of planks",
        subtitle="It carries the car, but not the lorry",
        progress=progress,
    )
    return {"bridge": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The force of the hinge at the right bank after a tenth of a second, with that of a chain at rest.

    Its vertical component is half of the weight.
    """
    recording = recordings["bridge"]
    last = [joint for joint in recording.scene.constraints if joint.element == "joints"][PLANKS]
    force = float(np.hypot(*recording[last].force[3]))
    return Figure("force of a hinge", force, math.hypot(tension(), 0.5 * PLANKS * PLANK), "by statics", 1e-2, "N")
