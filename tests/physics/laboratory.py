"""What the physics tests share: scenes to draw from, states to compare, and the exact discrete solution of one mode."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

import physcore as pc
from physcore.integrators import INTEGRATORS

LONG = os.environ.get("PHYSCORE_TESTS") == "long"
"""Whether the full number of steps is asked for."""

EPSILON = float(np.finfo(np.float64).eps)

Array = NDArray[np.float64]

ALL = [kind() for kind in INTEGRATORS]
SYMPLECTIC = [pc.SemiImplicitEuler(), pc.VelocityVerlet(), pc.PEFRL()]
"""Kicks and drifts: each keeps angular momentum exactly, because a kick along r does not change r × v."""
SYMMETRIC = [pc.VelocityVerlet(), pc.PEFRL()]
"""Time-reversible integrators."""


def name(value: object) -> str:
    """For the ids of parametrized tests."""
    return type(value).__name__


@contextmanager
def unwarned() -> Iterator[None]:
    """For runs that mean to be unstable."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pc.StabilityWarning)
        yield


def simulation(scene: pc.Scene, integrator: pc.Integrator, dt: float, **numerics: Any) -> pc.Simulation:
    """On one thread, and without a warning where dt is above the limit."""
    with unwarned():
        return pc.Simulation(scene, integrator, dt, threads=1, **numerics)


def state(run: pc.Simulation) -> Array:
    """Positions and velocities in one array (2, N, D)."""
    return np.stack([run.positions, run.velocities])


def line(x: Array, dimension: int = 2) -> Array:
    """Points along the x axis."""
    return np.pad(np.asarray(x, dtype=float)[:, None], ((0, 0), (0, dimension - 1)))


def membrane(
    spacing: float, rest: float, stiffness: float, mass: float, sides: int, heights: Array | float = 0.0, **more: Any
) -> pc.SpringNetwork:
    """A square net of structural springs in the plane z = 0, held along its edges; listed row by row."""
    grid = np.arange(sides * sides).reshape(sides, sides)
    rows, columns = np.divmod(grid.ravel(), sides)
    positions = np.stack([spacing * columns, spacing * rows, np.zeros(grid.size)], axis=1)
    positions[:, 2] = np.broadcast_to(heights, (sides, sides)).ravel()
    pairs = np.concatenate(
        [
            np.stack([grid[:, :-1].ravel(), grid[:, 1:].ravel()], axis=1),
            np.stack([grid[:-1].ravel(), grid[1:].ravel()], axis=1),
        ]
    )
    edge = (rows % (sides - 1) == 0) | (columns % (sides - 1) == 0)
    return pc.SpringNetwork(positions, pairs, stiffness, rest_length=rest, mass=mass, fixed=edge, **more)


@dataclass(frozen=True)
class Network:
    """The numbers of a random spring network, free to be transformed before it becomes a body."""

    positions: Array
    velocities: Array
    pairs: NDArray[np.int64]
    stiffness: Array
    rest_length: Array
    mass: Array
    damping: Array

    def body(self, **changes: Any) -> pc.SpringNetwork:
        values = {**vars(self), **changes}
        return pc.SpringNetwork(**values)

    def scene(self, **changes: Any) -> pc.Scene:
        return pc.Scene(self.body(**changes))


