"""Penetrates: bodies with radii are inside each other, or a ball is inside a mesh."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from physcore.boundaries import Sphere
from physcore.checks import BoolArray, FloatArray, IntArray
from physcore.forces import CustomForce, LennardJones, SoftSpheres
from physcore.scene.bodies import Body, SpringNetwork
from physcore.scene.fluid import Fluid
from physcore.scene.items import Force
from physcore.scene.overlaps import close_pairs
from physcore.scene.scene import Scene
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding

DEEPEST = 0.25
"""Overlap over the smaller radius above which it is seen: 2 pixels of a ball that is 16 pixels large. Contacts of soft
spheres are meant to overlap by a hundredth or so."""
PAIRS = 300_000
"""Particles of all frames together that are looked at, so that it takes a second or so."""
FEWEST_FRAMES, MOST_FRAMES = 4, 60
LARGE = 4.0
"""Radii above so many medians are looked at one by one, at most `MOST_LARGE` of them: cells as large as a planet would
have all dust in one."""
MOST_LARGE = 64


@dataclass(frozen=True)
class Overlap:
    """Two particles that are inside each other."""

    depth: float
    """Overlap over the smaller radius."""
    one: int
    other: int


def penetrates(case: Case) -> Iterator[Finding]:
    """The largest overlap of any frame: of particles with radii, and of meshes with balls."""
    positions = case.positions
    if positions is None or not np.isfinite(positions).all():
        return
    frames = _frames(positions, case.recording is not None)
    worst = _largest_overlap(case.scene, positions[frames], positions[0])
    if worst is not None and worst.depth > DEEPEST:
        yield _of_particles(case.scene, worst)
    yield from _meshes(case.scene, positions[frames])


def _frames(positions: FloatArray, recorded: bool) -> IntArray:
    """The frames to look at."""
    count, particles = positions.shape[:2]
    most = int(np.clip(PAIRS // max(particles, 1), FEWEST_FRAMES, MOST_FRAMES)) if recorded else 1
    return np.unique(np.linspace(0, count - 1, min(most, count)).astype(np.int64))


def _of_particles(scene: Scene, worst: Overlap) -> Finding:
    """What to say of an overlap."""
    one, other = (_owner(scene, particle) for particle in (worst.one, worst.other))
    names = f"{scene.path(one)} and {scene.path(other)}" if one != other else f"particles of {scene.path(one)}"
    figure = f"overlap by {worst.depth:.2g} of the smaller radius"
    spheres = [force for force in scene.forces if isinstance(force, SoftSpheres)]
    acting = [force for force in spheres if {one, other} <= {scene.index(body) for body in scene.targets(force)}]
    if not acting:
        cause = f"{names} {figure}, and no force keeps them apart"
        return Finding("penetrates", cause, "add pc.SoftSpheres(stiffness, damping) to the scene", worst.depth)
    cause = f"{names} {figure}: SoftSpheres of {acting[0].stiffness:g} N/m are too soft for what presses them together"
    # Energy goes with δ² k of a linear contact: a tenth of the overlap needs a hundred times the stiffness.
    enough = acting[0].stiffness * (worst.depth / (0.4 * DEEPEST)) ** 2
    return Finding("penetrates", cause, f"take a stiffness of about {enough:.2g}", worst.depth)


def _owner(scene: Scene, particle: int) -> int:
    """The index of a particle's body."""
    ends = np.cumsum([len(body) for body in scene.bodies])
    return int(np.searchsorted(ends, particle, side="right"))


def _largest_overlap(scene: Scene, frames: FloatArray, start: FloatArray) -> Overlap | None:
    """The deepest of all pairs that were not placed within each other on purpose, and have room to part."""
    radius = np.concatenate([body.radius for body in scene.bodies])
    if (radius > 0.0).sum() < 2:
        return None
    owner = np.repeat(np.arange(len(scene.bodies)), [len(body) for body in scene.bodies])
    excused = _Excused(scene, radius, owner, start)
    worst: Overlap | None = None
    for positions in frames:
        for one, other, distance in _touching(positions, radius):
            depth = (radius[one] + radius[other] - distance) / np.minimum(radius[one], radius[other])
            deep = np.flatnonzero((depth > DEEPEST) & (depth > (worst.depth if worst else 0.0)))
            deep = deep[~excused(one[deep], other[deep])]
            if len(deep):
                best = deep[np.argmax(depth[deep])]
                worst = Overlap(float(depth[best]), int(one[best]), int(other[best]))
    return worst


def _touching(positions: FloatArray, radius: FloatArray) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
    """Pairs of particles with radii that may overlap, with their distances [m]."""
    having = np.flatnonzero(radius > 0.0)
    large = having[radius[having] > LARGE * np.median(radius[having])]
    if len(large) > MOST_LARGE:
        large = large[:0]
    for particle in large:
        others = np.setdiff1d(having, large[large <= particle])
        yield np.full(len(others), particle), others, np.linalg.norm(positions[others] - positions[particle], axis=1)
    small = np.setdiff1d(having, large)
    if len(small) > 1:
        for one, other, distance in close_pairs(positions[small], 2.0 * float(radius[small].max())):
            yield small[one], small[other], distance


