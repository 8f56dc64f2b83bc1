"""Two almost uniform substances form spots by reaction and diffusion, as Turing predicted.

The physics checked: the distance of the spots is the wavelength of fastest growth, by linear stability analysis.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.gallery.figure import Figure

DURATION = 50.0
"""Simulated time [s]."""
A, B = 0.1, 0.9
DIFFUSION = {"u": 1.0, "v": 20.0}
"""Diffusivities [m²/s]: the activator spreads slowly, the substance that it consumes quickly."""


def scene() -> pc.Scene:
    """The uniform state u = a + b, v = b/(a + b)², with noise."""
    grid = pc.Grid.over((0.0, 0.0), (130.0, 100.0), 0.5, periodic=True)
    noise = 0.05 * np.random.default_rng(5).standard_normal(grid.cells)
    start = {"u": (A + B) * (1.0 + noise), "v": np.full(grid.cells, B / (A + B) ** 2)}
    return pc.Scene(pc.ReactionDiffusion(grid, pc.Schnakenberg(A, B), DIFFUSION, start), units=pc.units.dimensionless)


def main(path: str | os.PathLike[str] = "turing.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw the film."""
    recording = pc.simulate(
        scene(), duration=DURATION, fps=2.0, integrator=pc.RungeKuttaChebyshev(), precision="f32", progress=progress
    )
    style = pc.styles.Field(relief=0.3)
    pc.film(
        recording,
        path,
        size=(520, 496),
        style=style,
        speed=10.0,
        max_bytes=3_000_000,
        title="Turing’s spots",
        subtitle="Reaction and diffusion make a pattern of nothing",
        progress=progress,
    )
    return {"dish": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Wavelength at the onset of the spots, from the mean square of wave numbers, and that of the fastest growth."""
    recording = recordings["dish"]
    (dish,) = recording.scene.grids
    frames = recording[dish]["u"]
    deviations = frames.std(axis=(1, 2))
    u = frames[int(np.argmax((deviations > 0.1) & (recording.times > 5.0)))]
    q = [2.0 * math.pi * np.fft.fftfreq(count, dish.grid.spacing) for count in dish.grid.cells]
    q2 = q[0][:, np.newaxis] ** 2 + q[1] ** 2
    power = np.abs(np.fft.fft2(u - u.mean())) ** 2
    u0, v0, waves = A + B, B / (A + B) ** 2, np.linspace(0.01, 2.0, 2000)
    rates = [
        np.linalg.eigvals(
            [[2 * u0 * v0 - 1 - DIFFUSION["u"] * k * k, u0 * u0], [-2 * u0 * v0, -u0 * u0 - DIFFUSION["v"] * k * k]]
        ).real.max()
        for k in waves
    ]
    fastest = waves[int(np.argmax(rates))]
    measured = math.sqrt(float(np.average(q2, weights=power)))
    return Figure("wavelength", 2 * math.pi / measured, 2 * math.pi / float(fastest), "of fastest growth", 0.1)