def network(seed: int, dimension: int, count: int, damping: float = 0.0, motion: float = 0.1) -> Network:
    """Particles on a jittered lattice of spacing 1, each joined to its neighbors, with stiffness from 1 to 100 N/m,
    masses from 0.5 to 2 kg, springs strained by up to 5 %, and velocities of `motion` m/s per axis.
    """
    rng = np.random.default_rng(seed)
    side = int(np.ceil(count ** (1.0 / dimension)))
    lattice = np.stack(np.meshgrid(*[np.arange(side)] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    positions = lattice[:count] + rng.uniform(-0.15, 0.15, (count, dimension))
    distances = np.linalg.norm(positions[:, None] - positions[None], axis=2)
    nearby = np.argwhere(np.triu(distances < 1.8, 1))
    chain = np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)
    pairs = np.unique(np.concatenate([nearby, chain]), axis=0).astype(np.int64)
    springs = len(pairs)
    lengths = distances[pairs[:, 0], pairs[:, 1]]
    return Network(
        positions=positions,
        velocities=motion * rng.standard_normal((count, dimension)),
        pairs=pairs,
        stiffness=10.0 ** rng.uniform(0.0, 2.0, springs),
        rest_length=lengths * rng.uniform(0.95, 1.05, springs),
        mass=rng.uniform(0.5, 2.0, count),
        damping=damping * rng.uniform(0.0, 1.0, springs),
    )


@st.composite
def networks(draw: st.DrawFn, damping: float = 0.0) -> Network:
    """Random networks of 2 to 12 particles in 2D and 3D."""
    seed, dimension = draw(st.integers(0, 2**32 - 1)), draw(st.sampled_from([2, 3]))
    return network(seed, dimension, draw(st.integers(2, 12)), damping)


@dataclass(frozen=True)
class Orbit:
    """One particle in a central field."""

    exponent: float
    softening: float
    positions: Array
    velocities: Array

    def scene(self, **changes: Any) -> pc.Scene:
        values = {**vars(self), **changes}
        center = np.zeros(values["positions"].shape[1])
        return pc.Scene(
            pc.Particles(values["positions"], values["velocities"]),
            pc.CentralForce(tuple(center), 1.0, values["exponent"], values["softening"]),
        )


@st.composite
def orbits(draw: st.DrawFn) -> Orbit:
    """Bound orbits around a center that pulls with 1 N at 1 m: launched at 1 m, aslant, at 0.6 to 1 m/s.

    In the field r^−2 a launch at right angles with 0.6 m/s has the eccentricity 1 − 0.6² = 0.64, and one with 1 m/s has
    the longest period, 2π s.
    """
    dimension = draw(st.sampled_from([2, 3]))
    speed, slant = draw(st.floats(0.6, 1.0)), draw(st.floats(-0.5, 0.5))
    velocity = speed * np.array([np.sin(slant), np.cos(slant), 0.0])[:dimension]
    return Orbit(
        exponent=draw(st.sampled_from([-2.0, -1.5, -1.0, 0.0, 1.0, 2.0, 3.0])),
        softening=draw(st.sampled_from([0.0, 0.1])),
        positions=np.eye(dimension)[:1],
        velocities=velocity[None],
    )


def amplification(integrator: pc.Integrator, step: float, ratio: float = 0.0) -> Array:
    """The matrix that one step of x'' = −x − 2ξx' applies to (x, v, a), built from the published formulas alone.

    a is the last acceleration that was evaluated, from which velocities are predicted (Verlet, PEFRL).
    """

    def advance(x: float, v: float, a: float) -> tuple[float, float, float]:
        def acceleration(x: float, v: float) -> float:
            return -x - 2.0 * ratio * v

        match integrator:
            case pc.ExplicitEuler():
                return x + step * v, v + step * acceleration(x, v), 0.0
            case pc.SemiImplicitEuler():
                v += step * acceleration(x, v)
                return x + step * v, v, 0.0
            case pc.VelocityVerlet():
                x += step * v + step**2 / 2 * a
                new = acceleration(x, v + step * a)
                return x, v + step / 2 * (a + new), new
            case pc.RungeKutta4():
                matrix = np.array([[0.0, 1.0], [-1.0, -2.0 * ratio]]) * step
                powers = [np.linalg.matrix_power(matrix, n) / factor for n, factor in enumerate((1, 1, 2, 6, 24))]
                x, v = np.sum(powers, axis=0) @ (x, v)
                return x, v, 0.0
            case pc.PEFRL():
                xi, lam, chi = 0.1786178958448091, -0.2123418310626054, -0.06626458266981849
                drifts, kicks = (xi, chi, 1 - 2 * (chi + xi), chi), (0.5 - lam, lam, lam, 0.5 - lam)
                for drift, kick in zip(drifts, kicks, strict=True):
                    x += drift * step * v
                    a = acceleration(x, v + kick * step / 2 * a)
                    v += kick * step * a
                return x + xi * step * v, v, a
        raise AssertionError(f"describe one step of {integrator} here, so that its limit is tested")

    return np.array([advance(*unit) for unit in np.eye(3)]).T


def largest_step(integrator: pc.Integrator, ratio: float = 0.0) -> float:
    """The largest ω dt such that no eigenvalue of a smaller step is outside of the unit circle.

    Found by walking up in steps of 0.1 % and bisecting. Where a symplectic method's pair of eigenvalues leaves the
    circle, at 1 + δ of the limit, |g| − 1 = O(√δ): the margin of 1e-6 shifts the limit by 1e-12. Explicit Euler grows
    by 1 + (ω dt)²/2 without damping; its limit is 0, and the margin gives 1.4e-3.
    """

    def unstable(step: float) -> bool:
        return bool(np.abs(np.linalg.eigvals(amplification(integrator, step, ratio))).max() > 1.0 + 1e-6)

    reach = 8.0 / max(1.0, ratio)
    low, high = 0.0, 1e-3 * reach
    while not unstable(high):
        low, high = high, high + 1e-3 * reach
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return low


def discrete_stiffness(integrator: pc.Integrator, step: float) -> float:
    """κ of the energy (v² + κ x²)/2 that a symmetric method keeps exactly on x'' = −x.

    Its step maps (x, v) by ((p, q), (r, p)) and so keeps v² − (r/q) x².
    """
    matrix = amplification(integrator, step)
    matrix = matrix[:2, :2] - np.outer(matrix[:2, 2], [1.0, 0.0])  # a = −x at the start of a step
    return -float(matrix[1, 0] / matrix[0, 1])


def discrete_energy_error(integrator: pc.Integrator, step: float) -> float:
    """By how much the energy of a mode swings at most under a symmetric method, relative to its potential energy:
    what should be kept, v² + x², differs from what is, v² + κ x², by (1 − κ) x².
    """
    return abs(1.0 - discrete_stiffness(integrator, step))
