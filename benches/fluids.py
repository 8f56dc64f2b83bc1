"""Fluids, and particles that meet, beside Numba: `python benches/fluids.py`; with --large 10⁶ particles in 3D too."""

from __future__ import annotations

import sys
import warnings
from dataclasses import dataclass, replace
from math import ceil, sqrt
from statistics import median

import numpy as np
from measure import Contender, race, rate, results, speedup, table
from numpy.typing import NDArray
from rivals.fluids_numba import NumbaFluid, Tank
from rivals.jit import FASTMATH, with_threads

import physcore as pc
from physcore.numerics.choices import Precision

G = 9.81
HEIGHT = 1.0
SOUND = 10.0 * sqrt(2.0 * G * HEIGHT)
"""Ten times the speed of a fall from the top [m/s]."""
KERNEL = pc.WendlandC2(smoothing=1.2)
VISCOSITY = 0.1
"""The artificial one, so much that the finest waves do not last."""
FALL = {2: 0.04, 3: 0.08}
"""How long the dam has been open when the race begins [s], by dimension."""
REPETITIONS = 4
DEPTH, WIDTH, TANK = 0.8, 0.5, (2.5, 2.0)
"""Of the column in 3D, of that in 2D, and of the tank along and upward [m]."""


@dataclass(frozen=True)
class Dam:
    """A dam break at some moment."""

    fluid: pc.Fluid
    densities: NDArray[np.float64]
    dt: float
    method: pc.WeaklyCompressible
    walls: bool = True

    @property
    def scene(self) -> pc.Scene:
        """What physcore is given."""
        down = (*(0.0 for _ in self.upper[1:]), -G)
        box = [pc.Box(tuple(0.0 for _ in self.upper), self.upper)] if self.walls else []
        return pc.Scene(self.fluid, pc.Gravity(down), *box)

    @property
    def upper(self) -> tuple[float, ...]:
        """The upper corner of the tank."""
        return (TANK[0], DEPTH, TANK[1]) if self.fluid.dimension == 3 else TANK

    def simulation(self, threads: int = 1, precision: Precision = "f32") -> pc.Simulation:
        """Its simulation."""
        return pc.Simulation(self.scene, dt=self.dt, precision=precision, threads=threads, fluids=self.method)

    def rival(self) -> NumbaFluid:
        """Numba's."""
        lower = tuple(0.0 for _ in self.upper)
        return NumbaFluid(
            Tank(self.fluid, self.method, self.densities, SOUND, lower, self.upper, G, self.walls), self.dt
        )


def standing(dimension: int, rows: int, smoothing: float = KERNEL.smoothing) -> Dam:
    """A column of so many rows of particles, in a corner of the tank."""
    spacing = HEIGHT / rows
    top = (HEIGHT, DEPTH, HEIGHT) if dimension == 3 else (WIDTH, HEIGHT)
    places = pc.block(tuple(0.0 for _ in top), top, spacing)
    fluid = pc.Fluid(places, spacing)
    method = pc.WeaklyCompressible(
        sound_speed=SOUND, kernel=pc.WendlandC2(smoothing), artificial_viscosity=VISCOSITY, shifting=0.0
    )
    dam = Dam(fluid, np.empty(0), dt=1e-6, method=method)
    simulation = dam.simulation()
    return replace(dam, densities=simulation[fluid].densities, dt=0.5 * simulation.plan.dt_limit)


def flowing(dimension: int, rows: int) -> Dam:
    """The same when it has begun to move; it begins anew with the density under the weight of what is above."""
    dam = standing(dimension, rows)
    simulation = dam.simulation(threads=2)
    simulation.step(ceil(FALL[dimension] / dam.dt))
    moved = replace(dam, fluid=_like(dam.fluid, simulation.positions, simulation.velocities))
    return replace(moved, densities=moved.simulation()[0].densities)


def _like(fluid: pc.Fluid, positions: NDArray[np.float64], velocities: NDArray[np.float64]) -> pc.Fluid:
    """The same fluid, elsewhere."""
    return pc.Fluid(positions, fluid.spacing, velocities=velocities)


def bare(dam: Dam) -> Dam:
    """The same without walls and diffusion."""
    return replace(dam, method=replace(dam.method, density_diffusion=0.0), walls=False)


def agree(dimension: int) -> None:
    """Refuse an opponent that does other work: after some steps all are in the same place.

    It keeps positions in single precision, so that distances are good to ε·L/Δ ≈ 1e-5; of the way of the fastest
    particle a tenth of a percent is allowed. With walls that holds for four fifths of all, and the others are off by
    two percent at most: its walls pull at what leaves them at the surface, and physcore's do not.
    """
    dam = standing(dimension, 10)
    for one, share, most in ((bare(dam), 1.0, 1e-3), (dam, 0.8, 2e-2)):
        simulation, rival = one.simulation(), one.rival()
        simulation.step(60)
        rival.step(60)
        way = np.abs(simulation.positions - dam.fluid.positions).max()
        off = np.abs(rival.positions() - simulation.positions)
        if (off < 1e-3 * way).mean() < share or off.max() > most * way:
            raise AssertionError(f"{dimension}D: the opponent is off by up to {off.max() / way:.1e} of the way")


