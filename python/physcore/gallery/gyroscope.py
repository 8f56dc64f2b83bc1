"""A gyroscope is held at one end of its axle: instead of falling it goes around, and nods.

The physics checked: the depth to which it nods is that of a heavy symmetric top.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import cast

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure
from physcore.scene.solids import Capsule

RADIUS, WIDTH, SIDES = 0.3, 0.08, 40
"""Radius and width of the wheel [m], and number of its sides."""
AXLE, THICK = 0.5, 0.02
"""Length of the axle from its held end to the wheel, and its radius [m]."""
SPIN, GRAVITY = 110.0, 9.81
"""Angular velocity of the wheel [rad/s], and acceleration of gravity [m/s²]."""

DURATION = 5.0
"""Simulated time [s]."""


def gyroscope() -> pc.Compound:
    """A wheel with an axle along z, which begins at the held end."""
    angles = 2.0 * math.pi * np.arange(SIDES) / SIDES
    rim = RADIUS * np.column_stack([np.cos(angles), np.sin(angles)])
    faces = [np.column_stack([rim, np.full(SIDES, z)]) for z in (-0.5 * WIDTH, 0.5 * WIDTH)]
    return pc.Compound(
        [(pc.Hull(np.concatenate(faces)), (0.0, 0.0, AXLE)), (Capsule(1.3 * AXLE, THICK), (0.0, 0.0, 0.65 * AXLE))]
    )


def scene() -> pc.Scene:
    """The axle is horizontal, and let go at rest."""
    shape = gyroscope()
    lying = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)
    top = pc.RigidBody(
        shape, (shape.center[2], 0.0, 0.0), orientation=lying, angular_velocity=(SPIN, 0.0, 0.0), name="gyroscope"
    )
    stand = pc.RigidBody(Capsule(0.56, 0.03), (0.0, 0.0, -0.33), fixed=True, name="stand")
    joint = pc.BallJoint(top, stand, (0.0, 0.0, 0.0))
    return pc.Scene(top, stand, joint, pc.Gravity((0.0, 0.0, -GRAVITY)), pc.Floor(-0.64))


def main(path: str | os.PathLike[str] = "gyroscope.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=30, dt=1 / 1920, progress=progress)
    style = pc.styles.Solids({"gyroscope": "#f4743b", "stand": "#8aa0b8"})
    camera = Orbit(-60.0, 22.0, target=(0.0, 0.0, -0.12), extent=1.3)
    pc.film(
        recording,
        path,
        size=(480, 444),
        style=style,
        camera=camera,
        quality="high",
        title="A gyroscope",
        subtitle="Held at one end it does not fall: it goes around, and nods",
        progress=progress,
    )
    return {"gyroscope": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The lowest height of the center of mass below the pivot, over its distance.

    Its sine s is that at which nodding stops: 2 m g d I₁ (1 − s²) = (I₃ ω)² s.

    Source: H. Goldstein, "Classical Mechanics", § 5.7.
    """
    recording = recordings["gyroscope"]
    body = cast(pc.RigidBody, recording.scene.bodies[0])
    arm, mass = float(body.shape.center[2]), float(body.mass[0])
    moments = np.diag(body.shape.moment) * body.density
    lever = 2.0 * mass * GRAVITY * arm * (moments[0] + mass * arm**2)
    turning = (moments[2] * SPIN) ** 2
    expected = (math.hypot(turning, 2.0 * lever) - turning) / (2.0 * lever)
    lowest = -float(recording["gyroscope"].positions[:, 0, 2].min()) / arm
    return Figure("sine of the depression", lowest, expected, "by theory", 1e-2)
