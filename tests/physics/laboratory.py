"""What the physics tests share: scenes to draw from, states to compare, and the exact discrete solution of one mode."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
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

ALL = [kind() for kind in INTEGRATORS if kind.advances("Wave")]
SYMMETRIC = [pc.VelocityVerlet(), pc.McLachlan2(), pc.PEFRL(), pc.BlanesMoan4(), pc.BlanesMoan6()]
"""Time-reversible integrators."""
SYMPLECTIC = [pc.SemiImplicitEuler(), *SYMMETRIC]
"""Kicks and drifts: each keeps angular momentum exactly, because a kick along r does not change r × v."""


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


def modal_frequency(series: Array, dt: float) -> float:
    """ω of a mode from its coordinate q_n at every step of Verlet, which obeys q_(n+1) + q_(n−1) = (2 − ω² dt²) q_n.

    By least squares over the run. The catalogue compares 2/dt · asin(ω dt/2): the same statement, solved for ω.
    """
    q = series[1:-1]
    return float(np.sqrt(-(q @ (series[2:] - 2.0 * q + series[:-2])) / (q @ q)) / dt)


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


def mirrored(half: list[float], middle: float | None = None) -> list[float]:
    """A list that reads the same backwards."""
    return [*half, *([] if middle is None else [middle]), *half[::-1]]


def splitting(integrator: pc.Integrator) -> tuple[list[float], list[float]] | None:
    """Drifts and kicks in units of dt, in turn, as they were published; None for other methods."""
    match integrator:
        case pc.McLachlan2():
            lam = 0.1931833275037836
            return mirrored([lam], 1 - 2 * lam), [0.5, 0.5]
        case pc.PEFRL():
            xi, lam, chi = 0.1786178958448091, -0.2123418310626054, -0.06626458266981849
            return mirrored([xi, chi], 1 - 2 * (chi + xi)), mirrored([0.5 - lam, lam])
        case pc.BlanesMoan4():
            a, b = [0.245298957184271, 0.604872665711080], [0.0829844064174052, 0.396309801498368, -0.0390563049223486]
            return mirrored([*a, 0.5 - sum(a)]), mirrored(b, 1 - 2 * sum(b))
        case pc.BlanesMoan6():
            a = [0.123229775946271, 0.290553797799558, -0.127049212625417, -0.246331761062075, 0.357208872795928]
            b = [0.0414649985182624, 0.198128671918067, -0.0400061921041533, 0.0752539843015807, -0.0115113874206879]
            return mirrored(a, 1 - 2 * sum(a)), mirrored([*b, 0.5 - sum(b)])
    return None


DORMAND_PRINCE = [
    [1 / 5],
    [3 / 40, 9 / 40],
    [44 / 45, -56 / 15, 32 / 9],
    [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
    [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
    [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
]
"""The rows of the pair's table from the second on; the last one is that of the step."""


def weighted(weights: Sequence[float], slopes: Sequence[tuple[Any, Any]]) -> list[Any]:
    """The weighted sum of the slopes of x, and that of v."""
    return [sum(w * s for w, s in zip(weights, which, strict=True)) for which in zip(*slopes, strict=True)]


