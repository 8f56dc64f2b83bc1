"""Fluids with other integrators than the default: those whose drifts and kicks take turns and go forwards."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import ALL, Array, name, state, unwarned

FORWARD = [pc.SemiImplicitEuler(), pc.VelocityVerlet(), pc.McLachlan2()]
"""Splittings without negative substeps."""
SIDE, SPACING, SOUND = 1.0, 0.1, 10.0


def vortices(integrator: pc.Integrator, dt: object = "auto", **changes: object) -> pc.Simulation:
    """Four vortices in a periodic box, in double precision."""
    cells = pc.block((0.0, 0.0), (SIDE, SIDE), SPACING)
    turn = 2.0 * np.pi * cells
    flow = 0.5 * np.stack(
        [np.sin(turn[:, 0]) * np.cos(turn[:, 1]), -np.cos(turn[:, 0]) * np.sin(turn[:, 1])], axis=1
    )
    water = pc.Fluid(cells, SPACING, velocities=flow, name="water", **{"sound_speed": SOUND, **changes})
    scene = pc.Scene(water, pc.Periodic((0.0, 0.0), (SIDE, SIDE)))
    return pc.Simulation(scene, integrator, dt, **{"precision": "f64", "threads": 1})


def path(integrator: pc.Integrator, dt: float, **changes: object) -> Array:
    """The states at five times of a short flow, and its densities as a fifth number."""
    run = vortices(integrator, dt, **changes)
    states = []
    for _ in range(5):
        run.step(round(0.01 / dt))
        states.append(np.concatenate([state(run).ravel(), 1e-3 * run["water"].densities]))
    return np.array(states)


def order(integrator: pc.Integrator, dt: float, **changes: object) -> float:
    coarse, middle, fine = (path(integrator, dt / halving, **changes) for halving in (1, 2, 4))
    return float(np.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)))


if __name__ == "__main__":
    for integrator in FORWARD:
        for values in ({}, {"density_diffusion": 0.0}, {"density_diffusion": 0.0, "artificial_viscosity": 0.0, "viscosity": 0.0}, {"density_from": "summation"}):
            print(name(integrator), values, [round(order(integrator, dt, **values), 3) for dt in (5e-4, 2.5e-4)], vortices(integrator, **values).plan.order, vortices(integrator, **values).plan.dt_limit)
    quiet = {"density_from": "summation", "artificial_viscosity": 0.0, "viscosity": 0.0}
    for integrator in ALL:
        for kernel in (pc.WendlandC2(), pc.WendlandC4()):
            try:
                print(name(integrator), kernel, [round(order(integrator, dt, kernel=kernel, **quiet), 3) for dt in (1e-3, 5e-4)], vortices(integrator,1e-3, **quiet).plan.order, vortices(integrator,1e-3, **quiet).plan.dt_limit)
            except pc.PhyscoreError as error:
                print(name(integrator), error)
