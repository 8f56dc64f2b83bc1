"""Gravitation by the exact sum over all pairs beside NumPy and Numba, and by a tree beside those of pytreegrav and
REBOUND: `python benches/gravitation.py`.
"""

from __future__ import annotations

from statistics import median
from typing import Any

import numpy as np
from measure import Contender, race, rate, results, speedup
from rivals.gravitation import Cluster, NumpyCluster, numba_cluster
from rivals.jit import FASTMATH, numba_best, with_threads
from rivals.trees import accelerations, pytreegrav, rebound, rebound_accelerations, rebound_run, widest_angle

import physcore as pc
from physcore.numerics.choices import Precision

COUNT = 10_240
STEP = 1e-4
SOFTENING = 0.01
STARS = {"10⁵": 100_000, "10⁶": 1_000_000}
SLOW = 200_000
"""Number of stars from which on REBOUND is left out: a step of 10⁶ takes it a quarter of a minute."""
FORCE_ERROR = 2e-3
"""Rms error of the accelerations over their rms that trees may make."""
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
    compiled = {kind: (numba_cluster(fastmath), 1) for kind, fastmath in FASTMATH.items()}
    for make, _ in [(NumpyCluster, 1), *compiled.values()]:
        agree(make, precision)
    ours = [
        Contender(
            "physcore",
            pc.Simulation(scene, pc.VelocityVerlet(), dt=STEP, precision=precision, threads=threads).step,
            threads,
        )
        for threads in (1, 2)
    ]
    numba = [numba_best(lambda make: rival(scene, make, precision).step, compiled, threads) for threads in (1, 2)]
    numpy = Contender("NumPy, some rows at a time", rival(scene, NumpyCluster, precision).step)
    title = f"Verlet, gravitation of all pairs, {COUNT} stars, {precision}"
    return results(title, "ordered pairs", COUNT**2, race([*ours, *numba, numpy]))


def compare_trees(name: str) -> dict[str, float]:
    """Race whole evaluations of the forces of stars in a cube by trees of the same error; give our seconds for each."""
    count, generator = STARS[name], np.random.default_rng(3)
    # Each with its own softening: pytreegrav has kernels of finite support, without which it is as fast.
    stars = pc.Particles(generator.uniform(size=(count, 3)), 0.5 * generator.normal(size=(count, 3)), mass=1.0 / count)
    scene = pc.Scene(stars, pc.Gravitation(1.0, SOFTENING, "auto", force_error=FORCE_ERROR))
    # Copies, because Numba's classes take no arrays that cannot be written to.
    positions, mass = stars.positions.copy(), np.full(count, 1.0 / count)
    angle = pytreegrav and widest_angle(accelerations, positions, mass, FORCE_ERROR)

    def theirs(steps: int) -> None:
        for _ in range(steps):
            accelerations(positions, mass, angle)

    precisions: tuple[Precision, ...] = ("f32", "f64")
    ours = {
        precision: pc.Simulation(scene, pc.VelocityVerlet(), dt=STEP, precision=precision, threads=2)
        for precision in precisions
    }
    contenders = [Contender(f"physcore, {precision}", run.step, 2) for precision, run in ours.items()]
    contenders.append(Contender("pytreegrav, f64", pytreegrav and with_threads(2, theirs), 2))
    if count < SLOW:
        alone = pc.Simulation(scene, pc.VelocityVerlet(), dt=STEP, threads=1)
        angle_of_rebound = rebound and widest_angle(rebound_accelerations, positions, mass, FORCE_ERROR)
        run = rebound and rebound_run(positions, mass, angle_of_rebound, STEP)
        contenders += [Contender("physcore, f64", alone.step), Contender("REBOUND, f64", run and run.steps)]
    title = f"Gravitation by a tree, {name} stars, rms error {FORCE_ERROR:g}"
    results(title, "stars", count, race(contenders, repetitions=3))
    return {
        f"tree {precision}, {name} stars": median(one.wall) for precision, one in zip(ours, contenders, strict=False)
    }


def main() -> dict[str, float]:
    """Print the tables; give the figures that have targets."""
    figures: dict[str, float] = {}
    for precision in DTYPES:
        contenders = compare(precision)
        figures[f"gravitation {precision}"] = rate(contenders[0], COUNT**2)
        figures[f"two threads, gravitation {precision}"] = speedup(contenders)
    for name in STARS:
        figures |= compare_trees(name)
    return figures


if __name__ == "__main__":
    main()
