"""The first pass over a film, before it is drawn: bounds of the motion, and ranges of the color scales."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from physcore.checks import FloatArray
from physcore.film.camera.track import Follow, masses_of, middle, places_in, smooth
from physcore.film.scenery import grounds, landmarks
from physcore.film.styles import Painter
from physcore.film.styles.base import drawn_dimension
from physcore.scene.scene import Scene
from physcore.simulation.energy import Energy
from physcore.simulation.sources import Source, SourceFrame

NEAR = 0.5
"""Largest distance of visible scenery from the motion, over the extent of the motion. Farther scenery is cut off, so
that the picture shows the motion, not its surroundings.
"""
SAMPLES = 8
"""Number of frames kept to choose the palette from."""


@dataclass(eq=False)
class Bounds:
    """Bounding boxes along given axes: one for a whole film, or one for each frame."""

    axes: FloatArray
    """Unit vectors of each box, shape (K, D, D)."""
    lower: FloatArray = field(init=False)
    upper: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        self.lower, self.upper = np.full(self.axes.shape[:2], np.inf), np.full(self.axes.shape[:2], -np.inf)

    def add(self, points: FloatArray, margin: float = 0.0, frame: int = 0) -> None:
        """Extend the box of a frame by points (N, D) [m], with a margin around each."""
        if len(points) == 0:
            return
        index = min(frame, len(self.axes) - 1)
        local = self.axes[index] @ points.T  # one row per axis: a minimum along rows is several times faster
        lower, upper = local.min(axis=1), local.max(axis=1)
        if not (np.isfinite(lower).all() and np.isfinite(upper).all()):
            self.add(points[np.isfinite(points).all(axis=1)], margin, frame)
            return
        self.lower[index] = np.minimum(self.lower[index], lower - margin)
        self.upper[index] = np.maximum(self.upper[index], upper + margin)

    def add_to_all(self, points: FloatArray, margin: float = 0.0) -> None:
        """Extend the boxes of all frames by points at rest."""
        for frame in range(len(self.axes)):
            self.add(points, margin, frame)

    def add_near(self, points: FloatArray, margin: float = 0.0, near: float = NEAR) -> None:
        """Extend the boxes of all frames by points at rest, as far as they are near the present box. If a box is empty
        or a single point, all of them count. `near` is a fraction of the extent of all.
        """
        lower, upper = self.lower.copy(), self.upper.copy()
        self.add_to_all(points, margin)
        reach = near * (upper - lower).max(axis=1, keepdims=True)
        moved = np.isfinite(reach[:, 0]) & (reach[:, 0] > 0.0)
        self.lower[moved] = np.maximum(self.lower, np.minimum(lower - reach, lower))[moved]
        self.upper[moved] = np.minimum(self.upper, np.maximum(upper + reach, upper))[moved]

    def merge(self, other: Bounds) -> None:
        """Extend the boxes by other boxes along the same axes."""
        self.lower, self.upper = np.minimum(self.lower, other.lower), np.maximum(self.upper, other.upper)

    def settle(self) -> None:
        """Replace empty boxes by a point at the origin."""
        empty = ~np.isfinite(self.lower).all(axis=1)
        self.lower[empty] = self.upper[empty] = 0.0


class FollowedPath:
    """The path of followed particles, and their bounds around it."""

    def __init__(self, follow: Follow, scene: Scene, axes: FloatArray, count: int) -> None:
        self._chosen, self._domain = follow.rows(scene), scene.periodic
        self._mass = masses_of(scene)[self._chosen]
        self._last: FloatArray | None = None
        self.centers = np.zeros((count, scene.dimension))
        """The center of mass at each frame [m], continuous across faces of the periodic domain."""
        self.around = Bounds(axes)
        """Bounds of the followed particles relative to the center of mass, along the axes of each frame."""

    def add(self, positions: FloatArray, margin: float, frame: int) -> None:
        """Add a frame, given the positions of all particles and rigid bodies."""
        points = positions[self._chosen]
        if len(points) == 0:
            return
        if self._last is None:
            center = middle(points, self._mass, self._domain)
        else:
            shift = points - self._last
            step = shift if self._domain is None else self._domain.nearest(shift)
            center = self.centers[frame - 1] + self._mass @ step / self._mass.sum()
        self._last, self.centers[frame] = points, center
        offsets = points - center
        self.around.add(offsets if self._domain is None else self._domain.nearest(offsets), margin, frame)

    def smoothed(self, width: float) -> FloatArray:
        """The path of the camera (F, D) [m], smoothed by a Gaussian of `width` frames. Afterwards `around` is relative
        to this path.
        """
        path = smooth(self.centers, width)
        off = np.einsum("kij,kj->ki", self.around.axes, self.centers - path)
        self.around.lower += off
        self.around.upper += off
        return path


@dataclass(eq=False)
class FirstPass:
    """Bounds, samples and energies of one source."""

    whole: Bounds
    """Bounds along the axes of the scene, over the whole film."""
    boxes: list[Bounds]
    """Bounds for each candidate camera."""
    path: FollowedPath | None
    """The path of the followed particles."""
    samples: list[tuple[int, SourceFrame]]
    """At most SAMPLES frames with their numbers, spread over the whole film."""
    energies: list[Energy]
    """The energy budget at each frame, as far as it was recorded."""
    dt: float | None
    """The last time step [s]."""


def first_pass(
    source: Source,
    frames: Iterable[SourceFrame],
    count: int,
    painters: Sequence[Painter],
    axes: Sequence[FloatArray],
    follow: Follow | None,
    tick: Callable[[int], None],
    near: float = NEAR,
) -> FirstPass:
    """Collect bounds, samples and energies from every frame of a source.

    Args:
        source: the source.
        frames: its frames from the start; the last one stays for the rest of the film.
        count: the number of frames of the film.
        painters: the painters, which receive every frame.
        axes: the axes of each candidate camera, shape (K, D, D) with K = 1 or one for each frame.
        follow: the bodies to follow.
        tick: called with the number of frames done.
        near: largest distance of visible scenery from the motion, over the extent of the motion.
    """
    scene = source.scene
    radius = max((float(body.radius.max(initial=0.0)) for body in scene.bodies), default=0.0)
    margin = max([radius, *(painter.margin for painter in painters)])
    whole, boxes = Bounds(np.eye(drawn_dimension(scene))[np.newaxis]), [Bounds(each) for each in axes]
    path = None if follow is None else FollowedPath(follow, scene, axes[0], count)
    kept = set(np.linspace(0, source.count - 1, SAMPLES).round().astype(int).tolist())
    found = FirstPass(whole, boxes, path, [], [], None)

    reach = max([margin, *(painter.reach for painter in painters)])

    def place(frame: SourceFrame, index: int) -> None:
        for box in boxes:
            for points in (frame.positions, *others):
                box.add(points, margin, index)
        if path is not None:
            path.add(places_in(frame.fields), reach, index)

    index, others = -1, list[FloatArray]()
    for index, frame in enumerate(frames):
        for painter in painters:
            painter.observe(frame)
        others = [points for painter in painters if (points := painter.places(frame)) is not None]
        for points in (frame.positions, *others):
            whole.add(points, margin)
        place(frame, index)
        if index in kept:
            found.samples.append((index, frame))
        if frame.energy is not None:
            found.energies.append(frame.energy)
        found.dt = frame.dt
        tick(index + 1)
    if path is not None or any(len(box.axes) > 1 for box in boxes):
        for later in range(index + 1, count):
            place(frame, later)
    for box in (whole, *boxes):
        for painter in painters:
            if painter.landmarks is not None:
                box.add_to_all(painter.landmarks)
    still = [each for painter in painters for each in painter.scenery]
    _add_scenery(scene, whole, boxes, near, still)
    return found


def _add_scenery(
    scene: Scene,
    whole: Bounds,
    boxes: Sequence[Bounds],
    near: float,
    still: Sequence[tuple[FloatArray, float]],
) -> None:
    """Extend the bounds by boundaries and other scenery, and by what painters draw at rest."""
    for box in (whole, *boxes):
        for points, around in (*landmarks(scene), *still):
            box.add_near(points, around, near)
        box.settle()
    ground = grounds(scene, whole.lower[0], whole.upper[0])
    for box in (whole, *boxes):
        box.add_to_all(ground)
