"""Kepler's ellipse by three methods with one step size: explicit Euler spirals out, Verlet and RK4 stay on it.

The physics checked: the exact orbit has the constant energy −1/2 and angular momentum 0.8.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

import numpy as np

import physcore as pc
from physcore.film import Window
from physcore.gallery.figure import Figure

PERIOD = 2.0 * math.pi
"""Period of one orbit [s]."""
DURATION = 4.0 * PERIOD
"""Simulated time [s]."""


def scene() -> pc.Scene:
    """An orbit of eccentricity 0.6, from perihelion, with G M = a = 1."""
    planet = pc.Particles([[0.4, 0.0]], velocities=[[0.0, 2.0]])
    sun = pc.CentralForce(center=(0.0, 0.0), strength=1.0, exponent=-2.0)
    return pc.Scene(planet, sun)


def main(path: str | os.PathLike[str] = "orbits.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate four orbits with 2000 steps each, and draw them; one orbit takes two seconds."""
    integrators = [pc.ExplicitEuler(), pc.VelocityVerlet(), pc.RungeKutta4()]
    recordings = {
        type(integrator).__name__: pc.simulate(
            scene(), DURATION, fps=100 / PERIOD, integrator=integrator, dt=PERIOD / 2000, progress=progress
        )
        for integrator in integrators
    }
    pc.film(
        list(recordings.values()),
        path,
        titles=list(recordings),
        size=(720, 400),
        style=pc.styles.Points(size=12.0, trail=PERIOD, glow=0.8),
        camera=Window((-2.45, -1.05), (0.85, 1.05)),
        labels=("time", "energy"),
        speed=PERIOD / 2.0,
        title="One orbit, one step size, three methods",
        subtitle="Explicit Euler spirals outward; the others stay on the ellipse",
        progress=progress,
    )
    return recordings


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The period by RK4, from the first to the last aphelion."""
    orbit = recordings["RungeKutta4"]
    outward = np.einsum("fd,fd->f", orbit.positions[:, 0], orbit.velocities[:, 0])
    after = np.flatnonzero((outward[:-1] > 0.0) & (outward[1:] <= 0.0))
    share = outward[after] / (outward[after] - outward[after + 1])
    farthest = orbit.times[after] + share / orbit.fps
    period = float(farthest[-1] - farthest[0]) / (len(after) - 1)
    return Figure("period by RungeKutta4", period, PERIOD, "by Kepler's third law", 1e-5, "s")
