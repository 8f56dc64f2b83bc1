"""The wave equation on a square beside NumPy and Numba: `python benches/waves.py`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from measure import Contender, race, rate, results, speedup, table
from rivals.jit import FASTMATH, numba_best
from rivals.waves import NumpyPond, Pond, numba_pond

import physcore as pc
from physcore.numerics.choices import Precision

CELLS = 4096
COURANT = 0.5
"""c h/Δ."""
DTYPES: dict[Precision, type[np.floating[Any]]] = {"f64": np.float64, "f32": np.float32}
FUSED = (1, 4, 8, 16)
"""Steps in a pass over memory that Numba tries; an even number leaves both times of the field where they are."""

Maker = Callable[[np.ndarray, type, float], Pond]


def pond(cells: int) -> pc.Wave:
    """Random displacements between fixed edges, c = Δ = 1: after a few steps half of the energy is kinetic, and nothing
    has to be diagnosed.
    """
    displacements = np.random.default_rng(3).uniform(-1.0, 1.0, (cells, cells))
    return pc.Wave(pc.Grid((cells, cells), 1.0), 1.0, displacements)


def ours(cells: int, precision: Precision, threads: int = 1) -> Contender:
    """physcore, by Verlet's method; in whole passes, as its opponents."""
    scene = pc.Scene(pond(cells))
    simulation = pc.Simulation(scene, pc.VelocityVerlet(), dt=COURANT, precision=precision, threads=threads)
    return Contender("physcore", simulation.step, threads, multiple=max(FUSED))


def agree(make: Maker, precision: Precision, steps: int) -> None:
    """Refuse an opponent that does other work: the same displacements to rounding. In each step ten operations err
    by half an ulp, and errors in second differences grow with the square of the steps.
    """
    wave = pond(60)
    simulation = pc.Simulation(pc.Scene(wave), pc.VelocityVerlet(), dt=COURANT, precision=precision)
    simulation.step(steps)
    rival = make(np.asarray(wave.displacement), DTYPES[precision], COURANT)
    rival.step(steps)
    rounding = 10 * steps**2 * np.finfo(DTYPES[precision]).eps
    np.testing.assert_allclose(rival.displacement(), simulation[wave].displacement, rtol=0.0, atol=rounding)


def compare(precision: Precision) -> list[Contender]:
    """Race all versions in one precision."""
    compiled: dict[str, tuple[Maker, int]] = {
        f"{fused} steps a pass, {kind}": (numba_pond(fastmath, fused), fused)
        for kind, fastmath in FASTMATH.items()
        for fused in FUSED
    }
    for make, multiple in [(NumpyPond, 1), *compiled.values()]:
        agree(make, precision, 16 * multiple)
    start = np.asarray(pond(CELLS).displacement)

    def rival(make: Maker) -> Callable[[int], object]:
        return make(start, DTYPES[precision], COURANT).step

    def numba(threads: int) -> Contender:
        """The fastest version; several steps a pass run on one thread."""
        chosen = {name: one for name, one in compiled.items() if threads == 1 or one[1] == 1}
        return numba_best(rival, chosen, threads)

    contenders = [
        *(ours(CELLS, precision, threads) for threads in (1, 2)),
        numba(1),
        numba(2),
        Contender("NumPy, bands in the cache", rival(NumpyPond)),
    ]
    title = f"Wave equation, {CELLS}², uniform speed, fixed edges, {precision}"
    return results(title, "cell-updates", CELLS**2, race(contenders))


def main() -> dict[str, float]:
    """Print the tables; give the figures that have targets."""
    figures: dict[str, float] = {}
    for precision in DTYPES:
        contenders = compare(precision)
        figures[f"wave {precision}"] = rate(contenders[0], CELLS**2)
        figures[f"two threads, wave {precision}"] = speedup(contenders)
        large, middle, small = (ours(cells, precision) for cells in (8192, 1024, 64))
        race([large, middle, small])
        figures[f"wave {precision}, 8192² over 1024²"] = rate(middle, 1024**2) / rate(large, 8192**2)
        figures[f"small wave {precision}"] = 1e9 * rate(small, 1.0)
        columns = ("8192² over 1024², time of a cell", "64², steps/s")
        table(f"Wave equation, other sizes, {precision}", columns, [tuple(figures.values())[-2:]])
    return figures


if __name__ == "__main__":
    main()
