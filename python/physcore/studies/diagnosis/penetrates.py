"""Symptom "penetrates": bodies with radii overlap, or a ball is inside a mesh."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import cast

import numpy as np

from physcore.checks import BoolArray, FloatArray, IntArray
from physcore.forces import SoftSpheres
from physcore.scene.bodies import Body
from physcore.scene.items import Force
from physcore.scene.overlaps import close_pairs
from physcore.scene.scene import Scene
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding

DEEPEST = 0.25
"""Largest overlap, relative to the smaller radius: 2 pixels on a ball of 16 pixels. Contacts of soft spheres overlap by
about a hundredth.
"""
PAIRS = 300_000
"""Number of particles examined in all frames together, which takes about a second."""
FEWEST_FRAMES, MOST_FRAMES = 4, 60
LARGE = 4.0
"""Ratio to the median above which radii are examined one by one, up to `MOST_LARGE` of them. Cells as large as a planet
would contain all dust in a single cell.
"""
MOST_LARGE = 64


@dataclass(frozen=True)
class Overlap:
    """Two overlapping particles."""

    depth: float
    """Overlap relative to the smaller radius."""
    one: int
    other: int


def penetrates(case: Case) -> Iterator[Finding]:
    """Find the largest overlap in any frame, of particles with radii and of meshes with balls."""
    positions = case.positions
    if positions is None or not np.isfinite(positions).all():
        return
    frames = _frames(positions, case.recording is not None)
    worst = _largest_overlap(case.scene, positions[frames], positions[0])
    if worst is not None and worst.depth > DEEPEST:
        yield _of_particles(case.scene, worst)
    yield from _meshes(case.scene, positions[frames])


def _frames(positions: FloatArray, recorded: bool) -> IntArray:
    """The indices of the frames to examine."""
    count, particles = positions.shape[:2]
    most = int(np.clip(PAIRS // max(particles, 1), FEWEST_FRAMES, MOST_FRAMES)) if recorded else 1
    return np.unique(np.linspace(0, count - 1, min(most, count)).astype(np.int64))


def _of_particles(scene: Scene, worst: Overlap) -> Finding:
    """The finding for an overlap of particles."""
    one, other = (_owner(scene, particle) for particle in (worst.one, worst.other))
    names = f"{scene.path(one)} and {scene.path(other)}" if one != other else f"particles of {scene.path(one)}"
    figure = f"overlap by {worst.depth:.2g} of the smaller radius"
    spheres = [cast("SoftSpheres", force) for force in scene.forces if force.is_contact]
    acting = [force for force in spheres if scene.members(force)[[worst.one, worst.other]].all()]
    if not acting:
        cause = f"{names} {figure}, and no force keeps them apart"
        return Finding("penetrates", cause, "add pc.SoftSpheres(stiffness, damping) to the scene", worst.depth)
    stiffness = f"{acting[0].stiffness:g}{scene.units.suffix('N/m')}"
    cause = f"{names} {figure}: SoftSpheres of {stiffness} are too soft for what presses them together"
    # The energy of a linear contact is ∝ k δ²: a tenth of the overlap needs a hundred times the stiffness.
    enough = acting[0].stiffness * (worst.depth / (0.4 * DEEPEST)) ** 2
    return Finding("penetrates", cause, f"take a stiffness of about {enough:.2g}", worst.depth)


def _owner(scene: Scene, particle: int) -> int:
    """The index of a particle's body."""
    ends = np.cumsum(_counts(scene))
    return int(np.searchsorted(ends, particle, side="right"))


def _counts(scene: Scene) -> list[int]:
    """The number of particles of each body."""
    return [body.elements.get("particles", 0) for body in scene.bodies]


