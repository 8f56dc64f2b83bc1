"""A million tracers start close together and unfold to the Lorenz attractor: chaos separates them.

The physics checked: the mean of z over all tracers changes by the mean of x y, minus β times the mean of z.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Keyframes, Orbit
from physcore.gallery.figure import Figure

TRACERS = 1_000_000
MEASURED = 4000
"""Number of recorded tracers."""
DURATION = 9.0
"""Simulated time [s]."""
BETA = 8.0 / 3.0
FPS = 13
"""Frames per second of simulated time."""


def scene(tracers: int = TRACERS) -> pc.Scene:
    """A small ball of tracers in the middle."""
    places = np.array([0.0, 0.0, 25.0]) + 0.8 * np.random.default_rng(1).normal(size=(tracers, 3))
    return pc.Scene(pc.Tracers(places, pc.Lorenz(beta=BETA), name="tracers"), units=pc.units.dimensionless)


def main(
    path: str | os.PathLike[str] = "butterfly.gif", progress: bool | None = None, tracers: int = TRACERS
) -> dict[str, pc.Recording]:
    """Simulate the tracers while they are drawn, with a rotating camera, and record the first ones."""
    first, last = (Orbit(*angles, target=(0.0, 0.0, 24.5), extent=50.0) for angles in ((-90.0, 4.0), (-58.0, 8.0)))
    pc.film(
        scene(tracers),
        path,
        duration=DURATION,
        fps=FPS,
        size=(464, 396),
        camera=Keyframes({0.0: first, DURATION: last}),
        style=pc.styles.Density(exposure=0.7),
        speed=0.9,
        dt=1.0 / (16 * FPS),
        precision="f32",
        max_bytes=3_000_000,
        title="Lorenz’s butterfly",
        subtitle="A million tracers start together; chaos separates them",
        progress=progress,
    )
    recording = pc.simulate(scene(MEASURED), DURATION, fps=FPS, dt=1.0 / (16 * FPS), progress=progress)
    return {"the first of them": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Measure β from means over the recorded tracers: (∫⟨x y⟩ dt − Δ⟨z⟩) / ∫⟨z⟩ dt, by the trapezoidal rule over
    frames.
    """
    (recording,) = recordings.values()
    x, y, z = np.moveaxis(recording["tracers"].positions, -1, 0)
    source, height = (np.trapezoid(mean, recording.times) for mean in ((x * y).mean(axis=1), z.mean(axis=1)))
    found = (source - z[-1].mean() + z[0].mean()) / height
    return Figure("β", float(found), BETA, "in the flow", 0.005)
