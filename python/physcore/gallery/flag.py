"""A flag waves in gusts of wind, which press on its faces.

The physics checked: the energy from wind and gravity becomes motion, strain and heat.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Orbit
from physcore.gallery.figure import Figure, budget

DURATION = 5.0
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """A flag of 1.5 m² and 300 g on its mast, in a wind of changing direction."""
    mast = pc.Capsule((-0.045, 0.0, -0.55), (-0.045, 0.0, 1.06), radius=0.035)
    flag = pc.cloth(
        (25, 17),
        spacing=0.0625,
        stiffness=150.0,
        damping=0.02,
        mass=7e-4,
        origin=(0.0, 0.0, 0.0),
        axes=((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        shear_stiffness=40.0,
        bend_stiffness=4.0,
        pinned="left",
    )
    first, second, third = flag.faces.T

    def wind(time: float, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        """Wind pressure: a relative normal speed u gives ρ u² on a triangle, a third on each corner [N]."""
        angle = 0.5 * math.sin(2.7 * time) + 0.25 * math.sin(7.1 * time)
        air = 6.0 * np.array([math.cos(angle), math.sin(angle), 0.0])
        normals = 0.5 * np.cross(positions[second] - positions[first], positions[third] - positions[first])
        areas = np.linalg.norm(normals, axis=1)
        meets = air - (velocities[first] + velocities[second] + velocities[third]) / 3.0
        speeds = np.einsum("td,td->t", meets, normals) / areas
        push = (1.2 / 3.0 * abs(speeds) * speeds)[:, np.newaxis] * normals
        return np.stack(
            [np.bincount(flag.faces.ravel(), np.repeat(push[:, k], 3), len(positions)) for k in range(3)], 1
        )

    return pc.Scene(
        flag, pc.Gravity((0.0, 0.0, -9.81)), pc.CustomForce(wind), pc.Drag(linear=2e-4, wind=(6.0, 0.0, 0.0)), mast
    )


def stripes() -> np.ndarray:
    """Stripes across the flag, from the upper left to the lower right."""
    down, right = np.indices((320, 480))
    return np.array([(255, 250, 240), (40, 165, 235)], dtype=np.uint8).take((down - right) // 40 % 2, axis=0)


def main(path: str | os.PathLike[str] = "flag.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), duration=DURATION, fps=20, dt=pc.AutoStep(safety=0.3), progress=progress)
    style = pc.styles.Surface(texture=stripes())
    camera = Orbit(azimuth=-70.0, elevation=12.0, target=(0.72, 0.0, 0.42), extent=1.4)
    pc.film(
        recording,
        path,
        size=(528, 400),
        style=style,
        camera=camera,
        labels=(),
        quality="high",
        max_bytes=3_000_000,
        title="A flag in gusts",
        subtitle="The wind presses on its faces",
        progress=progress,
    )
    return {"flag": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Compare the energy from wind and gravity with its final forms."""
    return budget(recordings, bound=0.01)
