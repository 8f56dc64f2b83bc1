"""What the hardware gives: physcore beside the fastest loops that we know for the same work, in one run.

`python benches/hardware.py` prints what is asked, what was measured and the reference's figure. Particles and springs
are compared with Numba; fluids with a program outside this project, named by PHYSCORE_FLUID_REFERENCE, where there is
one. It takes `--n ROWS --threads T --warm STEPS --steps STEPS --reps TIMES --load STATE --dump STATE`, simulates a
broken dam of ROWS³ particles (a cube of water of 1 m in a tank of 2.5 m × 1 m × 2 m, Wendland's C2 kernel of 1.2
spacings, α = 0.1, c = 10 √(2g·1 m), steps of 0.2 h/c), and keeps states as x, y, z, u, v, w in f32. With --large also
10⁶ particles in the fluid, and 10⁷ independent ones and springs.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from math import inf, nan, sqrt
from pathlib import Path
from statistics import median
from typing import TypeAlias

import numpy as np
import particles
import springs
from measure import Contender, cell, judge, rate, speedup

import physcore as pc

REFERENCE = "PHYSCORE_FLUID_REFERENCE"
BREAKING = 1200
"""Steps after which the dam has broken."""
STEPS, TURNS = 20, 5
Races: TypeAlias = Mapping[str, Sequence[Contender]]
Row: TypeAlias = tuple[str, float, float, bool]
"""A name, what is asked, what was found, and whether the latter may be at most that."""
SOUND = 10.0 * sqrt(2.0 * 9.81)


def independent(races: Races) -> list[Row]:
    """Particles without forces between them, of Numba's loop with several steps fused."""
    rows = []
    for name, (ours, both, numba, *_) in races.items():
        told = f"{name}, of {numba.name}, {cell(rate(numba, particles.COUNT))} G/s"
        rows.append((told, 0.85, median(numba.cpu) / median(ours.cpu), False))
        rows.append((f"{name}, two threads over one", 1.9, speedup([ours, both]), False))
    return rows


def networks(races: Races) -> list[Row]:
    """Springs of a grid, of Numba's shifted rows; and of a shuffled network, of those of the grid."""
    rows = []
    for precision, asked in (("f32", 0.4), ("f64", 0.5)):
        ours, both, numba, *_ = races[f"grid {precision}"]
        other, other_both, *_ = races[f"network {precision}"]
        name, theirs, grid, mixed = f"springs, {precision}", *(median(one.cpu) for one in (numba, ours, other))
        rows += [
            (f"{name}, grid, of {numba.name}, {cell(1e3 * theirs)} ms/step", 1.15, theirs / grid, False),
            (f"{name}, shuffled, of the grid, {cell(1e3 * grid)} ms/step", asked, grid / mixed, False),
            (f"{name}, grid, two threads over one", 1.9, speedup([ours, both]), False),
            (f"{name}, shuffled, two threads over one", 1.9, speedup([other, other_both]), False),
        ]
    return rows