def compare(dimension: int, rows: int) -> dict[str, float]:
    """Race over one dam; what it gives by name."""
    if FASTMATH:
        agree(dimension)
    dam = flowing(dimension, rows)
    plain, count, name = bare(dam), len(dam.fluid), f"{dimension}D"
    simulations = [dam.simulation(threads) for threads in (1, 2)]
    ours = [Contender("physcore", one.step, threads) for threads, one in enumerate(simulations, start=1)]
    theirs = [numba(dam, threads) for threads in (1, 2)]
    double = Contender("physcore, f64", dam.simulation(precision="f64").step)
    free = [Contender("physcore", plain.simulation().step), numba(plain, 1)]
    race([*ours, *theirs, double, *free], REPETITIONS)
    plan = simulations[0].plan
    title = f"{count} particles, {name}, dt = {dam.dt * SOUND / (KERNEL.smoothing * dam.fluid.spacing):.2f} h/c"
    results(f"Dam break, {title}, f32", "particle-steps", count, [*ours, *theirs])
    results(f"Dam break without walls and diffusion, {title}, f32", "particle-steps", count, free)
    figures = {
        f"fluid {name}": 1e3 * rate(ours[0], count),
        f"fluid {name}, no walls": 1e3 * rate(free[0], count),
        f"two threads, fluid {name}": speedup(ours),
        f"fluid {name}, f64 over f32": median(ours[0].cpu) / median(double.cpu),
        f"memory, fluid {name}": plan.memory / count,
    }
    walls = [median(one.cpu) / median(other.cpu) for one, other in zip((ours[0], theirs[0]), free, strict=True)]
    columns = ("", "f64 over f32", "bytes per particle", "step with walls over one without", "in Numba")
    table("Ratios", columns, [(f"fluid {name}", *list(figures.values())[-2:], *walls)])
    return figures


def numba(dam: Dam, threads: int) -> Contender:
    """The opponent."""
    name = "Numba, lists, fastmath"
    return Contender(name, with_threads(threads, dam.rival().step) if FASTMATH else None, threads)


def deviations(dam: Dam, dt: float, moments: int, duration: float) -> tuple[int, NDArray[np.float64]]:
    """How many steps a run takes, and ρ/ρ₀ − 1 of all particles at equal times."""
    steps = ceil(duration / moments / dt)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pc.StabilityWarning)
        simulation = replace(dam, dt=duration / moments / steps).simulation()
    found = []
    for _ in range(moments):
        simulation.step(steps)
        found.append(simulation[0].densities / dam.fluid.density - 1.0)
    return moments * steps, np.array(found)


def trade() -> None:
    """Print how many steps a dam break takes, and how wrong its density is, at several time steps."""
    dam = standing(2, 32, smoothing=1.5)
    unit = dam.method.kernel.smoothing * dam.fluid.spacing / SOUND
    limit = 2.0 * dam.dt / unit
    duration, moments = 0.4, 8
    choices = {"reference": 0.05, "0.2 h/c": 0.2, "half the limit": 0.5 * limit, "95 % of the limit": 0.95 * limit}
    runs = [deviations(dam, number * unit, moments, duration) for number in choices.values()]
    (_, exact), (customary, _), *_ = runs
    table(
        f"Dam break, {len(dam.fluid)} particles, 2D, f32, {duration} s",
        ("", "c dt/h", "steps", "fewer than at 0.2 h/c, times", "rms of ρ/ρ₀−1", "off the reference"),
        [
            (name, number, steps, customary / steps, np.sqrt(np.mean(off**2)), np.sqrt(np.mean((off - exact) ** 2)))
            for (name, number), (steps, off) in zip(choices.items(), runs, strict=True)
        ],
    )


def grains(rows: int) -> pc.Scene:
    """A heap of soft grains that touch, in motion."""
    places = pc.block((0.0, 0.0, 0.0), (1.0, DEPTH, 1.0), 1.0 / rows)
    velocities = np.random.default_rng(5).normal(0.0, 0.1, places.shape)
    spheres = pc.Particles(places, velocities, mass=1e-3, radius=0.52 / rows)
    bounds = pc.Box((-0.1, -0.1, 0.0), (1.1, DEPTH + 0.1, 2.0))
    return pc.Scene(spheres, pc.SoftSpheres(1e3, damping=0.1, friction=0.3), pc.Gravity((0.0, 0.0, -G)), bounds)


def liquid(rows: int) -> pc.Scene:
    """Atoms near the triple point of their liquid, in units of the atoms."""
    spacing = 0.8442 ** (-1 / 3)
    size = (rows * spacing, DEPTH * rows * spacing, rows * spacing)
    places = pc.block((0.0, 0.0, 0.0), size, spacing)
    velocities = np.random.default_rng(6).normal(0.0, sqrt(1.4), places.shape)
    return pc.Scene(pc.Particles(places, velocities), pc.LennardJones(1.0, 1.0), pc.Periodic((0.0, 0.0, 0.0), size))


def pairs(rows: int) -> None:
    """Print how fast other pair forces are."""
    heap, atoms = grains(rows), liquid(rows)
    precisions: tuple[Precision, ...] = ("f64", "f32")
    contenders = []
    for precision in precisions:
        rolling = pc.Simulation(heap, precision=precision, threads=1)
        flying = pc.Simulation(atoms, dt=0.004, precision=precision, threads=1)
        for name, simulation in (("soft grains", rolling), ("Lennard-Jones, up to 2.5 σ", flying)):
            simulation.step(20)
            contenders.append(Contender(f"{name}, {precision}", simulation.step))
    race(contenders, 3)
    count = len(heap.bodies[0])
    title = f"Other pair forces, {count} particles, 3D [million particle-steps per CPU second]"
    table(title, ("", "figure"), [(one.name, 1e3 * rate(one, count)) for one in contenders])


def main(large: bool = False) -> dict[str, float]:
    """Print the tables; give the figures that have targets."""
    figures = compare(3, 50) | compare(2, 448)
    trade()
    pairs(50)
    if large:
        compare(3, 110)
    return figures


if __name__ == "__main__":
    main(large="--large" in sys.argv[1:])
