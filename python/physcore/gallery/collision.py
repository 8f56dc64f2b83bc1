"""Two galaxies pass each other, and tides draw long tails out of their discs (Toomre and Toomre 1972).

The physics checked: energy and angular momentum determine the least distance of the cores.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Keyframes, Orbit
from physcore.gallery.figure import Figure

STARS = 5000
"""Number of stars of each galaxy."""
CORE = 0.15
"""Softening length of the cores, whose masses are 1 with G = 1 [m]."""
RADII = (0.15, 1.0)
"""Radii of the innermost and the outermost orbit [m]."""
PERIAPSIS, APART = 1.0, 3.5
"""Periapsis of a parabolic orbit of point masses, and initial distance of the cores [m]."""

DURATION = 7.0
"""Simulated time [s]."""


def disc(generator: np.random.Generator, tilt: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of stars on circular orbits about a core, in a plane tilted about the x axis [rad]."""
    inner, outer = RADII
    radius = np.sqrt(generator.uniform(inner**2, outer**2, STARS))
    angle = generator.uniform(0.0, 2.0 * np.pi, STARS)
    speed = radius * (radius**2 + CORE**2) ** -0.75
    outward = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    forward = np.stack([-np.sin(angle), np.cos(angle), 0.0 * angle], axis=1)
    turned = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(tilt), -np.sin(tilt)], [0.0, np.sin(tilt), np.cos(tilt)]])
    return radius[:, np.newaxis] * outward @ turned.T, speed[:, np.newaxis] * forward @ turned.T


def scene() -> pc.Scene:
    """Two equal galaxies on a parabolic orbit, one in the orbital plane and one tilted. Stars feel only the cores."""
    generator = np.random.default_rng(6)
    # True anomaly on the parabola of the relative orbit at this distance, before the periapsis.
    anomaly = -math.acos(2.0 * PERIAPSIS / APART - 1.0)
    momentum = math.sqrt(2.0 * 2.0 * PERIAPSIS)
    place = APART * np.array([math.cos(anomaly), math.sin(anomaly), 0.0])
    velocity = 2.0 / momentum * np.array([-math.sin(anomaly), 1.0 + math.cos(anomaly), 0.0])
    cores = pc.Particles(0.5 * np.stack([place, -place]), 0.5 * np.stack([velocity, -velocity]), mass=1.0, name="cores")
    galaxies = []
    for center, motion, tilt, name in zip(
        cores.positions, cores.velocities, (0.0, math.radians(50.0)), ("flat", "tilted"), strict=True
    ):
        places, velocities = disc(generator, tilt)
        galaxies.append(pc.Particles(center + places, motion + velocities, mass=1e-6, name=name))
    return pc.Scene(*galaxies, cores, pc.Gravitation(1.0, CORE, sources=cores))


def main(path: str | os.PathLike[str] = "collision.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate the scene and draw it from an oblique view, with each star in the color of its galaxy."""
    recording = pc.simulate(scene(), DURATION, fps=8, dt=0.0125, precision="f32", progress=progress)
    flat, tilted, cores = recording.scene.bodies
    style = [
        pc.styles.Density(color={flat: "#8fb6ff", tilted: "#ffb070"}, spread=1.1, exposure=0.8, on=[flat, tilted]),
        pc.styles.Points("#fff2dc", size=5.0, glow=1.0, trail=0.0, shading=False, on=cores),
    ]
    middle = (0.0, 0.0, 0.0)
    camera = Keyframes(
        {
            0.0: Orbit(10.0, 60.0, target=middle, extent=4.4),
            DURATION: Orbit(45.0, 50.0, target=middle, extent=11.5),
        }
    )
    pc.film(
        recording,
        path,
        size=(600, 480),
        style=style,
        camera=camera,
        title="Two galaxies pass each other",
        subtitle="Tides draw long tails out of their discs",
        labels=(),
        speed=1.5,
        max_bytes=3_000_000,
        progress=progress,
    )
    return {"galaxies": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The least distance r of the cores, where L²/(2μr²) − G m²/√(r² + ε²), μ = m/2, is equal to their energy."""
    galaxies = recordings["galaxies"]
    apart = galaxies.positions[:, -2] - galaxies.positions[:, -1]
    speed = galaxies.velocities[0, -2] - galaxies.velocities[0, -1]

    def potential(radius: float) -> float:
        return -1.0 / math.sqrt(radius**2 + CORE**2)

    energy = 0.25 * float(speed @ speed) + potential(float(np.linalg.norm(apart[0])))
    momentum = 0.5 * float(np.linalg.norm(np.cross(apart[0], speed)))
    low, high = 0.0, APART
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if momentum**2 / middle**2 + potential(middle) > energy else (low, middle)
    distances = np.linalg.norm(apart, axis=1)
    # Minimum of a parabola through the three frames around the least distance.
    nearest = int(distances.argmin())
    before, least, after = distances[nearest - 1 : nearest + 2] ** 2
    measured = math.sqrt(least - (before - after) ** 2 / (8.0 * (before - 2.0 * least + after)))
    return Figure("least distance of the cores", measured, high, "by energy and angular momentum", 2e-3, "m")