def _largest_overlap(scene: Scene, frames: FloatArray, start: FloatArray) -> Overlap | None:
    """The deepest overlap of all pairs that were not placed so intentionally and are free to separate."""
    radius = scene.gather("radius")
    if (radius > 0.0).sum() < 2:
        return None
    owner = np.repeat(np.arange(len(scene.bodies)), _counts(scene))
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
    """Pairs that are allowed to overlap.

    Allowed are pairs of fixed particles, pairs connected by a spring, and pairs of bodies with LennardJones or
    CustomForce. Pairs within a body are allowed if they overlap at the start. All pairs of a body without contacts are
    allowed if it is a network, or if some of its particles overlap at the start. The same is true of two networks
    without contacts that overlap at the start.
    """

    def __init__(self, scene: Scene, radius: FloatArray, owner: IntArray, start: FloatArray) -> None:
        self._radius, self._owner, self._start = radius, owner, start
        self._fixed = scene.gather("fixed")
        pairs = [np.sort(network.pairs + scene.slice(network).start, axis=1) for network in scene.networks]
        self._count = len(radius)
        keys = [row[:, 0] * self._count + row[:, 1] for row in pairs]
        self._springs = np.concatenate(keys or [np.empty(0, np.int64)])
        kept = _together(scene, [force for force in scene.forces if not (force.is_shown or force.is_contact)])
        network = np.array([body.network is not None for body in scene.bodies])
        free = np.diag(network)
        for one, other, distance in _touching(start, radius):
            placed = distance < radius[one] + radius[other]
            first, second = owner[one[placed]], owner[other[placed]]
            swarm = (first == second) | (network[first] & network[second])
            free[first[swarm], second[swarm]] = free[second[swarm], first[swarm]] = True
        self._kept = kept | (free & ~_together(scene, [force for force in scene.forces if force.is_contact]))

    def __call__(self, one: IntArray, other: IntArray) -> BoolArray:
        """A mask of the allowed pairs."""
        first, second = self._owner[one], self._owner[other]
        apart = np.linalg.norm(self._start[one] - self._start[other], axis=1)
        placed = (first == second) & (apart < self._radius[one] + self._radius[other])
        connected = np.isin(np.minimum(one, other) * self._count + np.maximum(one, other), self._springs)
        excused: BoolArray = (self._fixed[one] & self._fixed[other]) | connected | placed | self._kept[first, second]
        return excused


def _together(scene: Scene, forces: list[Force]) -> BoolArray:
    """Mask of the pairs of bodies between which one of these forces acts, shape (B, B)."""
    targets = [[scene.index(body) for body in scene.targets(force)] for force in forces]
    acting = np.zeros((len(scene.bodies), len(scene.bodies)), dtype=bool)
    for bodies in targets:
        acting[np.ix_(bodies, bodies)] = True
    return acting


def _meshes(scene: Scene, frames: FloatArray) -> Iterator[Finding]:
    """Find springs and faces of networks whose middle is inside a sphere or a ball while their corners are outside."""
    for body in scene.networks:
        if not len(body.faces):
            continue
        part = scene.slice(body)
        for name, centers, radii in _balls(scene, body, frames):
            depth = max(
                _depth(mesh[body.pairs].mean(axis=1), center, radii)
                for mesh, center in zip(frames[:, part], centers, strict=True)
            )
            if depth > DEEPEST:
                width, meter = float(body.rest_length.min()), scene.units.suffix("m")
                cause = (
                    f"{name} reaches through {scene.path(body)} by {depth:.2g} of its radius: the mesh, of springs of "
                    f"{width:.2g}{meter} and more, is coarse beside it"
                )
                spacing = f"{0.5 * float(radii.min()):.2g}{meter}"
                cure = f"take a finer mesh, of a spacing of {spacing}, or a RigidBody as the ball, which meets faces"
                yield Finding("penetrates", cause, cure, depth)


def _balls(scene: Scene, mesh: Body, frames: FloatArray) -> Iterator[tuple[str, FloatArray, FloatArray]]:
    """The balls that a mesh may be too coarse for: name, centers in each frame (F, B, D), and radii (B,) [m]."""
    for place, boundary in enumerate(scene.boundaries):
        if boundary.ball is not None and mesh in scene.targets(boundary):
            middle, radius = boundary.ball
            center = np.broadcast_to(np.array(middle), (len(frames), 1, scene.dimension))
            yield f"boundaries[{place}] ({type(boundary).__name__})", center, np.array([radius])
    for index, body in enumerate(scene.bodies):
        alone = body.is_loose and len(body) <= MOST_LARGE
        if alone and (body.radius > 0.0).all() and scene.dimension == 3:
            yield scene.path(index), frames[:, scene.slice(index)], body.radius


def _depth(points: FloatArray, centers: FloatArray, radii: FloatArray) -> float:
    """The largest depth of points inside a ball, relative to its radius; negative if all points are outside."""
    distances = np.linalg.norm(points[:, np.newaxis] - centers, axis=2)
    return float((1.0 - distances / radii).max())