def amplification(integrator: pc.Integrator, step: float | Array, ratio: float = 0.0) -> Array:
    """The matrices that steps of x'' = −x − 2ξx' apply to (x, v, a), built from the published formulas alone.

    a is the last acceleration that was evaluated, from which velocities are predicted (Verlet and the splittings).
    """

    def acceleration(x: Any, v: Any) -> Any:
        return -x - 2.0 * ratio * v

    def advance(x: Any, v: Any, a: Any) -> tuple[Any, Any, Any]:
        match integrator:
            case pc.ExplicitEuler():
                return x + step * v, v + step * acceleration(x, v), 0.0
            case pc.SemiImplicitEuler():
                v = v + step * acceleration(x, v)
                return x + step * v, v, 0.0
            case pc.VelocityVerlet():
                x = x + step * v + step**2 / 2 * a
                new = acceleration(x, v + step * a)
                return x, v + step / 2 * (a + new), new
            case pc.RungeKutta4():
                sums, slope = [x, v], (0.0, 0.0)
                for part, weight in ((0.0, 1 / 6), (0.5, 1 / 3), (0.5, 1 / 3), (1.0, 1 / 6)):
                    at = x + part * step * slope[0], v + part * step * slope[1]
                    slope = at[1], acceleration(*at)
                    sums = [total + weight * step * rise for total, rise in zip(sums, slope, strict=True)]
                return sums[0], sums[1], 0.0
            case pc.BogackiShampine3():
                slopes: list[tuple[Any, Any]] = [(v, acceleration(x, v))]
                for part in (1 / 2, 3 / 4):
                    at = [start + part * step * rise for start, rise in zip((x, v), slopes[-1], strict=True)]
                    slopes.append((at[1], acceleration(*at)))
                rises = weighted((2 / 9, 1 / 3, 4 / 9), slopes)
                return x + step * rises[0], v + step * rises[1], 0.0
            case pc.DormandPrince5():
                slopes = [(v, acceleration(x, v))]
                for row in DORMAND_PRINCE[:-1]:
                    at = [start + step * rise for start, rise in zip((x, v), weighted(row, slopes), strict=True)]
                    slopes.append((at[1], acceleration(*at)))
                rises = weighted(DORMAND_PRINCE[-1], slopes)
                return x + step * rises[0], v + step * rises[1], 0.0
        coefficients = splitting(integrator)
        assert coefficients, f"describe one step of {integrator} here, so that its limit is tested"
        drifts, kicks = coefficients
        predicted = [kick / 2 for kick in kicks]
        if len(kicks) > len(drifts):
            # The kick that ends a step and the one that begins the next are one, with the step's end in its middle.
            v, kicks, predicted = v + kicks[0] * step * a, kicks[1:], [*predicted[1:-1], kicks[-1]]
        for drift, kick, part in zip(drifts, kicks, predicted, strict=False):
            x = x + drift * step * v
            a = acceleration(x, v + part * step * a)
            v = v + kick * step * a
        return x + sum(drifts[len(kicks) :]) * step * v, v, a

    images = [np.broadcast_arrays(step, *advance(*unit))[1:] for unit in np.eye(3)]
    return np.moveaxis(np.array(images), (0, 1), (-1, -2))


@cache
def growing_step(integrator: pc.Integrator, ratio: float) -> float:
    """The ω dt that grows fastest, of those up to 1 % above the limit. A resonance may be narrower than that."""
    steps = largest_step(integrator, ratio) * (1.0 + 1e-6 * np.arange(1, 10_001))
    radii = np.abs(np.linalg.eigvals(amplification(integrator, steps, ratio))).max(axis=-1)
    return float(steps[radii.argmax()])


@cache
def largest_step(integrator: pc.Integrator, ratio: float = 0.0) -> float:
    """The largest ω dt such that no eigenvalue of a smaller step is outside of the unit circle.

    Found by walking up in steps of 1.6e-4, a fifth of the narrowest resonance, and bisecting. Where a symplectic
    method's pair of eigenvalues leaves the circle, at 1 + δ of the limit, |g| − 1 = O(√δ), at the narrowest resonance
    0.05 √δ: the margin of 1e-6 shifts the limit by less than 1e-9. That of the others is proportional to δ, 4.9e-4 δ
    for DormandPrince5, and their eigenvalues do not meet there: a margin of 1e-10 shifts it by less than 2.1e-7.
    Explicit Euler grows by 1 + (ω dt)²/2 without damping; its limit is 0, and the margin gives 1.4e-5.
    """
    margin = 1e-6 if integrator.symplectic or ratio > 0.0 else 1e-10

    def unstable(steps: Array) -> Array:
        radii: Array = np.abs(np.linalg.eigvals(amplification(integrator, steps, ratio))).max(axis=-1)
        return radii > 1.0 + margin

    stride = 1.6e-4 / max(1.0, ratio)
    low = 0.0
    while not (found := np.flatnonzero(unstable(walk := low + stride * np.arange(1, 2001)))).size:
        low = float(walk[-1])
    high = float(walk[found[0]])
    low = high - stride
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if unstable(np.array(middle)) else (middle, high)
    return low


@cache
def wide_edge(integrator: pc.Integrator) -> float:
    """The ω dt from which all steps up to a tenth larger are unstable without damping: the limit, but for methods with
    resonances before it that are too narrow to blow anything up.
    """
    steps = 1e-3 * np.arange(1, 15_000)
    stable = np.abs(np.linalg.eigvals(amplification(integrator, steps))).max(axis=-1) < 1.0 + 1e-6
    edges = np.flatnonzero(stable[:-1] & ~stable[1:])
    return next(float(steps[edge]) for edge in edges if not stable[edge + 1 : round(1.1 * edge)].any())


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
