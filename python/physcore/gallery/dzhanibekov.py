"""A T that spins about its handle turns over again and again, though nothing acts on it (the Dzhanibekov effect).

The physics checked: it turns over after half a period of Jacobi's elliptic functions.
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
from physcore.gallery.means import arithmetic_geometric
from physcore.scene.solids import Capsule

BAR, HANDLE, THICK = 0.5, 0.26, 0.04
"""Lengths of the bar and the handle, and their radius [m]."""
SPIN = (0.03, 8.0, 0.02)
"""Initial angular velocity, nearly about the handle [rad/s]."""
LYING = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0), (math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0)
"""Orientations that turn the axis z into x and into y."""

DURATION = 12.0
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """A bar along x with a handle along y, without gravity."""
    middle = 0.5 * HANDLE + THICK
    bars = Capsule(BAR, THICK), Capsule(HANDLE, THICK)
    shape = pc.Compound(bars, [(0.0, 0.0, 0.0), (0.0, middle, 0.0)], orientations=LYING)
    return pc.Scene(pc.RigidBody(shape, (0.0, 0.0, 0.0), angular_velocity=SPIN, name="T"))


def main(path: str | os.PathLike[str] = "dzhanibekov.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(scene(), DURATION, fps=30, dt=1 / 960, progress=progress)
    style, camera = pc.styles.Solids("#ffd166"), Orbit(22.0, 20.0)
    pc.film(
        recording,
        path,
        size=(480, 404),
        style=style,
        camera=camera,
        quality="high",
        max_bytes=3_000_000,
        title="The Dzhanibekov effect",
        subtitle="A spinning T turns over again and again",
        progress=progress,
    )
    return {"T": recording}


def flips(spin: np.ndarray, moments: np.ndarray) -> float:
    """The time between two flips: 2 K(k)/n, where the angular velocity about the middle axis is a multiple of sn(n t).

    Source: L. D. Landau, E. M. Lifshitz, "Mechanics", § 37.
    """
    least, middle, most = moments
    energy, turning = (moments * spin**2).sum(), ((moments * spin) ** 2).sum()  # 2 E and L²
    if turning < energy * middle:
        least, most = most, least
    rate = (most - middle) * (turning - energy * least)
    modulus = (middle - least) * (energy * most - turning) / rate
    mean = arithmetic_geometric(1.0, math.sqrt(1.0 - modulus))
    return float(math.pi / mean / math.sqrt(rate / (least * middle * most)))


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The mean time between flips, at which the handle is perpendicular to the angular momentum."""
    recording = recordings["T"]
    w, x, y, z = recording["T"].orientations[:, 0].T
    handle = np.column_stack([2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)])
    along = handle @ recording.angular_momentum[0]
    before = np.flatnonzero(along[:-1] * along[1:] < 0.0)
    times = (before + along[before] / (along[before] - along[before + 1])) / recording.fps
    body = cast(pc.RigidBody, recording.scene.bodies[0])
    expected = flips(np.array(SPIN), np.diag(body.shape.moment))
    return Figure("time between flips", float(np.diff(times).mean()), expected, "by theory", 1e-4, "s")
