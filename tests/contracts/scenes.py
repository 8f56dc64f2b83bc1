"""The registry of scenes that every contract is tested on: a small one of every kind, with its numerics.

A system, force or method joins all contracts by one entry in `SCENES`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import physcore as pc
from physcore.integrators import INTEGRATORS

STEPS = 60
"""Steps that a contract takes where the number does not matter: several chunks, and some rebuilt neighbor lists."""


@dataclass(frozen=True)
class Case:
    """A scene, the numerics that it is computed with, and the time step [s]."""

    scene: Callable[[], pc.Scene]
    dt: float
    numerics: dict[str, Any] = field(default_factory=dict)

    def simulation(self, **changes: Any) -> pc.Simulation:
        """A simulation of it."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pc.StabilityWarning)
            return pc.Simulation(self.scene(), **{"dt": self.dt, **self.numerics, **changes})


def _random() -> np.random.Generator:
    return np.random.default_rng(20)


def network(dimension: int = 2) -> pc.Scene:
    """A shuffled net of damped springs, one end held, under gravity."""
    rng = _random()
    side = 5
    sites = np.stack(np.meshgrid(*[np.arange(side)] * dimension, indexing="ij"), -1).reshape(-1, dimension)
    positions = sites + rng.uniform(-0.1, 0.1, sites.shape)
    near = np.argwhere(np.triu(np.abs(sites[:, None] - sites).sum(2) == 1))
    body = pc.SpringNetwork(
        positions,
        rng.permutation(near),
        rng.uniform(10.0, 100.0, len(near)),
        0.3,
        mass=rng.uniform(0.5, 2.0, len(sites)),
        velocities=rng.uniform(-0.3, 0.3, sites.shape),
        fixed=[0],
    )
    return pc.Scene(body, pc.Gravity(-np.eye(dimension)[-1]))


def cloth() -> pc.Scene:
    """A sheet whose springs run as a stencil, falling on a ball with friction."""
    sheet = pc.cloth((12, 9), 0.1, 200.0, 0.05, mass=0.01, origin=(-0.55, -0.4, 0.0), pinned="top corners")
    ground = pc.Sphere((0.0, 0.0, -0.43), 0.4, inside=False, restitution=0.2, friction=0.3)
    return pc.Scene(sheet, pc.Gravity((0.0, 0.0, -9.81)), pc.Drag(0.001), ground)


def swarm(*items: pc.Force | pc.Boundary, dimension: int = 3) -> pc.Scene:
    """Independent particles."""
    rng = _random()
    shape = (700, dimension)  # more than one block
    return pc.Scene(pc.Particles(rng.uniform(-1.0, 1.0, shape), rng.uniform(-1.0, 1.0, shape), radius=0.01), *items)


def crowd(*items: pc.Force | pc.Periodic | pc.Boundary, dimension: int = 3) -> pc.Scene:
    """Particles on a jittered lattice, near enough to feel each other."""
    rng = _random()
    side = 6
    sites = pc.block((0.0,) * dimension, (float(side),) * dimension, 1.0)
    positions = sites + rng.uniform(-0.2, 0.2, sites.shape)
    motion = rng.uniform(-1.0, 1.0, sites.shape)
    radius = rng.uniform(0.4, 0.6, len(sites))
    return pc.Scene(pc.Particles(positions, motion, radius=radius, mass=radius**2), *items)


def pool(dimension: int = 2, **options: Any) -> pc.Scene:
    """A block of water that collapses in a box."""
    spacing = 0.1
    upper = (0.8, 1.2) if dimension == 2 else (0.6, 0.6, 0.8)
    water = pc.Fluid(pc.block((0.0,) * dimension, upper, spacing), spacing, **options)
    down = pc.Gravity(-9.81 * np.eye(dimension)[-1])
    return pc.Scene(water, down, pc.Box((0.0,) * dimension, (1.6,) * dimension))