class _Excused:
    """Which pairs may overlap: fixed ones; those that springs connect; those that other forces keep at a distance of
    their own; within a body those that were placed so, and all of it where that has no contacts and is a network,
    or a swarm some of which were placed so; and those of networks without contacts that were placed within each other.
    """

    def __init__(self, scene: Scene, radius: FloatArray, owner: IntArray, start: FloatArray) -> None:
        self._radius, self._owner, self._start = radius, owner, start
        self._fixed = np.concatenate([body.fixed for body in scene.bodies])
        starts = np.cumsum([0, *(len(body) for body in scene.bodies)])
        pairs = [
            np.sort(body.pairs + starts[index], axis=1)
            for index, body in enumerate(scene.bodies)
            if isinstance(body, SpringNetwork)
        ]
        self._count = len(radius)
        keys = [row[:, 0] * self._count + row[:, 1] for row in pairs]
        self._springs = np.concatenate(keys or [np.empty(0, np.int64)])
        kept = _together(scene, (LennardJones, CustomForce))
        network = np.array([isinstance(body, SpringNetwork) for body in scene.bodies])
        free = np.diag(network)
        for one, other, distance in _touching(start, radius):
            placed = distance < radius[one] + radius[other]
            first, second = owner[one[placed]], owner[other[placed]]
            swarm = (first == second) | (network[first] & network[second])
            free[first[swarm], second[swarm]] = free[second[swarm], first[swarm]] = True
        self._kept = kept | (free & ~_together(scene, (SoftSpheres,)))

    def __call__(self, one: IntArray, other: IntArray) -> BoolArray:
        """Whether each pair may."""
        first, second = self._owner[one], self._owner[other]
        apart = np.linalg.norm(self._start[one] - self._start[other], axis=1)
        placed = (first == second) & (apart < self._radius[one] + self._radius[other])
        connected = np.isin(np.minimum(one, other) * self._count + np.maximum(one, other), self._springs)
        excused: BoolArray = (self._fixed[one] & self._fixed[other]) | connected | placed | self._kept[first, second]
        return excused


def _together(scene: Scene, kinds: tuple[type[Force], ...]) -> BoolArray:
    """Between which bodies a force of some kinds acts, shape (B, B)."""
    targets = [
        [scene.index(body) for body in scene.targets(force)] for force in scene.forces if isinstance(force, kinds)
    ]
    acting = np.zeros((len(scene.bodies), len(scene.bodies)), dtype=bool)
    for bodies in targets:
        acting[np.ix_(bodies, bodies)] = True
    return acting


def _meshes(scene: Scene, frames: FloatArray) -> Iterator[Finding]:
    """Springs and faces of networks whose middle is inside a sphere or a ball: their corners are kept outside."""
    for index, body in enumerate(scene.bodies):
        if not isinstance(body, SpringNetwork) or not len(body.faces):
            continue
        part = scene.slice(index)
        for name, centers, radii in _balls(scene, body, frames):
            depth = max(
                _depth(mesh[body.pairs].mean(axis=1), center, radii)
                for mesh, center in zip(frames[:, part], centers, strict=True)
            )
            if depth > DEEPEST:
                width = float(body.rest_length.min())
                cause = (
                    f"{name} reaches through {scene.path(index)} by {depth:.2g} of its radius: the mesh, of springs of "
                    f"{width:.2g} m and more, is coarse beside it"
                )
                cure = f"take a finer mesh, of a spacing of {0.5 * float(radii.min()):.2g} m, or a larger ball"
                yield Finding("penetrates", cause, cure, depth)


def _balls(scene: Scene, mesh: Body, frames: FloatArray) -> Iterator[tuple[str, FloatArray, FloatArray]]:
    """What a mesh may be too coarse for: its name, its centers in each frame (F, B, D), and radii (B,) [m]."""
    for place, boundary in enumerate(scene.boundaries):
        if isinstance(boundary, Sphere) and not boundary.inside and mesh in scene.targets(boundary):
            center = np.broadcast_to(np.array(boundary.center), (len(frames), 1, scene.dimension))
            yield f"boundaries[{place}] (Sphere)", center, np.array([boundary.radius])
    for index, body in enumerate(scene.bodies):
        alone = not isinstance(body, (SpringNetwork, Fluid)) and len(body) <= MOST_LARGE
        if alone and (body.radius > 0.0).all() and scene.dimension == 3:
            yield scene.path(index), frames[:, scene.slice(index)], body.radius


def _depth(points: FloatArray, centers: FloatArray, radii: FloatArray) -> float:
    """How deep the deepest point is inside a ball, over the ball's radius; below 0 where all are outside."""
    distances = np.linalg.norm(points[:, np.newaxis] - centers, axis=2)
    return float((1.0 - distances / radii).max())
