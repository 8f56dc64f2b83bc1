"""Rigid bodies beside Box2D, pymunk, Rapier, MuJoCo, PyBullet, NumPy and Numba: `python benches/rigid.py`.

Rows say which engines are not installed: pip install "physcore[bench-rigid]", and libbox2d-dev from the system for
Box2D 2.4. A step is a sixtieth of a second, which an engine may take in parts. No engine may let bodies sleep,
but for the row that compares physcore with itself.

`piles.py` says how they are compared.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from math import nan
from statistics import median
from time import process_time
from typing import Any

import numpy as np
from measure import Contender, cell, fastest, machine, race, results, speedup, table
from piles import LIMIT, STEP, Ours, Peers, drop, equal, ratio, runs, show
from rivals.jit import FASTMATH
from rivals.rigid import planar, spatial
from rivals.rigid.pile import Array, discs_in_a_box, heap, pyramid, rotations, together
from rivals.rigid.tumbling import VERSIONS, NumpyTumbling, Tumbling, numba_tumbling

import physcore as pc

STANDING = 0.25
"""Sides that no box of a pyramid that stands may have moved."""
TUMBLING_STEP = 0.01


PLANAR: Peers = {
    planar.Box2D3: {"": {}, "finer": {"scale": 10.0, "stiff": True}},
    planar.Box2D2: {"": {}, "finer": {"scale": 10.0}},
    planar.Pymunk: {"": {}, "finer": {"slop": 0.1 * planar.SLOP}, "spatial hash": {"hashed": True}},
}
STACKED: Peers = {
    planar.Box2D3: {"": {}, "finer": {"scale": 10.0, "stiff": True}},
    planar.Box2D2: {"": {}, "finer": {"scale": 10.0}},
    planar.Pymunk: {"": {}, "30 iterations": {"iterations": 30}},
}
SPATIAL: Peers = {
    spatial.Rapier: {"": {}, "finer": {"unit": 0.1, "stiff": True}},
    spatial.MuJoCo: {"": {}, "finer": {"stiff": True}},
    spatial.PyBullet: {"": {}, "10 iterations": {"iterations": 10}},
}
"""Settings of engines by name. Box2D and Rapier leave overlaps below 5 mm alone, and less in another unit of length.
MuJoCo takes Newton's method with sparse matrices: conjugate gradients took twice as long in all these scenes.
"""


def discs(count: int = 5000, seconds: float = 10.0) -> dict[str, float]:
    """Settled in a box."""
    contestants = runs(discs_in_a_box(count), PLANAR, planar.version, (1, 2, 4))
    drop(contestants, seconds)
    show(f"{count} discs, {seconds:g} s from when they are dropped", contestants)
    chosen = [run for run in equal(contestants) if not run.stopped]
    if chosen[:1] != contestants[:1]:
        return {"discs": nan}
    settled = [Contender(run.name, run.engine.step, multiple=run.parts) for run in chosen]
    race(settled)
    times = {one.name: run.parts * median(one.cpu) for one, run in zip(settled, chosen, strict=True)}
    best = {one.name: run.parts * min(one.cpu) for one, run in zip(settled, chosen, strict=True)}
    rows = [(name, 1e3 * time, 1e3 * best[name], time / times["physcore"]) for name, time in times.items()]
    columns = ("", "median [ms]", "best [ms]", "physcore is [times]")
    table(f"{count} settled discs, a sixtieth of a second [CPU time]", columns, rows)
    return {"discs": ratio(times)}


def boxes(rows: int = 40, seconds: float = 60.0) -> dict[str, float]:
    """A pyramid that stands."""
    contestants = runs(pyramid(rows), STACKED, planar.version, (1, 2, 4))
    drop(contestants, seconds)
    show(f"Pyramid of {rows * (rows + 1) // 2} boxes, {seconds:g} s", contestants)
    for run in contestants:
        print(f"{run.name}: {run.stopped or ('stands' if run.moved < STANDING else 'has fallen')}")
    times = {run.name: run.milliseconds for run in equal(contestants) if run.moved < STANDING}
    ours = contestants[0]
    if ours.stopped:
        return {"pyramid": nan, "pyramid, displacement": nan}
    return {"pyramid": ratio({ours.name: ours.milliseconds, **times}), "pyramid, displacement": ours.moved}


def cuboids(side: int = 10, seconds: float = 5.0) -> dict[str, float]:
    """Dropped in a heap."""
    contestants = runs(heap((side, side, side)), SPATIAL, spatial.version, (1, 2, 4))
    drop(contestants, seconds)
    show(f"{side**3} cuboids, {seconds:g} s from when they are dropped", contestants)
    if contestants[0].stopped:
        return {"heap": nan}
    return {"heap": ratio({run.name: run.milliseconds for run in equal(contestants)})}


def tumbling(count: int = 100_000) -> dict[str, float]:
    """Free rotation; all compute the same to rounding."""
    generator, block = np.random.default_rng(0), pc.Cuboid(0.4, 0.3, 0.1)
    turns = generator.normal(size=(count, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    spins, velocities = generator.normal(size=(count, 3)), 1e-6 * generator.normal(size=(count, 3))
    side = int(np.ceil(count ** (1.0 / 3.0)))
    places = np.stack(np.unravel_index(np.arange(count), (side,) * 3), axis=1).astype(float)
    bodies = pc.RigidBodies(block, places, orientations=turns, velocities=velocities, angular_velocities=spins)
    moments = np.diag(np.asarray(block.moment))

    def ours() -> pc.Simulation:
        return pc.Simulation(pc.Scene(bodies), dt=TUMBLING_STEP, threads=1)

    def rival(make: type[Tumbling]) -> Contender:
        other, simulation = make(moments, turns, spins, velocities, TUMBLING_STEP), ours()
        start = energies(moments, simulation[bodies])
        other.step(10)
        simulation.step(10)
        result = simulation[bodies]
        same = np.abs((other.turns() * result.orientations).sum(axis=1)).min()
        np.testing.assert_allclose(same, 1.0, rtol=0.0, atol=1e-13)
        print(
            f"largest change of a body's energy in 10 steps: {np.abs(energies(moments, result) / start - 1).max():.1e}"
        )
        return Contender("", other.step)

    contenders = [Contender("physcore", ours().step)]
    for name, series in VERSIONS.items():
        variants = []
        for kind, fastmath in FASTMATH.items():
            variants.append(rival(numba_tumbling(fastmath, series)))
            variants[-1].name = f"Numba, {name}, {kind}"
        contenders.append(fastest(variants) if variants else Contender(f"Numba, {name}", None))
    contenders.append(rival(NumpyTumbling))
    contenders[-1].name = "NumPy"
    results(f"{count} free tumbling bodies, order 2, f64", "body-steps", count, race(contenders))
    ours_takes, *theirs = (median(one.cpu) for one in contenders)
    return {f"tumbling, {name}": time / ours_takes for name, time in zip(VERSIONS, theirs, strict=False)}


def energies(moments: Array, result: Any) -> Array:
    """Kinetic energies of rotation of bodies of density 1."""
    along = np.einsum("bij,bi->bj", rotations(result.orientations), result.angular_velocities)
    return 0.5 * (moments * along**2).sum(axis=1)


def piles(layers: int = 5, seconds: float = 3.0) -> dict[str, float]:
    """Two threads over one, of 20 piles that do not touch."""
    places = [(15.0 * (k % 5), 15.0 * (k // 5)) for k in range(20)]
    flat = together([pyramid(2 * layers, 4.0 * layers * k) for k in range(20)])
    deep = together([heap((5, 2, layers), at, seed) for seed, at in enumerate(places)])
    figures: dict[str, float] = {}
    for name, pile in (("3D", deep), ("2D", flat)):
        engines = {threads: Ours(pile, threads=threads) for threads in (1, 2)}
        if reason := settle(engines.values(), round(seconds / STEP)):
            print(f"20 piles, {name}, are left out: {reason}")
            figures[f"two threads, 20 piles in {name}"] = nan
            continue
        contenders = race([Contender("physcore", engine.step, threads) for threads, engine in engines.items()])
        count = len(pile.mass)
        results(f"20 piles of {count // 20} bodies each, {name}", "body-steps", count, contenders)
        figures[f"two threads, 20 piles in {name}"] = gain(*contenders)
    return figures


def asleep(count: int = 1000, seconds: float = 10.0) -> dict[str, float]:
    """A settled pile with and without sleep, by physcore alone."""
    engines = {sleep: Ours(discs_in_a_box(count), sleep=sleep) for sleep in (0.05, None)}
    if reason := settle(engines.values(), round(seconds / STEP)):
        print(f"Sleep is left out: {reason}")
        return {"asleep": nan}
    sleeping = sum(int(engines[0.05].simulation[body].asleep.sum()) for body in engines[0.05].bodies)
    print(f"{sleeping} of {count} discs sleep after {seconds:g} s")
    contenders = race([Contender(f"sleep={sleep}", engine.step) for sleep, engine in engines.items()])
    rows = [(one.name, 1e3 * median(one.cpu), 1e3 * min(one.cpu)) for one in contenders]
    table(f"{count} settled discs, a sixtieth of a second [CPU time]", ("", "median [ms]", "best [ms]"), rows)
    return {"asleep": median(contenders[1].cpu) / median(contenders[0].cpu)}


def afloat(cells: int = 120) -> dict[str, float]:
    """A box that floats in water, in single and double precision, by physcore alone."""
    water = pc.Fluid.block((0.0, 0.0), (3.0, 1.0), spacing=1.0 / cells)
    box = pc.RigidBody(pc.Rectangle(0.5, 0.4), (1.5, 1.2 + 0.5 / cells), density=500.0)
    scene = pc.Scene(water, box, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (3.0, 3.0)))
    runs = {precision: pc.Simulation(scene, precision=precision, threads=1) for precision in ("f32", "f64")}
    contenders = race([Contender(name, run.step) for name, run in runs.items()])
    rows = [(one.name, 1e3 * median(one.cpu), 1e3 * min(one.cpu)) for one in contenders]
    table(
        f"a box in {len(water.positions)} particles of water, a step [CPU time]", ("", "median [ms]", "best [ms]"), rows
    )
    return {"afloat, time of f32 over f64": median(contenders[0].cpu) / median(contenders[1].cpu)}


def settle(engines: Iterable[Ours], steps: int) -> str:
    """Take steps; give the reason if that fails."""
    start = process_time()
    for engine in engines:
        for _ in range(steps):
            try:
                engine.step(1)
            except pc.SimulationDiverged as error:
                return str(error)
            if process_time() - start > LIMIT:
                return f"physcore took more than {LIMIT:g} s to let them settle"
    return ""


def gain(one: Contender, two: Contender) -> float:
    """The speedup, which is also known where the second thread had nothing to do."""
    idle = max(two.cpu) < 1.1 * min(two.wall) and max(one.cpu) > 0.95 * min(one.wall)
    return min(one.wall) / min(two.wall) if idle else speedup([one, two])


ROWS: dict[str, tuple[Callable[..., dict[str, float]], dict[str, Any]]] = {
    "discs": (discs, {"count": 200, "seconds": 2.0}),
    "pyramid": (boxes, {"rows": 8, "seconds": 2.0}),
    "heap": (cuboids, {"side": 3, "seconds": 2.0}),
    "tumbling": (tumbling, {"count": 2000}),
    "piles": (piles, {"layers": 2, "seconds": 1.0}),
    "asleep": (asleep, {"count": 50, "seconds": 8.0}),
    "afloat": (afloat, {"cells": 20}),
}
"""Rows of the table, and what makes each short."""


def main(names: Iterable[str] = tuple(ROWS), short: bool = False) -> dict[str, float]:
    """Print the tables; give the figures that have targets."""
    figures: dict[str, float] = {}
    for name in names:
        row, less = ROWS[name]
        figures |= row(**less if short else {})
    return figures


def command() -> None:
    """Run some rows."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("--only", action="append", choices=list(ROWS), help="a row; repeatable")
    parser.add_argument("--short", action="store_true", help="small scenes, to see whether all run")
    options = parser.parse_args()
    print(machine(""))
    for name, figure in main(options.only or tuple(ROWS), options.short).items():
        print(f"{name}: {cell(figure)}")


if __name__ == "__main__":
    command()