class Dam:
    """A dam that the reference has broken, in f32."""

    def __init__(self, program: str, rows: int, folder: Path) -> None:
        self.program, self.rows, self.state = program, rows, folder / f"dam{rows}"
        self.run(STEPS, "--warm", str(BREAKING), "--dump", str(self.state))
        table = np.fromfile(self.state, np.float32).reshape(-1, 6).astype(float)
        self.positions, self.velocities = table[:, :3], table[:, 3:]

    def run(self, steps: int, *options: str) -> float:
        """What the reference takes on one thread [s], of the processor."""
        always = ["--n", str(self.rows), "--threads", "1", "--steps", str(steps), "--reps", "1"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run([self.program, *always, *options], stdout=subprocess.DEVNULL, check=True)
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before

    def step(self) -> float:
        """What a step takes, from runs of different lengths: they also read the state, and make their first lists."""
        short, long = (self.run(steps, "--warm", "10", "--load", str(self.state)) for steps in (STEPS, 4 * STEPS))
        return (long - short) / (3 * STEPS)

    def simulation(self, walls: bool, threads: int = 1) -> pc.Simulation:
        """The same dam in physcore, with walls and δ-SPH or without either."""
        spacing = 1.0 / self.rows
        fluid = pc.Fluid(
            pc.block((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), spacing),
            spacing,
            sound_speed=SOUND,
            kernel=pc.WendlandC2(smoothing=1.2),
            viscosity=0.0,
            artificial_viscosity=0.1,
            density_diffusion=0.1 if walls else 0.0,
        )
        tank = [pc.Box((0.0, 0.0, 0.0), (2.5, 1.0, 2.0))] if walls else []
        scene = pc.Scene(fluid, pc.Gravity((0.0, 0.0, -9.81)), *tank)
        simulation = pc.Simulation(scene, dt=0.2 * 1.2 * spacing / SOUND, precision="f32", threads=threads)
        # The reference lets particles be nearer to each other than a fluid may begin with.
        simulation.set(positions=self.positions, velocities=self.velocities)
        return simulation

    def race(self) -> list[Row]:
        """The rows of this dam: the fastest of some turns each."""
        count, reference = len(self.positions), inf
        simulations = {walls: self.simulation(walls) for walls in (False, True)}
        ours = {walls: Contender("physcore", simulation.step) for walls, simulation in simulations.items()}
        both = Contender("physcore", self.simulation(False, threads=2).step, 2)
        for contender in (*ours.values(), both):
            contender.step(STEPS)
            contender.steps = STEPS
        for _ in range(TURNS):
            reference = min(reference, self.step())
            for contender in (*ours.values(), both):
                contender.turn()
        name, told = f"fluid 3D, {count}", f"of the reference, {cell(1e-6 * count / reference)} M/s"
        return [
            (f"{name}, no walls, {told}", 0.85, reference / min(ours[False].cpu), False),
            (f"{name}, walls, δ-SPH, {told}", 0.65, reference / min(ours[True].cpu), False),
            (f"{name}, two threads over one", 1.9, speedup([ours[False], both]), False),
            (f"{name}, bytes per particle", 300, simulations[True].plan.memory / count, True),
        ]


def fluids(large: bool) -> list[Row]:
    """Rows of the fluid, if there is a reference."""
    program = os.environ.get(REFERENCE)
    if not program:
        return [(f"fluid 3D, of the reference, no {REFERENCE}", 0.85, nan, False)]
    with tempfile.TemporaryDirectory() as folder:
        return [row for rows in ((46, 100) if large else (46,)) for row in Dam(program, rows, Path(folder)).race()]


def beyond_caches() -> list[Row]:
    """The cost of a particle or a spring among 10⁷ over that among 10⁶, in runs of the same number of steps."""

    def cost(scene: pc.Scene, work: int, steps: int) -> float:
        step = pc.Simulation(scene, pc.VelocityVerlet(), dt=particles.STEP, precision="f32", threads=1).step
        step(steps)
        contender = Contender("physcore", step, steps=steps)
        for _ in range(3):
            contender.turn()
        return min(contender.cpu) / work

    few, many = (cost(particles.falling(count), count, 100) for count in (10**6, 10**7))
    cloths = [springs.grid((side, side)) for side in (408, 1291)]
    loose, dense = (cost(pc.Scene(cloth, pc.Gravity((0.0, springs.GRAVITY))), len(cloth.pairs), 10) for cloth in cloths)
    return [
        ("Verlet f32, 10⁷ over 10⁶, cost each, 100 steps a call", 1.3, many / few, True),
        ("springs f32, grid, 10⁷ over 10⁶, cost each, 10 steps a call", 1.3, dense / loose, True),
    ]


def show(particle_races: Races, spring_races: Races) -> None:
    """Print the table, from races of particles and of springs; those of fluids are run here."""
    large = "--large" in sys.argv
    rows = [*independent(particle_races), *networks(spring_races), *fluids(large), *(beyond_caches() if large else [])]
    judge("What the hardware gives", rows)


if __name__ == "__main__":
    show(dict(particles.readings()), dict(springs.readings()))
