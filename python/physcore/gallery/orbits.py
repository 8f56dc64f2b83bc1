"""A race on Kepler's ellipse: explicit Euler spirals out, Verlet and RK4 stay; all with one step size.

The physics checked: the exact orbit keeps the energy −1/2 and the angular momentum 0.8 for ever.
"""

from __future__ import annotations

import math
import os

import physcore as pc
from physcore.film import Window

PERIOD = 2.0 * math.pi
"""Of one orbit [s]."""
DURATION = 4.0 * PERIOD
"""[s]"""


def scene() -> pc.Scene:
    """An orbit of eccentricity 0.6, from perihelion, with G M = a = 1."""
    planet = pc.Particles([[0.4, 0.0]], velocities=[[0.0, 2.0]])
    sun = pc.CentralForce(center=(0.0, 0.0), strength=1.0, exponent=-2.0)
    return pc.Scene(planet, sun)


def main(path: str | os.PathLike[str] = "orbits.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate four orbits with 500 steps each, and draw them; one takes two seconds."""
    integrators = [pc.ExplicitEuler(), pc.VelocityVerlet(), pc.RungeKutta4()]
    recordings = {
        type(integrator).__name__: pc.simulate(
            scene(), DURATION, fps=50 / PERIOD, integrator=integrator, dt=PERIOD / 500, progress=progress
        )
        for integrator in integrators
    }
    pc.film(
        list(recordings.values()),
        path,
        titles=list(recordings),
        size=(960, 360),
        style=pc.styles.Points(size=10.0, trail=2 * PERIOD),
        camera=Window((-2.4, -1.5), (0.8, 1.5)),
        speed=PERIOD / 2.0,
        progress=progress,
    )
    return recordings
