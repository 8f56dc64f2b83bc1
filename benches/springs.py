"""A damped cloth, as a grid and as a shuffled network, beside NumPy and Numba: `python benches/springs.py`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from measure import Contender, fastest, race, rate, results, speedup, table
from rivals.jit import FASTMATH, numba_best, with_threads
from rivals.springs import Bincount, Maker, Slices
from rivals.springs_numba import numba_network

import physcore as pc
from physcore.numerics.choices import Precision

STEP = 1e-4
GRAVITY = -9.81
DTYPES: dict[Precision, type[np.floating[Any]]] = {"f64": np.float64, "f32": np.float32}
LARGE, SMALL = (316, 316), (15, 10)


def grid(shape: tuple[int, int]) -> pc.SpringNetwork:
    """Structural, shear and bend springs, about six for each particle; in motion."""
    velocities = np.random.default_rng(3).normal(0.0, 0.01, (shape[0] * shape[1], 2))
    velocities[-shape[0] :] = 0.0
    return pc.cloth(shape, spacing=0.01, stiffness=100.0, damping=0.01, mass=1e-3, pinned="top", velocities=velocities)


def shuffled(shape: tuple[int, int]) -> pc.SpringNetwork:
    """The same with its particles and springs in random order."""
    cloth, generator = grid(shape), np.random.default_rng(4)
    particles, springs = generator.permutation(len(cloth)), generator.permutation(len(cloth.pairs))
    return pc.SpringNetwork(
        cloth.positions[particles],
        np.argsort(particles)[cloth.pairs[springs]],
        cloth.stiffness[springs],
        cloth.damping[springs],
        cloth.rest_length[springs],
        mass=cloth.mass[particles],
        fixed=cloth.fixed[particles],
        velocities=cloth.velocities[particles],
    )


def agree(build: Callable[[tuple[int, int]], pc.SpringNetwork], makers: list[Maker], precision: Precision) -> None:
    """Refuse an opponent that does other work: after some steps all are in the same place, to rounding.

    A rounding of a length, ε·l, makes a force of k·ε·l, and moves its particle by k/m h² ε·l, at 12 springs, in a step;
    the speed that it gives lasts, so n steps add up to n²/2 such moves.
    """
    steps, shape = 20, (40, 30)
    body = build(shape)
    simulation = pc.Simulation(
        pc.Scene(body, pc.Gravity((0.0, GRAVITY))),
        pc.VelocityVerlet(),
        dt=STEP,
        precision=precision,
        threads=1,
    )
    simulation.step(steps)
    epsilon = np.finfo(DTYPES[precision]).eps
    rounding = 12 * epsilon * (steps + 100.0 / 1e-3 * STEP**2 * steps**2 / 2) * np.abs(body.positions).max()
    for make in makers:
        rival = make(body, shape, DTYPES[precision], STEP, GRAVITY)
        rival.step(steps)
        np.testing.assert_allclose(rival.positions(), simulation.positions, rtol=0.0, atol=rounding)


def compare(
    title: str,
    build: Callable[[tuple[int, int]], pc.SpringNetwork],
    shape: tuple[int, int],
    precision: Precision,
    numpy_versions: Mapping[str, Maker],
    numba_versions: Mapping[str, tuple[Maker, int]],
) -> list[Contender]:
    """Race all versions of one network in one precision."""
    agree(build, [*numpy_versions.values(), *(make for make, _ in numba_versions.values())], precision)
    body, dtype = build(shape), DTYPES[precision]
    scene = pc.Scene(body, pc.Gravity((0.0, GRAVITY)))

    def rival(make: Maker) -> Callable[[int], object]:
        return make(body, shape, dtype, STEP, GRAVITY).step

    ours = [
        Contender(
            "physcore",
            pc.Simulation(scene, pc.VelocityVerlet(), dt=STEP, precision=precision, threads=threads).step,
            threads,
        )
        for threads in (1, 2)
    ]
    plain = fastest([Contender(f"NumPy, {name}", rival(make)) for name, make in numpy_versions.items()])
    compiled = numba_best(rival, numba_versions)
    winner = {name: one for name, one in numba_versions.items() if compiled.name == f"Numba, {name}"}
    contenders = [*ours, compiled, numba_best(rival, winner, 2), plain]
    for make, _ in winner.values() if build is shuffled else ():
        orderly = make(grid(shape), shape, dtype, STEP, GRAVITY).step
        contenders.append(Contender(f"{compiled.name}, not shuffled", with_threads(1, orderly)))
    if shape == SMALL:
        contenders = [one for one in contenders if one.threads == 1]  # Too small for anyone to share.
    title, springs = f"{title}, {shape[0]}×{shape[1]}, {len(body.pairs)} springs, 2D, {precision}", len(body.pairs)
    return results(title, "spring-updates", springs, race(contenders))


def readings() -> Iterator[tuple[str, list[Contender]]]:
    """Every race of large networks by name: physcore on one thread and on two, then Numba on one and on two."""
    gathers = {f"gather, {kind}": (numba_network(fast, grid=False), 1) for kind, fast in FASTMATH.items()}
    shifts = {f"shifted rows, {kind}": (numba_network(fast, grid=True), 1) for kind, fast in FASTMATH.items()}
    plain = {"slices": Slices, "bincount": Bincount}
    for precision in DTYPES:
        yield f"grid {precision}", compare("Cloth, regular", grid, LARGE, precision, plain, gathers | shifts)
    for precision in DTYPES:
        yield (
            f"network {precision}",
            compare("Cloth, shuffled", shuffled, LARGE, precision, {"bincount": Bincount}, gathers),
        )
    yield "small cloth f32", compare("Cloth, small", grid, SMALL, "f32", plain, gathers | shifts)


def figures(races: Mapping[str, Sequence[Contender]]) -> dict[str, float]:
    """The figures that have targets."""
    found: dict[str, float] = {}
    springs = len(grid(LARGE).pairs)
    for name, contenders in races.items():
        if name == "small cloth f32":
            found[name] = 1e9 * rate(contenders[0], 1.0)
            table("Cloth, small", ("", "steps/s"), [(one.name, 1e9 * rate(one, 1.0)) for one in contenders[:2]])
        else:
            found[name] = rate(contenders[0], springs)
            found[f"two threads, {name}"] = speedup(contenders)
    return found


if __name__ == "__main__":
    figures(dict(readings()))