def drops() -> pc.Scene:
    """A drop with surface tension, counted densities and no walls, beside a net that floats on it."""
    drop = pc.Fluid(pc.block((-0.5, -0.5), (0.5, 0.5), 0.1), 0.1, surface_tension=5.0, sound_speed=20.0)
    return pc.Scene(drop)


def harmonic() -> pc.CustomForce:
    """A well written in Python, in operations that are rounded alike everywhere."""
    return pc.CustomForce(lambda time, x, v: -3.0 * x, potential=lambda x: 1.5 * float((x * x).sum()))


ROOM = pc.Box((-1.1,) * 3, (1.1,) * 3, restitution=0.8, friction=0.3)
PERIODIC = pc.Periodic((0.0, 0.0, -np.inf), (6.0, 6.0, np.inf))
GRAINS = pc.SoftSpheres(50.0, 0.2, 0.3, 0.1, exponent=1.5)
DOWN = pc.Gravity((0.0, 0.0, -9.81))
STAR = pc.CentralForce((0.0, 0.0, 0.0), 1.0, softening=0.1)

SCENES: dict[str, Case] = {
    **{
        f"network {kind.__name__}": Case(network, 0.01, {"integrator": kind(), "precision": precision})
        for kind, precision in zip(INTEGRATORS, ["f64", "f32"] * len(INTEGRATORS), strict=False)
    },
    "network 3D": Case(lambda: network(3), 0.01),
    "network adaptive": Case(network, 0.01, {"dt": pc.AdaptiveStep()}),
    "network by error": Case(network, 0.01, {"dt": pc.AdaptiveStep(tolerance=1e-5), "integrator": pc.DormandPrince5()}),
    "cloth": Case(cloth, 0.002),
    "cloth f32": Case(cloth, 0.002, {"precision": "f32"}),
    "swarm folded": Case(lambda: swarm(DOWN, pc.Drag(0.1, wind=(1.0, 0.0, 0.5))), 0.01),
    "swarm folded f32": Case(lambda: swarm(DOWN, pc.Drag(0.1)), 0.01, {"precision": "f32"}),
    "swarm quadratic drag": Case(lambda: swarm(DOWN, pc.Drag(0.0, 0.2)), 0.01, {"integrator": pc.RungeKutta4()}),
    "swarm star": Case(lambda: swarm(STAR), 0.01, {"integrator": pc.RungeKutta4()}),
    "swarm star f32": Case(lambda: swarm(STAR), 0.01, {"precision": "f32"}),
    "swarm power": Case(lambda: swarm(pc.CentralForce((0.0, 0.0), 1.0, -1.7, 0.1), dimension=2), 0.01),
    "swarm in a box": Case(lambda: swarm(DOWN, ROOM), 0.01),
    "swarm in a box RungeKutta4": Case(lambda: swarm(DOWN, ROOM), 0.01, {"integrator": pc.RungeKutta4()}),
    "swarm in Python": Case(lambda: swarm(harmonic()), 0.01),
    "grains": Case(lambda: crowd(GRAINS, DOWN, PERIODIC, pc.Floor(-1.0)), 0.002),
    "grains f32": Case(lambda: crowd(GRAINS, DOWN, PERIODIC, pc.Floor(-1.0)), 0.002, {"precision": "f32"}),
    "atoms": Case(lambda: crowd(pc.LennardJones(1.0, 0.9)), 0.002, {"integrator": pc.PEFRL()}),
    "atoms 2D f32": Case(lambda: crowd(pc.LennardJones(1.0, 0.9), dimension=2), 0.002, {"precision": "f32"}),
    "pool": Case(pool, 1e-3),
    "pool f64 McLachlan2": Case(pool, 1e-3, {"precision": "f64", "integrator": pc.McLachlan2()}),
    "pool 3D": Case(lambda: pool(3), 1e-3),
    "pool shifting": Case(lambda: pool(shifting=1.0), 1e-3),
    "drop": Case(drops, 1e-3),
}
