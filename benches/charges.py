"""Charges in a Penning trap by Boris' method beside NumPy and Numba: `python benches/charges.py`."""

from __future__ import annotations

from typing import Any

import numpy as np
from measure import Contender, race, rate, results, speedup
from rivals.charges import Ions, NumpyIons, numba_ions
from rivals.jit import FASTMATH, numba_best

import physcore as pc
from physcore.numerics.choices import Precision

COUNT = 1_000_000
STEP = 0.02
STRENGTH = 1.0
MAGNETIC = np.array([0.5, -1.0, 6.0])
DTYPES: dict[Precision, type[np.floating[Any]]] = {"f64": np.float64, "f32": np.float32}


def ions(count: int) -> pc.Particles:
    """Ions of charge and mass 1."""
    generator = np.random.default_rng(3)
    return pc.Particles(*generator.normal(size=(2, count, 3)), charge=1.0)


def ours(count: int, precision: Precision, threads: int = 1) -> pc.Simulation:
    """physcore, with its energy budget."""
    field = pc.ElectromagneticField(pc.QuadrupoleTrap(STRENGTH), tuple(MAGNETIC.tolist()))
    return pc.Simulation(pc.Scene(ions(count), field), pc.Boris(), dt=STEP, precision=precision, threads=threads)


def rival(count: int, make: type[Ions], precision: Precision) -> Ions:
    """An opponent with the same ions."""
    body = ions(count)
    return make(body.positions, body.velocities, DTYPES[precision], STEP, STRENGTH, MAGNETIC)


def agree(make: type[Ions], precision: Precision) -> None:
    """Refuse an opponent that does other work: the same places to rounding, some 20 of numbers below 5 in each step."""
    simulation, other = ours(700, precision), rival(700, make, precision)
    simulation.step(50)
    other.step(50)
    tolerance = 50 * 20 * 5.0 * np.finfo(DTYPES[precision]).eps
    np.testing.assert_allclose(other.positions(), simulation.positions, rtol=0.0, atol=tolerance)


def compare(precision: Precision) -> list[Contender]:
    """Race all versions in one precision."""
    compiled = {
        f"{'blocks' if blocks else 'one by one'}, {kind}": (numba_ions(fastmath, blocks), 1)
        for kind, fastmath in FASTMATH.items()
        for blocks in (False, True)
    }
    for make, _ in [(NumpyIons, 1), *compiled.values()]:
        agree(make, precision)
    contenders = [
        *(Contender("physcore", ours(COUNT, precision, threads).step, threads) for threads in (1, 2)),
        *(numba_best(lambda make: rival(COUNT, make, precision).step, compiled, threads) for threads in (1, 2)),
        Contender("NumPy, blocks in the cache", rival(COUNT, NumpyIons, precision).step),
    ]
    title = f"Boris' method in a Penning trap, {COUNT} ions, {precision}"
    return results(title, "particle-steps", COUNT, race(contenders))


def main() -> dict[str, float]:
    """Print the tables; give the figures that have targets."""
    figures: dict[str, float] = {}
    for precision in DTYPES:
        contenders = compare(precision)
        figures[f"Boris {precision}"] = rate(contenders[0], COUNT)
        figures[f"two threads, Boris {precision}"] = speedup(contenders)
    return figures


if __name__ == "__main__":
    main()
