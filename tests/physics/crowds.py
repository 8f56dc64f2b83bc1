"""Crowds of particles with pair forces, and the same forces in NumPy: every pair, one formula after the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physcore as pc
from physics.laboratory import Array

LAWS: dict[str, pc.Force] = {
    "linear": pc.SoftSpheres(100.0),
    "Hertz": pc.SoftSpheres(100.0, exponent=1.5),
    "damped": pc.SoftSpheres(100.0, 2.0),
    "rubbing": pc.SoftSpheres(100.0, 2.0, 0.4, 1.0),
    "rubbing Hertz": pc.SoftSpheres(100.0, 2.0, 0.4, 1.0, exponent=1.5),
    "atoms": pc.LennardJones(1.0, 0.9),
}
CONSERVATIVE = ("linear", "Hertz", "atoms")
SIDE = 6
"""Particles along an axis, 1 m apart, so that a periodic domain is more than twice as wide as any force reaches."""


@dataclass(frozen=True)
class Crowd:
    """The numbers of a scene of particles with one pair force."""

    positions: Array
    velocities: Array
    radius: Array
    mass: Array
    law: pc.Force
    domain: pc.Periodic | None

    @property
    def extent(self) -> float:
        """The largest number that a position or a displacement has [m]."""
        return float(np.abs(self.positions).max()) + SIDE

    def body(self, **changes: Any) -> pc.Particles:
        values = {name: getattr(self, name) for name in ("positions", "velocities", "radius", "mass")}
        return pc.Particles(**{**values, **changes})

    def scene(self, **changes: Any) -> pc.Scene:
        return pc.Scene(self.body(**changes), self.law, *([] if self.domain is None else [self.domain]))

    def changed(self, **changes: Any) -> Crowd:
        return replace(self, **changes)


def domain(kind: str, dimension: int, side: float = float(SIDE)) -> pc.Periodic | None:
    """None, periodic along all axes, or along the first."""
    if kind == "open":
        return None
    axes = np.arange(dimension) < (dimension if kind == "closed" else 1)
    return pc.Periodic(np.where(axes, 0.0, -np.inf), np.where(axes, side, np.inf))


def crowd(law: str, dimension: int, kind: str = "open", seed: int = 0) -> Crowd:
    """Particles on a jittered lattice, of radii 0.4 to 0.6 m, masses 0.5 to 2 kg and speeds up to 1 m/s per axis."""
    rng = np.random.default_rng(seed)
    sites = pc.block((0.0,) * dimension, (float(SIDE),) * dimension, 1.0)
    return Crowd(
        positions=sites + rng.uniform(-0.1, 0.1, sites.shape),
        velocities=rng.uniform(-1.0, 1.0, sites.shape),
        radius=rng.uniform(0.4, 0.6, len(sites)),
        mass=rng.uniform(0.5, 2.0, len(sites)),
        law=LAWS[law],
        domain=domain(kind, dimension),
    )


@dataclass(frozen=True)
class Pairs:
    """All pairs i < j that are within reach."""

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    normal: Array
    """From the second to the first, of length one, (P, D)."""
    distance: Array
    reach: Array
    velocity: Array
    """Of the first relative to the second, (P, D)."""


def pairs(crowd: Crowd, beyond: float = 0.0) -> Pairs:
    """Those that are within reach, and perhaps somewhat beyond it [m]."""
    first, second = np.triu_indices(len(crowd.positions), 1)
    apart = crowd.positions[first] - crowd.positions[second]
    if crowd.domain is not None:
        lengths = crowd.domain.lengths
        apart -= np.where(np.isinf(lengths), 0.0, lengths) * np.rint(apart / lengths)
    distance = np.linalg.norm(apart, axis=1)
    law = crowd.law
    reach = crowd.radius[first] + crowd.radius[second]
    if isinstance(law, pc.LennardJones):
        reach = np.full(len(first), law.cutoff)
    near = distance < reach + beyond
    velocity = crowd.velocities[first] - crowd.velocities[second]
    return Pairs(
        first[near], second[near], (apart / distance[:, None])[near], distance[near], reach[near], velocity[near]
    )


def central(law: pc.Force, reach: Array) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    """Force and potential of a pair as functions of its distance, positive repels."""
    if isinstance(law, pc.LennardJones):
        e, s, c = law.epsilon, law.sigma, law.cutoff

        def u(r: Array | float) -> Any:
            return 4.0 * e * ((s / r) ** 12 - (s / r) ** 6)

        def f(r: Array | float) -> Any:
            return 24.0 * e * (2.0 * (s / r) ** 12 - (s / r) ** 6) / r

        return lambda r: f(r) - f(c), lambda r: u(r) - u(c) + (r - c) * f(c)
    assert isinstance(law, pc.SoftSpheres)
    k, p = law.stiffness, law.exponent

    def overlap(r: Array) -> Array:
        return np.maximum(reach - r, 0.0)

    return lambda r: k * overlap(r) ** p, lambda r: k * overlap(r) ** (p + 1.0) / (p + 1.0)


def pair_forces(crowd: Crowd, near: Pairs) -> Array:
    """On the first of each pair (P, D)."""
    law = crowd.law
    elastic = central(law, near.reach)[0](near.distance)
    if isinstance(law, pc.LennardJones):
        return elastic[:, None] * near.normal
    assert isinstance(law, pc.SoftSpheres)
    parting = np.einsum("pd,pd->p", near.velocity, near.normal)
    push = np.maximum(elastic - law.damping * parting, 0.0)
    sliding = near.velocity - parting[:, None] * near.normal
    speed = np.linalg.norm(sliding, axis=1)
    rub = np.minimum(law.tangential_damping * speed, law.friction * push)
    return push[:, None] * near.normal - (rub / np.where(speed > 0.0, speed, 1.0))[:, None] * sliding


def forces(crowd: Crowd) -> Array:
    """On every particle [N], (N, D)."""
    near = pairs(crowd)
    each = pair_forces(crowd, near)
    result = np.zeros_like(crowd.positions)
    np.add.at(result, near.first, each)
    np.add.at(result, near.second, -each)
    return result


def potential(crowd: Crowd) -> float:
    """[J]."""
    near = pairs(crowd)
    return float(central(crowd.law, near.reach)[1](near.distance).sum())


def rounding(crowd: Crowd, epsilon: float) -> Array:
    """By how much rounding may change the force on each particle [N], (N,).

    The displacement of a pair is the difference of numbers of the size of the extent L: off by ε L. That changes its
    force by its stiffness |F′| along the pair and F/r across it, and what depends on the relative velocity v by v/r of
    the damping. The sum over n particles adds ε n Σ |F|. All of this a few times over: 8.
    """
    near = pairs(crowd)
    force = central(crowd.law, near.reach)[0]
    h = 1e-6
    size = np.linalg.norm(pair_forces(crowd, near), axis=1)
    change = np.abs(force(near.distance + h) - force(near.distance - h)) / (2.0 * h) + size / near.distance
    if isinstance(crowd.law, pc.SoftSpheres):
        loss = crowd.law.damping + (crowd.law.tangential_damping or 0.0)
        change += loss * np.linalg.norm(near.velocity, axis=1) / near.distance
    counts, total = np.zeros(len(crowd.positions)), np.zeros(len(crowd.positions))
    for end in (near.first, near.second):
        np.add.at(counts, end, 1.0)
    for end in (near.first, near.second):
        np.add.at(total, end, counts[end] * size + change * crowd.extent)
    return 8.0 * epsilon * total
