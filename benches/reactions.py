"""Gray and Scott's reaction on a square beside NumPy and Numba: `python benches/reactions.py`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from measure import Contender, race, rate, results, speedup
from rivals.jit import FASTMATH, numba_best
from rivals.reactions import Dish, NumpyDish, numba_dish

import physcore as pc
from physcore.numerics.choices import Precision

CELLS = 4096
FEED, KILL, DIFFUSION, STEP = 0.035, 0.0625, (0.2, 0.1), 0.8
DTYPES: dict[Precision, type[np.floating[Any]]] = {"f64": np.float64, "f32": np.float32}
FUSED = (1, 4, 8)
"""Steps in a pass over memory that Numba tries; an even number leaves both times of the field where they are."""

Maker = Callable[[np.ndarray, type, tuple[float, ...]], Dish]


def start(cells: int) -> np.ndarray:
    """Stripes in which the reaction has begun, shape (2, cells, cells)."""
    wave = 0.5 + 0.5 * np.sin(0.2 * np.arange(cells))
    begun = wave[:, np.newaxis] * wave
    return np.stack([1.0 - 0.5 * begun, 0.25 * begun])


def dish(cells: int) -> pc.ReactionDiffusion:
    """Edges without flux, Δ = 1."""
    u, v = start(cells)
    grid = pc.Grid((cells, cells), 1.0)
    return pc.ReactionDiffusion(
        grid, pc.GrayScott(FEED, KILL), dict(zip("uv", DIFFUSION, strict=True)), {"u": u, "v": v}
    )


def ours(cells: int, precision: Precision, threads: int = 1) -> Contender:
    """physcore, by Euler's method, with the budgets of both species; in whole passes, as its opponents."""
    scene = pc.Scene(dish(cells))
    simulation = pc.Simulation(scene, pc.ExplicitEuler(), dt=STEP, precision=precision, threads=threads)
    return Contender("physcore", simulation.step, threads, multiple=max(FUSED))


def rival(make: Maker, cells: int, precision: Precision) -> Dish:
    """An opponent with the same reaction."""
    return make(start(cells), DTYPES[precision], (*(STEP * rate for rate in DIFFUSION), FEED, KILL, STEP))


def agree(make: Maker, precision: Precision, steps: int) -> None:
    """Refuse an opponent that does other work: the same values to rounding. In each step some twenty operations err by
    half an ulp of numbers up to 1, and errors grow by no more than the rate of the reaction, 1/s, lets them.
    """
    item = dish(60)
    simulation = pc.Simulation(pc.Scene(item), pc.ExplicitEuler(), dt=STEP, precision=precision)
    simulation.step(steps)
    other = rival(make, 60, precision)
    other.step(steps)
    rounding = 10 * steps * np.exp(0.1 * STEP * steps) * np.finfo(DTYPES[precision]).eps
    found = np.stack([simulation[item]["u"], simulation[item]["v"]])
    np.testing.assert_allclose(other.species(), found, rtol=0.0, atol=rounding)


def compare(precision: Precision) -> list[Contender]:
    """Race all versions in one precision."""
    compiled: dict[str, tuple[Maker, int]] = {
        f"{fused} steps a pass, {kind}": (numba_dish(fastmath, fused), fused)
        for kind, fastmath in FASTMATH.items()
        for fused in FUSED
    }
    for make, multiple in [(NumpyDish, 1), *compiled.values()]:
        agree(make, precision, 4 * multiple)

    def numba(threads: int) -> Contender:
        """The fastest version; several steps a pass run on one thread."""
        chosen = {name: one for name, one in compiled.items() if threads == 1 or one[1] == 1}
        return numba_best(lambda make: rival(make, CELLS, precision).step, chosen, threads)

    contenders = [
        *(ours(CELLS, precision, threads) for threads in (1, 2)),
        numba(1),
        numba(2),
        Contender("NumPy, bands in the cache", rival(NumpyDish, CELLS, precision).step),
    ]
    title = f"Gray and Scott's reaction, {CELLS}², Euler, {precision}"
    return results(title, "cell-updates", CELLS**2, race(contenders, repetitions=5))


def main() -> dict[str, float]:
    """Print the tables; give the figures that have targets."""
    figures: dict[str, float] = {}
    for precision in DTYPES:
        contenders = compare(precision)
        figures[f"reaction {precision}"] = rate(contenders[0], CELLS**2)
        figures[f"two threads, reaction {precision}"] = speedup(contenders)
    return figures


if __name__ == "__main__":
    main()
