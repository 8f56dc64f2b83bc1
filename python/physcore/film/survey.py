"""One look at a whole film before it is drawn: where things go, and how far the scales of color reach."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from physcore.checks import FloatArray
from physcore.film.scenery import grounds, landmarks
from physcore.film.sources import Moment, Source
from physcore.film.styles import Painter

SAMPLES = 8
"""How many frames are kept to choose the palette from."""


@dataclass(eq=False)
class Bounds:
    """The smallest box, along some axes, that holds what has been added."""

    axes: FloatArray
    """Unit vectors, shape (D, D); in 2D those of the scene."""
    lower: FloatArray = field(init=False)
    upper: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        self.lower, self.upper = np.full(len(self.axes), np.inf), np.full(len(self.axes), -np.inf)

    def add(self, points: FloatArray, margin: float = 0.0) -> None:
        """Take points (N, D) [m] into account, with so much around each."""
        if len(points) == 0:
            return
        local = self.axes @ points.T  # one row per axis: NumPy finds the least of a row several times faster
        lower, upper = local.min(axis=1), local.max(axis=1)
        if not (np.isfinite(lower).all() and np.isfinite(upper).all()):
            self.add(points[np.isfinite(points).all(axis=1)], margin)
            return
        self.lower = np.minimum(self.lower, lower - margin)
        self.upper = np.maximum(self.upper, upper + margin)

    def merge(self, other: Bounds) -> None:
        """Take another box along the same axes into account."""
        self.lower, self.upper = np.minimum(self.lower, other.lower), np.maximum(self.upper, other.upper)

    def settle(self) -> None:
        """Become a point where nothing was added."""
        if not np.isfinite(self.lower).all():
            self.lower = self.upper = np.zeros(len(self.axes))


@dataclass(eq=False)
class Survey:
    """What was seen of one source."""

    bounds: list[Bounds]
    """One for each set of axes."""
    samples: list[Moment]
    """Some moments from the whole film, at most SAMPLES."""


def survey(
    source: Source, painters: Sequence[Painter], axes: Sequence[FloatArray], tick: Callable[[int], None]
) -> Survey:
    """Look at every moment of a source.

    Args:
        source: what to look at.
        painters: told of every moment.
        axes: the directions along which to find how far things go; the first must be those of the scene itself.
        tick: told how many moments have been seen.
    """
    radius = max(float(body.radius.max(initial=0.0)) for body in source.scene.bodies)
    margin = max([radius, *(painter.margin for painter in painters)])
    bounds = [Bounds(each) for each in axes]
    kept = set(np.linspace(0, source.count - 1, SAMPLES).round().astype(int).tolist())
    samples = []
    for index, moment in enumerate(source.moments()):
        for painter in painters:
            painter.observe(moment)
        for box in bounds:
            box.add(moment.positions, margin)
        if index in kept:
            samples.append(moment)
        tick(index + 1)
    for box in bounds:
        for points, around in landmarks(source.scene):
            box.add(points, around)
        box.settle()
    ground = grounds(source.scene, bounds[0].lower, bounds[0].upper)
    for box in bounds:
        box.add(ground)
    return Survey(bounds, samples)
