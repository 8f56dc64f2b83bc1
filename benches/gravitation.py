"""Gravitation by the exact sum over all pairs beside NumPy and Numba: `python benches/gravitation.py`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from measure import Contender, fastest, race, rate, speedup, table
from rivals.gravitation import Cluster, NumpyCluster, numba_cluster
from rivals.jit import with_threads

import physcore as pc
from physcore.numerics.choices import Precision

COUNT = 10_240
STEP = 1e-4
SOFTENING = 0.01
DTYPES: dict[Precision, type[np.floating[Any]]] = {"f64": np.float64, "f32": np.float32}


def cluster(count: int) -> pc.Scene:
    """Stars of one mass in a cube, about half as fast as they fall: from rest, their energy would be diagnosed in each
    step until it no longer doubles.
    """
    generator = np.random.default_rng(3)
    positions, velocities = generator.uniform(size=(count, 3)), generator.normal(scale=0.5, size=(count, 3))
    stars = pc.Particles(positions, velocities, mass=1.0 / count)
    return pc.Scene(stars, pc.Gravitation(1.0, SOFTENING))


def rival(scene: pc.Scene, make: type[Cluster], precision: Precision) -> Cluster:
    """An opponent with the same stars."""
    body = scene.bodies[0]
    return make(body.positions, body.velocities, body.mass, DTYPES[precision], STEP, SOFTENING)


def agree(make: type[Cluster], precision: Precision) -> None:
    """Refuse an opponent that does other work: the same velocities to rounding, of a sum of 500 terms in any order."""
    scene = cluster(500)
    simulation = pc.Simulation(scene, pc.VelocityVerlet(), dt=STEP, precision=precision)
    other = rival(scene, make, precision)
    simulation.step(10)
    other.step(10)
    size = np.abs(simulation.velocities).max()
    tolerance = 500 * np.finfo(DTYPES[precision]).eps * size
    np.testing.assert_allclose(np.stack(other.v, axis=1), simulation.velocities, rtol=0.0, atol=tolerance)


def compare(precision: Precision) -> list[Contender]:
    """Race all versions in one precision."""
    scene = cluster(COUNT)
    compiled = {"fastmath" if fastmath else "strict": numba_cluster(fastmath) for fastmath in (False, True)}
    for make in (NumpyCluster, *compiled.values()):
        agree(make, precision)

    def numba(threads: int) -> Contender:
        def step(make: type[Cluster]) -> Callable[[int], object]:
            return with_threads(threads, rival(scene, make, precision).step)

        return fastest([Contender(f"Numba, {name}", step(make), threads) for name, make in compiled.items()])

    ours = [
        Contender(
            "physcore",
            pc.Simulation(scene, pc.VelocityVerlet(), dt=STEP, precision=precision, threads=threads).step,
            threads,
        )
        for threads in (1, 2)
    ]
    numpy = Contender("NumPy, some rows at a time", rival(scene, NumpyCluster, precision).step)
    contenders = [*ours, numba(1), numba(2), numpy]
    race(contenders)
    table(f"Verlet, gravitation of all pairs, {COUNT} stars, {precision}", "ordered pairs", COUNT**2, contenders)
    return contenders


def main() -> dict[str, float]:
    """Print the tables; give the figures that have targets."""
    figures: dict[str, float] = {}
    precisions: tuple[Precision, ...] = ("f64", "f32")
    for precision in precisions:
        contenders = compare(precision)
        figures[f"gravitation {precision}"] = rate(contenders[0], COUNT**2)
        figures[f"two threads, gravitation {precision}"] = speedup(contenders)
    return figures


if __name__ == "__main__":
    main()
