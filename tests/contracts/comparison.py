"""The plain run of a case, and how far two runs may part that differ by rounding alone."""

from __future__ import annotations

from functools import cache

import numpy as np

import physcore as pc
from contracts import rigid
from contracts.scenes import SCENES, STEPS, Case
from contracts.transforms import Array
from physcore.scene.points import PointSystem

IMPLICIT = (pc.BackwardEuler, pc.ImplicitMidpoint, pc.BDF2)
"""Methods that solve equations to a tolerance."""
RIGID = 1e-10
"""Relative tolerance to which contacts and joints of rigid bodies are solved: `Accuracy::FINE` in the engine."""
SMALL = 1e-7
"""A difference, relative to the size of a number, that grows as any other small one does."""


@cache
def plain(name: str) -> pc.Simulation:
    """The run of a case at its end, computed once for all tests: they read it, and do not change it."""
    return SCENES[name].advance(SCENES[name].simulation())


def state(run: pc.Simulation) -> tuple[Array, Array]:
    """Positions, which are not wrapped to the periodic domain, and velocities, shape (N, D) each, of rigid bodies those
    of points that move with them; without bodies, those of all tracers, the fields of the system, or both parts of a
    wave function.
    """
    if run.scene.has_rigid_bodies:
        return rigid.material(run)
    if run.scene.bodies:
        return run.positions, run.velocities
    if isinstance(run.scene.systems[0], PointSystem):
        parts = [run[system] for system in run.scene.systems]
        return np.concatenate([part.positions for part in parts]), np.concatenate([part.velocities for part in parts])
    (system,) = run.scene.systems
    if isinstance(system, pc.Schrodinger):
        return run[system].wave_function.real, run[system].wave_function.imag
    first, second = run[system].fields.values()
    return first, second


def put(run: pc.Simulation, x: Array, v: Array) -> None:
    """Set a run to a state."""
    if run.scene.has_rigid_bodies:
        rigid.put(run, x, v)
        return
    if run.scene.bodies:
        run.set(x, v)
        return
    if isinstance(run.scene.systems[0], PointSystem):
        starts = np.cumsum([len(system) for system in run.scene.systems])  # type: ignore[arg-type]
        for system, positions in zip(run.scene.systems, np.split(x, starts[:-1]), strict=True):
            run[system].set(positions=positions)
        return
    (system,) = run.scene.systems
    if isinstance(system, pc.Schrodinger):
        run[system].set(wave_function=x + 1j * v)
        return
    run[system].set(**dict(zip(system.shapes(), (x, v), strict=True)))


def difference(scene: pc.Scene, one: tuple[Array, Array], other: tuple[Array, Array]) -> float:
    """The largest difference of two states, each part relative to its size, and to nearest images."""
    apart = one[0] - other[0]
    if scene.periodic is not None:
        apart = scene.periodic.nearest(apart)
    speed = max(np.abs(one[1]).max(), 1e-300)
    return max(float(np.abs(apart).max() / np.abs(one[0]).max()), float(np.abs(one[1] - other[1]).max() / speed))


@cache
def growth(name: str) -> float:
    """By how much a small random difference grows during the run of a registered case, in double precision."""
    return grown(SCENES[name])


def grown(case: Case) -> float:
    """By how much a small random difference grows during the run of a case, in double precision."""
    steady, shaken = (case.simulation(precision="f64") for _ in range(2))
    x, v = state(shaken)
    rng = np.random.default_rng(1)
    bodies = shaken.scene.bodies
    # The center of a rigid body and the tips of its arrows are fixed together.
    fixed = [np.tile(body.fixed, body.dimension if body.is_rigid else 1) for body in bodies]
    free = ~np.concatenate(fixed)[:, None] if bodies else np.bool_(True)
    speed = max(np.abs(v).max(), np.abs(x).max())  # where all is at rest, that of one size per second
    put(
        shaken,
        x + free * SMALL * np.abs(x).max() * rng.uniform(-1.0, 1.0, x.shape),
        v + free * SMALL * speed * rng.uniform(-1.0, 1.0, v.shape),
    )
    case.advance(steady)
    case.advance(shaken)
    return max(1.0, difference(steady.scene, state(steady), state(shaken)) / SMALL)


def tolerance(name: str, run: pc.Simulation, size: float = 1.0) -> float:
    """How far a run of the precision of `run` may part from another, relative to its state.

    Every step rounds each number by an ε of it or a few, with random signs, and what was rounded off grows like any
    small difference. That was measured in one direction: a factor of 10 covers the others. `size` is how many times
    larger the numbers are that are rounded. A tree, whose cells may lie otherwise, errs all along by some of its force,
    which changes velocities by no more than they are. Implicit methods, and contacts and joints of rigid bodies, leave
    that part of the forces unbalanced to which they solve their equations.
    """
    precision = str(run.provenance.numerics["precision"])
    epsilon = float(np.finfo(precision.replace("f", "float")).eps)
    method = SCENES[name].numerics.get("integrator")
    unbalanced = method.tolerance if isinstance(method, IMPLICIT) else RIGID * run.scene.has_rigid_bodies
    return 10.0 * growth(name) * (float(np.sqrt(STEPS)) * epsilon * size + run.plan.force_error + unbalanced)
