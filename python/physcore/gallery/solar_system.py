"""The inner planets for two years, in a simulation of all eight planets with their real positions, masses and times.

The physics checked: the Earth takes a sidereal year to go around the Sun.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import physcore as pc
from physcore.film import DARK, Orbit
from physcore.gallery.figure import Figure
from physcore.units import AU, day, gravitational_constant, solar_mass, year

DURATION = 2.0 * year
"""Simulated time [s]."""
SIDEREAL_YEAR = 365.25636 * day
"""Sidereal year of the Earth [s]."""

PLANETS = {
    "Mercury": (6023600.0, 0.38709927, 0.20563593, 7.00497902, 252.25032350, 77.45779628, 48.33076593),
    "Venus": (408523.71, 0.72333566, 0.00677672, 3.39467605, 181.97909950, 131.60246718, 76.67984255),
    "Earth and Moon": (328900.56, 1.00000261, 0.01671123, -0.00001531, 100.46457166, 102.93768193, 0.0),
    "Mars": (3098708.0, 1.52371034, 0.09339410, 1.84969142, -4.55343205, -23.94362959, 49.55953891),
    "Jupiter": (1047.3486, 5.20288700, 0.04838624, 1.30439695, 34.39644051, 14.72847983, 100.47390909),
    "Saturn": (3497.898, 9.53667594, 0.05386179, 2.48599187, 49.95424423, 92.59887831, 113.66242448),
    "Uranus": (22902.98, 19.18916464, 0.04725744, 0.77263783, 313.23810451, 170.95427630, 74.01692503),
    "Neptune": (19412.24, 30.06992276, 0.00859048, 1.77004347, -55.12002969, 44.96476227, 131.78422574),
}
"""Orbital elements at J2000 and masses of the planets.

The columns are:

- mass of the Sun over that of the planet;
- semi-major axis [AU];
- eccentricity;
- inclination [degrees];
- mean longitude [degrees];
- longitude of the perihelion [degrees];
- longitude of the ascending node [degrees].

Source: E. M. Standish, "Keplerian elements for approximate positions of the major planets", JPL; masses: IAU 2009.
"""


COLORS = ((255, 206, 84), (170, 160, 150), (240, 214, 160), (92, 160, 240), (226, 96, 58), (210, 160, 120))
"""Colors of the Sun and of the planets in the picture."""


def state(planet: str) -> tuple[float, np.ndarray, np.ndarray]:
    """The mass [kg], the heliocentric position [m] and velocity [m/s] of a planet, in ecliptic coordinates."""
    ratio, axis, eccentricity, *angles = PLANETS[planet]
    inclination, longitude, perihelion, node = np.radians(angles)
    mean, anomaly = longitude - perihelion, longitude - perihelion
    for _ in range(20):  # Newton's method for Kepler's equation
        anomaly -= (anomaly - eccentricity * np.sin(anomaly) - mean) / (1.0 - eccentricity * np.cos(anomaly))
    axis, mass = axis * AU, solar_mass / ratio
    rate = np.sqrt(gravitational_constant * (solar_mass + mass) / axis**3) / (1.0 - eccentricity * np.cos(anomaly))
    minor = np.sqrt(1.0 - eccentricity**2)
    place = axis * np.array([np.cos(anomaly) - eccentricity, minor * np.sin(anomaly)])
    velocity = axis * rate * np.array([-np.sin(anomaly), minor * np.cos(anomaly)])
    turn, tilt = perihelion - node, inclination
    nodal = np.array([np.cos(node), np.sin(node), 0.0])
    across = np.array([-np.sin(node) * np.cos(tilt), np.cos(node) * np.cos(tilt), np.sin(tilt)])
    frame = np.array([np.cos(turn) * nodal + np.sin(turn) * across, np.cos(turn) * across - np.sin(turn) * nodal])
    return mass, place @ frame, velocity @ frame


def scene() -> pc.Scene:
    """The Sun and eight planets, with their center of mass at rest."""
    masses, places, velocities = zip((solar_mass, np.zeros(3), np.zeros(3)), *map(state, PLANETS), strict=True)
    rest = np.average(velocities, axis=0, weights=masses)
    bodies = [
        pc.Particles([place], [velocity - rest], mass=mass, name=name)
        for name, mass, place, velocity in zip(("Sun", *PLANETS), masses, places, velocities, strict=True)
    ]
    return pc.Scene(*bodies, pc.Gravitation())


def main(path: str | os.PathLike[str] = "solar_system.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate two years in steps of half a day, and draw the inner planets from an oblique view."""
    recording = pc.simulate(
        scene(), DURATION, fps=100 / year, integrator=pc.BlanesMoan6(), dt=year / 700, progress=progress
    )
    sun, *planets = recording.scene.bodies
    glow = pc.styles.Points(color="body", size=30.0, glow=1.0, trail=0.0, on=sun)
    balls = pc.styles.Points(color="body", size=13.0, trail=0.6 * year, glow=0.5, on=planets)
    camera = Orbit(-70.0, 45.0, target=(0.0, 0.0, 0.0), extent=2.55 * AU)
    pc.film(
        recording,
        path,
        size=(640, 480),
        style=[glow, balls],
        camera=camera,
        theme=replace(DARK, bodies=COLORS),
        title="The inner planets",
        subtitle="Mercury, Venus, the Earth and Mars from the first of January 2000",
        labels=("time", "energy"),
        name_tags=("Mercury", "Venus", "Earth and Moon", "Mars"),
        scale_bar="AU",
        speed=year / 5.0,
        progress=progress,
    )
    return {"planets": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """The time of one revolution of the Earth about the Sun."""
    sky = recordings["planets"]
    x, y = (sky.positions[:, 3] - sky.positions[:, 0])[:, :2].T
    angle = np.unwrap(np.arctan2(y, x))
    turn = float(np.interp(angle[0] + 2.0 * np.pi, angle, sky.times)) / day
    return Figure("the Earth's sidereal year", turn, SIDEREAL_YEAR / day, "by observation", 2e-4, "days")
