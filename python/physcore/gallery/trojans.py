"""Asteroids stay about 60° ahead of and behind Jupiter, in the frame that rotates with the Sun and Jupiter.

The physics checked: the period of a small oscillation about the Lagrange point L4 in the restricted problem.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import physcore as pc
from physcore.film import DARK, Corotating, Window
from physcore.gallery.figure import Figure
from physcore.units import AU, gravitational_constant, jupiter_mass, solar_mass, year

DURATION = 170.0 * year
"""Simulated time [s]."""
DISTANCE = 5.2044 * AU
"""Distance of Jupiter from the Sun, on a circular orbit [m]."""
SHARE = jupiter_mass / (solar_mass + jupiter_mass)
"""Mass ratio μ: mass of Jupiter over that of both bodies."""
RATE = float(np.sqrt(gravitational_constant * (solar_mass + jupiter_mass) / DISTANCE**3))
"""Angular velocity of the pair [rad/s]."""
AHEAD = np.array([57.0, 50.0, 44.0, 38.0, 33.0, 29.0])
"""Initial angles of the asteroids ahead of Jupiter, or behind it [degrees]."""
COLORS = ((255, 206, 84), (226, 150, 96), (92, 200, 180), (120, 150, 250), (240, 110, 140))


def turning(places: np.ndarray) -> np.ndarray:
    """Velocities [m/s] of points at rest in the corotating frame."""
    return RATE * np.column_stack([-places[:, 1], places[:, 0]])


def turned_back(pair: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions [m] and velocities [m/s] of asteroids where their slow oscillation turns, without epicycles.

    Let x be the radial and y the tangential displacement in the corotating frame, and F the acceleration there at rest:
    x″ − 2n y′ − 3n² x = Fx, y″ + 2n x′ = Fy. Where a slow solution turns, y′ = 0: x = −Fx/3n², and x′ = 2Fy/n.
    """
    outward = np.column_stack([np.cos(angles), np.sin(angles)])
    forward = np.column_stack([-np.sin(angles), np.cos(angles)])
    places = pair[0] + DISTANCE * outward
    force = RATE * RATE * places
    for center, mass in zip(pair, (solar_mass, jupiter_mass), strict=True):
        way = center - places
        force += gravitational_constant * mass * way / np.linalg.norm(way, axis=1, keepdims=True) ** 3
    radial, tangential = ((force * way).sum(axis=1, keepdims=True) for way in (outward, forward))
    places = places - radial / (3.0 * RATE * RATE) * outward
    return places, turning(places) + 2.0 * tangential / RATE * outward


def scene() -> pc.Scene:
    """The Sun and Jupiter about their center of mass, and massless asteroids."""
    pair = DISTANCE * np.array([[-SHARE, 0.0], [1.0 - SHARE, 0.0]])
    sun = pc.Particles(pair[:1], turning(pair[:1]), mass=solar_mass, name="Sun")
    jupiter = pc.Particles(pair[1:], turning(pair[1:]), mass=jupiter_mass, name="Jupiter")
    swarms = []
    for name, angles in (("Greeks", AHEAD), ("Trojans", -AHEAD), ("horseshoe", np.array([19.0]))):
        swarms.append(pc.Particles(*turned_back(pair, np.radians(angles)), name=name))
    return pc.Scene(sun, jupiter, *swarms, pc.Gravitation(sources=[sun, jupiter]))


def main(path: str | os.PathLike[str] = "trojans.gif", progress: bool | None = None) -> dict[str, pc.Recording]:
    """Simulate more than one oscillation, and draw it in the corotating frame."""
    recording = pc.simulate(
        scene(), DURATION, fps=1.5 / year, integrator=pc.BlanesMoan6(), dt=year / 3.0, progress=progress
    )
    sun, jupiter, *swarms = recording.scene.bodies
    style = [
        pc.styles.Paths(on=swarms, width=1.6),
        pc.styles.Points(color="body", size=30.0, glow=1.0, trail=0.0, on=sun),
        pc.styles.Points(color="body", size=16.0, glow=0.3, trail=0.0, on=jupiter),
        pc.styles.Points(color="body", size=5.0, glow=0.6, trail=0.0, on=swarms),
    ]
    around = Window((-6.4 * AU, -5.9 * AU), (6.4 * AU, 5.9 * AU))
    pc.film(
        recording,
        path,
        size=(640, 672),
        style=style,
        camera=Corotating(sun, jupiter, around),
        theme=replace(DARK, bodies=COLORS),
        labels=("energy",),
        speed=17.0 * year,
        title="Trojan asteroids",
        subtitle="60° ahead of and behind Jupiter, in its rotating frame",
        progress=progress,
    )
    return {"asteroids": recording}


def figure(recordings: Mapping[str, pc.Recording]) -> Figure:
    """Period of the smallest oscillation about L4: twice the time between two passages through its middle.

    Source: V. Szebehely, Theory of Orbits (1967), section 5.3: the slow root of λ⁴ + λ² + 27/4 μ(1 − μ) = 0.
    """
    sky = recordings["asteroids"]
    sun, jupiter, asteroid = (sky[name].positions[:, 0] for name in ("Sun", "Jupiter", "Greeks"))
    x, y = asteroid - sun, jupiter - sun
    angle = np.arctan2(y[:, 0] * x[:, 1] - y[:, 1] * x[:, 0], (x * y).sum(axis=1))
    turn = round(2.0 * np.pi / RATE * sky.fps)  # a mean over this removes the short oscillation
    slow = np.convolve(angle, np.ones(turn) / turn, mode="valid")
    slow -= 0.5 * (slow.min() + slow.max())
    before = np.flatnonzero(slow[:-1] * slow[1:] < 0.0)[:2]
    first, second = before + slow[before] / (slow[before] - slow[before + 1])
    root = np.sqrt(0.5 * (1.0 - np.sqrt(1.0 - 27.0 * SHARE * (1.0 - SHARE))))
    period = 2.0 * float(second - first) / sky.fps
    return Figure("oscillation about L4", period / year, 2.0 * np.pi / (RATE * root) / year, "by theory", 0.02, "years")
