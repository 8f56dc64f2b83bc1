"""10⁶ independent particles in 3D beside NumPy and Numba: `python benches/particles.py`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from measure import Contender, race, rate, results, speedup
from rivals.jit import FASTMATH, numba_best
from rivals.particles import NumpyFalling, NumpyOrbit, Swarm, numba_falling, numba_orbit, numba_tallied

import physcore as pc
from physcore.numerics.choices import Precision

COUNT = 1_000_000
STEP = 1e-4
GRAVITY, DRAG = -9.81, 0.1
FUSED = (1, 4, 8)
"""Steps that Numba takes in registers."""
DTYPES: dict[Precision, type[np.floating[Any]]] = {"f64": np.float64, "f32": np.float32}

Maker = Callable[[np.ndarray, np.ndarray, type, float], Swarm]


def falling(count: int) -> pc.Scene:
    """Dust under gravity and linear drag."""
    generator = np.random.default_rng(1)
    dust = pc.Particles(generator.uniform(size=(count, 3)), generator.normal(size=(count, 3)))
    return pc.Scene(dust, pc.Gravity((0.0, 0.0, GRAVITY)), pc.Drag(linear=DRAG))


def orbiting(count: int) -> pc.Scene:
    """A belt around a center, at radii from 1 to 2."""
    generator = np.random.default_rng(2)
    angle, radius = generator.uniform(0.0, 2.0 * np.pi, count), generator.uniform(1.0, 2.0, count)
    out = np.stack([np.cos(angle), np.sin(angle), generator.normal(0.0, 0.1, count)], axis=1)
    along = np.stack([-np.sin(angle), np.cos(angle), np.zeros(count)], axis=1)
    belt = pc.Particles(out * radius[:, None], along / np.sqrt(radius)[:, None])
    return pc.Scene(belt, pc.CentralForce((0.0, 0.0, 0.0), strength=1.0, exponent=-2.0))


def agree(scene: pc.Scene, integrator: pc.Integrator, precision: Precision, make: Maker, steps: int) -> None:
    """Refuse an opponent that does other work: after some steps all are in the same place, to rounding.

    A step rounds x and v a dozen times, by half an ulp each at most. What drag dissipates is a sum over the steps, of
    order 2 in them, by each in its own way.
    """
    body = scene.bodies[0]
    simulation = pc.Simulation(scene, integrator, dt=STEP, precision=precision, threads=1)
    simulation.step(steps)
    rival = make(body.positions, body.velocities, DTYPES[precision], STEP)
    rival.step(steps)
    rounding = 12 * steps * np.finfo(DTYPES[precision]).eps * max(1.0, np.abs(simulation.positions).max())
    np.testing.assert_allclose(rival.positions(), simulation.positions, rtol=0.0, atol=rounding)
    if rival.dissipated is not None:
        np.testing.assert_allclose(rival.dissipated, simulation.energy().dissipated, rtol=DRAG * STEP)


def compare(
    title: str,
    make_scene: Callable[[int], pc.Scene],
    integrator: pc.Integrator,
    precision: Precision,
    numpy_version: Maker,
    numba_versions: dict[str, tuple[Maker, int]],
    equal_versions: dict[str, tuple[Maker, int]],
) -> list[Contender]:
    """Race all versions of one problem in one precision; `equal_versions` keep the budget and check for divergence."""
    small, scene = make_scene(3000), make_scene(COUNT)
    for make, multiple in [(numpy_version, 1), *numba_versions.values(), *equal_versions.values()]:
        agree(small, integrator, precision, make, 5 * multiple)
    body, dtype = scene.bodies[0], DTYPES[precision]

    def rival(make: Maker) -> Callable[[int], object]:
        return make(body.positions, body.velocities, dtype, STEP).step

    ours = [
        Contender(
            "physcore", pc.Simulation(scene, integrator, dt=STEP, precision=precision, threads=threads).step, threads
        )
        for threads in (1, 2)
    ]
    compiled = numba_best(rival, numba_versions)
    winner = {name: one for name, one in numba_versions.items() if compiled.name == f"Numba, {name}"}
    numpy = Contender("NumPy, blocks in the cache", rival(numpy_version))
    equal = [numba_best(rival, equal_versions)] if equal_versions else []
    contenders = [*ours, compiled, numba_best(rival, winner, 2), *equal, numpy]
    return results(f"{title}, {COUNT:.0e} particles, 3D, {precision}", "particle-steps", COUNT, race(contenders))


def readings() -> Iterator[tuple[str, list[Contender]]]:
    """Every race by name: physcore on one thread and on two, then Numba on one and on two."""
    precisions: tuple[Precision, ...] = ("f64", "f32")

    def fall(make: type) -> Maker:
        return lambda *state: make(*state, GRAVITY, DRAG)

    for precision in precisions:
        drops = {
            f"{fused} steps fused, {kind}": (fall(numba_falling(fastmath, fused)), fused)
            for kind, fastmath in FASTMATH.items()
            for fused in FUSED
        }
        tallied = {
            f"with budget and check, {fused} steps fused, {kind}": (fall(numba_tallied(fastmath, fused)), fused)
            for kind, fastmath in FASTMATH.items()
            for fused in FUSED
        }
        yield (
            f"Verlet {precision}",
            compare(
                "Velocity Verlet, gravity and drag",
                falling,
                pc.VelocityVerlet(),
                precision,
                fall(NumpyFalling),
                drops,
                tallied,
            ),
        )
    for precision in precisions:
        orbits: dict[str, tuple[Maker, int]] = {kind: (numba_orbit(fastmath), 1) for kind, fastmath in FASTMATH.items()}
        yield (
            f"RK4 {precision}",
            compare("RK4, inverse-square field", orbiting, pc.RungeKutta4(), precision, NumpyOrbit, orbits, {}),
        )


def figures(races: Mapping[str, Sequence[Contender]]) -> dict[str, float]:
    """The figures that have targets."""
    found: dict[str, float] = {}
    for name, contenders in races.items():
        found[name] = rate(contenders[0], COUNT)
        found[f"two threads, {name}"] = speedup(contenders)
    return found


if __name__ == "__main__":
    dict(readings())
