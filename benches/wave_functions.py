"""Split steps of a wave function on a square beside SciPy and FFTW: `python benches/wave_functions.py`."""

from __future__ import annotations

from typing import Any

import numpy as np
from measure import Contender, race, results, speedup
from rivals.wave_functions import RIVALS, SplitSteps

import physcore as pc
from physcore.numerics.choices import Precision

CELLS = 1024
STEP = 0.3
DTYPES: dict[Precision, type[np.complexfloating[Any, Any]]] = {"f64": np.complex128, "f32": np.complex64}


def packet(cells: int) -> pc.Schrodinger:
    """A packet in a trap, periodic, m = ħ = Δ = 1."""
    grid = pc.Grid((cells, cells), 1.0, periodic=True)
    middle = 0.5 * cells
    start = pc.wave_packet(grid, middle, (0.5, 0.2), 0.04 * cells)
    return pc.Schrodinger(grid, start, potential=lambda x, y: ((x - middle) ** 2 + (y - middle) ** 2) / cells**2)


def ours(item: pc.Schrodinger, precision: Precision, threads: int = 1) -> pc.Simulation:
    """physcore, with the probability and ⟨H⟩ metered."""
    return pc.Simulation(pc.Scene(item), pc.SplitStep(), dt=STEP, precision=precision, threads=threads)


def rival(make: type[SplitSteps], item: pc.Schrodinger, precision: Precision, threads: int = 1) -> SplitSteps:
    """An opponent with the same packet."""
    q = 2.0 * np.pi * np.fft.fftfreq(item.grid.cells[0])
    phases = STEP * np.asarray(item.potential), 0.5 * STEP * (q[:, np.newaxis] ** 2 + q**2)
    return make(item.wave_function.view(np.complex128)[..., 0], phases, DTYPES[precision], threads)


def agree(make: type[SplitSteps], precision: Precision) -> None:
    """Refuse an opponent that does other work: the same ψ to rounding, log₂ N of errors of an ulp in each transform."""
    item = packet(64)
    simulation, other = ours(item, precision), rival(make, item, precision)
    simulation.step(10)
    other.step(10)
    rounding = 10 * 4 * np.log2(64**2) * np.finfo(DTYPES[precision]).eps * np.abs(other.values).max()
    np.testing.assert_allclose(other.values, simulation[item].wave_function, rtol=0.0, atol=rounding)


def compare(precision: Precision) -> list[Contender]:
    """Race all versions in one precision."""
    for make in filter(None, RIVALS.values()):
        agree(make, precision)
    item = packet(CELLS)
    contenders = [Contender("physcore", ours(item, precision, threads).step, threads) for threads in (1, 2)]
    contenders += [
        Contender(name, make and rival(make, item, precision, threads).step, threads)
        for name, make in RIVALS.items()
        for threads in (1, 2)
    ]
    title = f"Split steps of order 2, {CELLS}², periodic, {precision}"
    return results(title, "cell-updates", CELLS**2, race(contenders))


def main() -> dict[str, float]:
    """Print the tables; give the figures that have targets."""
    figures: dict[str, float] = {}
    for precision in DTYPES:
        contenders = compare(precision)
        figures[f"split step {precision}"] = 1e3 * sorted(contenders[0].cpu)[len(contenders[0].cpu) // 2]
        figures[f"two threads, split step {precision}"] = speedup(contenders)
    return figures


if __name__ == "__main__":
    main()
