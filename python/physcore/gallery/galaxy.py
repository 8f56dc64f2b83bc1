"""Stars circle a galaxy's core on nearly circular orbits; where these crowd they form spiral arms, which wind up.

The physics checked: the angle between successive apocenters of a star is that of the epicyclic theory.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Keyframes, Orbit
from physcore.gallery.figure import Figure

STARS = 5000
CORE = 0.3
"""Core radius b, for G M = 1 m³/s² [m]."""
RADII = (0.1, 2.0)
"""Radii of the innermost and the outermost orbit [m]."""
WARM, BLUE = np.array([255.0, 196.0, 130.0]), np.array([130.0, 176.0, 255.0])
"""Colors of the light of old stars near the core, and of young ones in the arms."""

DURATION = 8.0
"""Simulated time [s]."""


def rates(radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The angular and the epicyclic frequency of a circular orbit, Ω² = (r² + b²)^(-3/2) and κ² = 4Ω² + r dΩ²/dr [1/s].

    Source: J. Binney, S. Tremaine, "Galactic Dynamics", 2nd ed., section 3.2.3.
    """
    angular = (radius**2 + CORE**2) ** -0.75
    return angular, angular * np.sqrt(4.0 - 3.0 * radius**2 / (radius**2 + CORE**2))


def scene() -> pc.Scene:
    """Stars with radial oscillations of a tenth of their radius, in phase along a spiral."""
    generator = np.random.default_rng(4)
    radius, angle = generator.uniform(*RADII, STARS), generator.uniform(0.0, 2.0 * np.pi, STARS)
    phase = 2.0 * angle + 7.0 * np.log(radius)
    angular, radial = rates(radius)
    away = radius * (1.0 - 0.1 * np.cos(phase))
    outward, height = np.stack([np.cos(angle), np.sin(angle)], axis=1), generator.normal(scale=0.02, size=STARS)
    forward = outward[:, ::-1] * np.array([-1.0, 1.0])
    speeds = (0.1 * radius * radial * np.sin(phase))[:, np.newaxis], (angular * radius**2 / away)[:, np.newaxis]
    places = np.column_stack([away[:, np.newaxis] * outward, height])
    velocities = np.column_stack([speeds[0] * outward + speeds[1] * forward, np.zeros(STARS)])
    core = pc.CentralForce((0.0, 0.0, 0.0), strength=1.0, exponent=-2.0, softening=CORE)
    return pc.Scene(pc.Particles(places, velocities), core)


def main(path: str | os.PathLike[str] = "galaxy.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw it with a rising camera."""
    recording = pc.simulate(scene(), duration=DURATION, fps=6, progress=progress)
    radius = np.linalg.norm(recording.positions[0, :, :2], axis=1)[:, np.newaxis]
    far = np.clip((radius - RADII[0]) / (RADII[1] - RADII[0]), 0.0, 1.0)
    colors = np.rint((1.0 - far) * WARM + far * BLUE).astype(int)
    style = pc.styles.Density(color=colors, spread=1.2)
    camera = Keyframes({0.0: Orbit(-60.0, 30.0), DURATION: Orbit(-90.0, 60.0)})
    pc.film(
        recording,
        path,
        size=(600, 480),
        style=style,
        camera=camera,
        title="Spiral arms",
        subtitle="Where the orbits of stars crowd; they wind up",
        labels=(),
        speed=2.0,
        max_bytes=3_000_000,
        progress=progress,
    )
    return {"stars": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Mean angle between the first two apocenters of stars in the inner half; 2π Ω/κ by the epicyclic theory.

    The mean over stars differs from the theory by the order of the squared amplitude, one percent.
    """
    recording = recordings["stars"]
    x, y = np.moveaxis(recording.positions[..., :2], 2, 0)
    u, v = np.moveaxis(recording.velocities[..., :2], 2, 0)
    outward, angle = x * u + y * v, np.unwrap(np.arctan2(y, x), axis=0)
    found, expected = [], []
    for star in range(0, STARS, 8):
        turns = np.flatnonzero((outward[:-1, star] > 0.0) & (outward[1:, star] <= 0.0))[:2]
        radius = np.hypot(x[:, star], y[:, star])
        middle = np.array((radius.max() + radius.min()) / 2.0)
        if len(turns) < 2 or middle > np.mean(RADII):
            continue
        share = outward[turns, star] / (outward[turns, star] - outward[turns + 1, star])
        found.append(np.diff(angle[turns, star] + share * (angle[turns + 1, star] - angle[turns, star]))[0])
        angular, radial = rates(middle)
        expected.append(2.0 * np.pi * angular / radial)
    turn = np.degrees([np.mean(found), np.mean(expected)]).tolist()
    return Figure("mean angle from far to far of the inner stars", turn[0], turn[1], "by theory", 0.02, "degrees")
