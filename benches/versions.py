"""Two builds of physcore in turns: time per step and memory of typical scenes, and their ratio.

python benches/versions.py BEFORE AFTER [--turns N] [--only WORD]

BEFORE and AFTER are Python interpreters of environments with one build each, or folders for PYTHONPATH. Every scene is
stepped on one thread; a figure is the least processor time of all turns, and the memory is the largest resident set.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

PARTICLES = 200_000
REPEATS = 4


def scenes() -> dict[str, Callable[[], tuple[Any, dict[str, Any], int]]]:
    """Scenes by name: what to simulate, its numerics, and the steps of one measurement."""
    import numpy as np

    import physcore as pc

    rng = np.random.default_rng(0)

    def swarm(count: int = PARTICLES) -> pc.Particles:
        return pc.Particles(rng.uniform(-1, 1, (count, 3)), rng.uniform(-1, 1, (count, 3)))

    def free() -> pc.Scene:
        return pc.Scene(swarm(), pc.Gravity((0, 0, -9.81)), pc.Drag(0.1))

    def star() -> pc.Scene:
        return pc.Scene(swarm(), pc.CentralForce((0, 0, 0), 1.0, softening=0.1))

    def cloth(*shape: int) -> pc.Scene:
        body = pc.cloth(shape, 0.01, 100.0, 0.01, mass=1e-3, pinned="top")
        return pc.Scene(body, pc.Gravity((0, -9.81)))

    def dam() -> pc.Scene:
        water = pc.Fluid(pc.block((0, 0), (2, 1), 0.01), 0.01)
        return pc.Scene(water, pc.Gravity((0, -9.81)), pc.Box((0, 0), (4, 3)))

    def room() -> pc.Scene:
        return pc.Scene(swarm(20_000), pc.Gravity((0, 0, -9.81)), pc.Box((-1.1,) * 3, (1.1,) * 3))

    def custom() -> pc.Scene:
        return pc.Scene(pc.Particles(rng.uniform(-1, 1, (10, 2))), pc.CustomForce(lambda t, x, v: -x))

    def block() -> pc.Scene:
        water = pc.Fluid(pc.block((0, 0, 0), (1, 0.5, 1), 0.025), 0.025)
        return pc.Scene(water, pc.Gravity((0, 0, -9.81)), pc.Box((0, 0, 0), (2, 0.5, 2)))

    def pond() -> pc.Scene:
        return pc.Scene(pc.Wave(pc.Grid((1024, 1024), 0.01), 1.0, rng.uniform(-1, 1, (1024, 1024))))

    def dish() -> pc.Scene:
        start = {"u": 1.0, "v": rng.uniform(0, 0.5, (1024, 1024))}
        return pc.Scene(
            pc.ReactionDiffusion(
                pc.Grid((1024, 1024), 0.01), pc.GrayScott(0.035, 0.0625), {"u": 2e-5, "v": 1e-5}, start
            )
        )

    def packet() -> pc.Scene:
        grid = pc.Grid((512, 512), 0.1, periodic=True)
        return pc.Scene(pc.Schrodinger(grid, pc.wave_packet(grid, 25.0, 1.0, 2.0)))

    def dust() -> pc.Scene:
        return pc.Scene(pc.Tracers(rng.normal((0, 0, 25), size=(PARTICLES, 3)), pc.Lorenz()))

    def stars(count: int, **options: float) -> pc.Scene:
        return pc.Scene(swarm(count), pc.Gravitation(1.0, 0.05, **options))

    def trap() -> pc.Scene:
        ions = pc.Particles(rng.uniform(-1, 1, (PARTICLES, 3)), rng.uniform(-1, 1, (PARTICLES, 3)), charge=1.0)
        return pc.Scene(ions, pc.ElectromagneticField(pc.QuadrupoleTrap(1.0), (0.0, 0.0, 6.0)))

    found: dict[str, Callable[[], tuple[Any, dict[str, Any], int]]] = {}
    for precision in ("f32", "f64"):
        for integrator in (pc.VelocityVerlet(), pc.RungeKutta4(), pc.BogackiShampine3(), pc.DormandPrince5()):
            numerics = {"precision": precision, "dt": 1e-4, "integrator": integrator}
            name = f"{precision} {type(integrator).__name__}"
            found |= {
                f"free particles {name}": lambda numerics=numerics: (free(), numerics, 20),
                f"particles around a star {name}": lambda numerics=numerics: (star(), numerics, 20),
                f"cloth of 100 000 {name}": lambda numerics=numerics: (cloth(316, 316), numerics, 20),
            }
        numerics = {"precision": precision, "dt": 1e-4}
        found |= {
            f"cloth of 150 {precision}": lambda numerics=numerics: (cloth(15, 10), numerics, 40_000),
            f"particles in a box {precision}": lambda numerics=numerics: (room(), numerics, 100),
            f"dam in 2D {precision}": lambda numerics=numerics: (dam(), numerics, 60),
            f"dam in 3D {precision}": lambda numerics=numerics: (block(), numerics, 15),
            f"gravitation of all pairs {precision}": lambda numerics=numerics: (stars(10_000), numerics, 1),
            f"gravitation by a tree {precision}": lambda numerics=numerics: (
                stars(50_000, opening_angle=0.7),
                numerics,
                2,
            ),
            f"ions in a trap {precision}": lambda numerics=numerics: (trap(), numerics, 20),
            f"tracers in Lorenz' flow {precision}": lambda numerics=numerics: (dust(), numerics, 20),
            f"reaction of Gray and Scott {precision}": lambda numerics=numerics: (dish(), numerics, 20),
            f"wave function by split steps {precision}": lambda numerics=numerics: (packet(), numerics, 10),
            f"waves by PEFRL {precision}": lambda numerics=numerics: (
                pond(),
                {**numerics, "integrator": pc.PEFRL()},
                20,
            ),
            f"waves by RungeKutta4 {precision}": lambda numerics=numerics: (
                pond(),
                {**numerics, "integrator": pc.RungeKutta4()},
                20,
            ),
            f"waves {precision}": lambda numerics=numerics: (pond(), numerics, 20),
            f"cloth of 150 by PEFRL {precision}": lambda numerics=numerics: (
                cloth(15, 10),
                {**numerics, "integrator": pc.PEFRL()},
                10_000,
            ),
        }
    found["a function of the user's"] = lambda: (custom(), {"dt": 1e-3}, 5000)
    return found


def measure(name: str) -> None:
    """Print the time of a step [µs] and the memory of the process [MB]."""
    import physcore as pc

    warnings.simplefilter("ignore")
    scene, numerics, steps = scenes()[name]()
    simulation = pc.Simulation(scene, threads=1, **numerics)
    simulation.step(steps)
    best = float("inf")
    for _ in range(REPEATS):
        begin = time.process_time()
        simulation.step(steps)
        best = min(best, time.process_time() - begin)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({"time": 1e6 * best / steps, "memory": memory}))


def run(build: str, name: str) -> dict[str, float]:
    """The measurement of a scene by one of the builds, in a process of its own."""
    folder = Path(build).is_dir()
    environment = {**os.environ, "PYTHONPATH": build if folder else ""}
    command = [sys.executable if folder else build, __file__, "--measure", name]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    figures: dict[str, float] = json.loads(done.stdout)
    return figures


def main() -> None:
    """Compare both builds scene by scene."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("builds", nargs="*", metavar="BUILD")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--only", default="")
    parser.add_argument("--measure")
    arguments = parser.parse_args()
    if arguments.measure:
        return measure(arguments.measure)
    if len(arguments.builds) != 2:
        parser.error("two builds are compared: BEFORE AFTER")
    print("| scene | before [µs/step] | after | ratio | memory [MB] | after | ratio |\n|---|---|---|---|---|---|---|")
    for name in (name for name in scenes() if arguments.only in name):
        turns = [[run(build, name) for build in arguments.builds] for _ in range(arguments.turns)]
        cells = [name]
        for figure in ("time", "memory"):
            before, after = (min(turn[build][figure] for turn in turns) for build in (0, 1))
            cells += [f"{before:.4g}", f"{after:.4g}", f"{after / before:.2f}"]
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
