"""Tracers in Lorenz' flow beside NumPy and Numba: `python benches/tracers.py`."""

from __future__ import annotations

from typing import Any

import numpy as np
from measure import Contender, race, rate, results, speedup
from rivals.jit import FASTMATH, numba_best
from rivals.tracers import Cloud, NumpyCloud, numba_cloud

import physcore as pc
from physcore.numerics.choices import Precision

COUNT = 1_000_000
STEP = 0.002
DTYPES: dict[Precision, type[np.floating[Any]]] = {"f64": np.float64, "f32": np.float32}


def cloud(count: int) -> pc.Tracers:
    """Tracers about the attractor."""
    places = np.array([0.0, 0.0, 25.0]) + np.random.default_rng(3).normal(size=(count, 3))
    return pc.Tracers(places, pc.Lorenz())


def ours(count: int, precision: Precision, threads: int = 1) -> pc.Simulation:
    """physcore, by the classical Runge–Kutta method."""
    return pc.Simulation(pc.Scene(cloud(count)), pc.RungeKutta4(), dt=STEP, precision=precision, threads=threads)


def agree(make: type[Cloud], precision: Precision) -> None:
    """Refuse an opponent that does other work: after 0.1 s errors of rounding have grown tenfold at most."""
    simulation, rival = ours(700, precision), make(cloud(700).positions, DTYPES[precision], STEP)
    simulation.step(50)
    rival.step(50)
    tolerance = 50 * 10 * 50.0 * np.finfo(DTYPES[precision]).eps
    found = simulation[simulation.scene.systems[0]].positions
    np.testing.assert_allclose(rival.positions(), found, rtol=0.0, atol=tolerance)


def compare(precision: Precision) -> list[Contender]:
    """Race all versions in one precision."""
    compiled = {
        f"{'blocks' if blocks else 'one by one'}, {kind}": (numba_cloud(fastmath, blocks), 1)
        for kind, fastmath in FASTMATH.items()
        for blocks in (False, True)
    }
    for make, _ in [(NumpyCloud, 1), *compiled.values()]:
        agree(make, precision)
    places = cloud(COUNT).positions
    contenders = [
        *(Contender("physcore", ours(COUNT, precision, threads).step, threads) for threads in (1, 2)),
        *(numba_best(lambda make: make(places, DTYPES[precision], STEP).step, compiled, threads) for threads in (1, 2)),
        Contender("NumPy, blocks in the cache", NumpyCloud(places, DTYPES[precision], STEP).step),
    ]
    title = f"Runge–Kutta of order 4, Lorenz' flow, {COUNT} tracers, {precision}"
    return results(title, "point-steps", COUNT, race(contenders))


def main() -> dict[str, float]:
    """Print the tables; give the figures that have targets."""
    figures: dict[str, float] = {}
    for precision in DTYPES:
        contenders = compare(precision)
        figures[f"tracers {precision}"] = rate(contenders[0], COUNT)
        figures[f"two threads, tracers {precision}"] = speedup(contenders)
    return figures


if __name__ == "__main__":
    main()
