"""Short measurement of this machine's speed; `make bench` in a checkout compares it with NumPy and Numba."""

from __future__ import annotations

import time

import numpy as np

from physcore.forces import Drag, Gravity
from physcore.numerics.choices import Precision
from physcore.numerics.integrators import VelocityVerlet
from physcore.scene.bodies import Particles
from physcore.scene.builders import cloth
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation

PRECISIONS: tuple[Precision, ...] = ("f64", "f32")
REPETITIONS = 5
SECONDS = 0.3
"""Approximate duration of one repetition [s]."""


def main() -> None:
    """Measure two scenes in both precisions, with the audit and the divergence check enabled, and print the medians."""
    dust = Particles(np.random.default_rng(1).uniform(size=(1_000_000, 3)))
    falling = Scene(dust, Gravity((0.0, 0.0, -9.81)), Drag(linear=0.1))
    fabric = cloth((316, 316), spacing=0.01, stiffness=100.0, damping=0.01, mass=1e-3, pinned="top")
    hanging = Scene(fabric, Gravity((0.0, -9.81)))
    cases = {
        "10⁶ particles, gravity and drag, 3D": (falling, len(dust), "particle-steps"),
        "316×316 cloth, damped": (hanging, len(fabric.pairs), "spring-updates"),
    }
    for name, (scene, work, unit) in cases.items():
        for precision in PRECISIONS:
            simulation = Simulation(scene, VelocityVerlet(), dt=1e-4, precision=precision)
            rate = work / _seconds_per_step(simulation)
            print(
                f"{name:<36} {precision}  {simulation.plan.threads} threads  {rate / 1e9:7.3f} G {unit}/s", flush=True
            )


def _seconds_per_step(simulation: Simulation) -> float:
    """The median over several repetitions, after a warm-up that determines the number of steps per repetition."""
    steps, taken = 1, 0.0
    while taken < SECONDS / 4:
        steps *= 2
        taken = _time(simulation, steps)
    steps = max(1, round(steps * SECONDS / taken))
    return float(np.median([_time(simulation, steps) / steps for _ in range(REPETITIONS)]))


def _time(simulation: Simulation, steps: int) -> float:
    start = time.perf_counter()
    simulation.step(steps)
    return time.perf_counter() - start
