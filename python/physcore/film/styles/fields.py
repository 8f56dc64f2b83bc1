"""Vector fields to draw: what moves on average around a place, what a particle would feel there, or a function."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, Protocol, TypeAlias

import numpy as np

from physcore.checks import FloatArray, IntArray, called, is_word, regular, shown
from physcore.errors import PhyscoreError, SceneError
from physcore.film.camera.view import View
from physcore.film.styles.base import Part, places
from physcore.film.styles.base import sums as row_sums
from physcore.forces import CustomForce, LennardJones, SoftSpheres
from physcore.scene.bodies import Particles
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation
from physcore.simulation.sources import Source, SourceFrame

FieldFunction: TypeAlias = Callable[[float, FloatArray], FloatArray]
"""`function(time, positions)` gives vectors for positions (N, D), as those of a CustomForce do."""
Of: TypeAlias = Literal["velocities", "acceleration"] | FieldFunction

LAYERS = 7
"""In 3D a field is shown at so many places along the longest side of what is seen."""
MARGIN = 2
"""Empty squares around those that hold particles."""
INTERNAL = (CustomForce, LennardJones, SoftSpheres)
"""Forces between particles, and those whose function knows its particles: they are no field in space."""
UNITS = {"velocities": ("speed", "m/s"), "acceleration": ("acceleration", "m/s²")}


class Field(Protocol):
    """Something that has a vector at every place where it can be shown."""

    def samples(self, frame: SourceFrame, view: View, spacing: float) -> tuple[FloatArray, FloatArray]:
        """Places (M, D) about `spacing` pixels apart, and the vectors (M, D) there."""

    def known(self, frame: SourceFrame) -> FloatArray:
        """Vectors (N, D) where the particles are."""

    def around(self, frame: SourceFrame, view: View, spacing: float) -> Callable[[FloatArray], FloatArray]:
        """The vectors at any places in the plane (M, 2), resolved to `spacing` [pixels]; NaN where nothing is."""


def field(of: object, source: Source, parts: list[Part], path: str) -> Field:
    """The field that a style asks for.

    Raises:
        SceneError: there is no such field, or it needs velocities that were not recorded.
    """
    check_field(of, path)
    if is_word(of, "velocities"):
        if not source.has("velocities"):
            raise SceneError(f"{path}: 'velocities' were not recorded; record them, or give a function")
        return Motion(places(parts))
    return Space(of if callable(of) else _acceleration(source.scene))


def check_field(of: object, path: str) -> None:
    """Refuse what is no field.

    Raises:
        SceneError: it is none.
    """
    if not (is_word(of, "velocities") or is_word(of, "acceleration") or callable(of)):
        raise SceneError(
            f"{path}: must be 'velocities', 'acceleration' or a function(time, positions), got {shown(of)}"
        )


@dataclass(frozen=True, eq=False)
class Motion:
    """The mean velocity of the particles in each square of the picture."""

    where: slice | IntArray
    """Which particles count."""

    def samples(self, frame: SourceFrame, view: View, spacing: float) -> tuple[FloatArray, FloatArray]:
        """The mean position and velocity of the particles in each square that holds any."""
        positions, velocities = frame.positions[self.where], frame.fields["velocities"][self.where]
        squares = np.floor(view.project(positions)[0] / np.float32(spacing)).astype(np.int64)
        squares -= squares.min(axis=0, initial=0)
        keys = squares[:, 1] * (squares[:, 0].max(initial=0) + 1) + squares[:, 0]
        _, index, counts = np.unique(keys, return_inverse=True, return_counts=True)
        means = [row_sums(index, values, len(counts)) / counts[:, np.newaxis] for values in (positions, velocities)]
        return means[0], means[1]

    def known(self, frame: SourceFrame) -> FloatArray:
        """The velocities."""
        velocities: FloatArray = frame.fields["velocities"][self.where]
        return velocities

    def around(self, frame: SourceFrame, view: View, spacing: float) -> Callable[[FloatArray], FloatArray]:
        """Bilinear between the means of squares; an empty square has the mean of its neighbors."""
        size = spacing / view.scale
        positions = frame.positions[self.where]
        lowest = np.floor(positions.min(axis=0) / size) - MARGIN
        squares = (positions / size - lowest).astype(np.int64)
        columns, rows = (int(most) + 1 + MARGIN for most in squares.max(axis=0))
        index = squares[:, 1] * columns + squares[:, 0]
        counts = np.bincount(index, minlength=rows * columns).astype(float)
        sums = row_sums(index, self.known(frame), rows * columns)
        counts, sums = _widened(counts.reshape(rows, columns), sums.reshape(rows, columns, 2))
        with np.errstate(invalid="ignore"):
            means = sums / counts[..., np.newaxis]

        def at(places: FloatArray) -> FloatArray:
            local = np.clip(places / size - lowest - 0.5, 0.0, np.array([columns, rows]) - 1.001)
            corner = local.astype(np.int64)
            (u, v), (x, y) = (local - corner).T[..., np.newaxis], corner.T
            below = (1.0 - u) * means[y, x] + u * means[y, x + 1]
            above = (1.0 - u) * means[y + 1, x] + u * means[y + 1, x + 1]
            inside: FloatArray = (1.0 - v) * below + v * above
            return inside

        return at


@dataclass(frozen=True, eq=False)
class Space:
    """A function of time and place."""

    function: FieldFunction

    def samples(self, frame: SourceFrame, view: View, spacing: float) -> tuple[FloatArray, FloatArray]:
        """The function on a square pattern in 2D, and on a cubic one through what is seen in 3D."""
        places = pattern(view, spacing)
        return places, self.at(frame.time, places)

    def known(self, frame: SourceFrame) -> FloatArray:
        """The function where the particles are."""
        return self.at(frame.time, frame.positions)

    def around(self, frame: SourceFrame, view: View, spacing: float) -> Callable[[FloatArray], FloatArray]:
        """The function itself."""
        del view, spacing
        return lambda places: self.at(frame.time, places)

    def at(self, time: float, places: FloatArray) -> FloatArray:
        """The vectors (M, D) at some places.

        Raises:
            SceneError: the function fails, or gives something else.
        """
        vectors = regular(called(self.function, "of", time, places), "of")
        if vectors.shape != places.shape or vectors.dtype.kind not in "biuf":
            raise SceneError(
                f"of: the function must give vectors of shape {places.shape}, got {vectors.dtype} of {vectors.shape}"
            )
        return vectors.astype(np.float64)


def pattern(view: View, spacing: float) -> FloatArray:
    """Places (M, D) [m]: a square pattern over all of a 2D picture, a cubic one in 3D."""
    if view.flat:
        number, step = math.ceil(max(view.middle) / spacing), spacing / view.scale
        return view.center + step * (np.indices((2 * number + 1,) * 2).reshape(2, -1).T - number)
    middle = view.axes.T @ view.center
    steps = np.indices((LAYERS,) * 3).reshape(3, -1).T / (0.5 * (LAYERS - 1)) - 1.0
    return middle + view.reach * steps


def _widened(counts: FloatArray, sums: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Empty squares of a pattern (rows, columns) get what their four neighbors have."""
    padded, around = np.pad(counts, 1), np.pad(sums, ((1, 1), (1, 1), (0, 0)))
    near = padded[:-2, 1:-1] + padded[2:, 1:-1] + padded[1:-1, :-2] + padded[1:-1, 2:]
    there = around[:-2, 1:-1] + around[2:, 1:-1] + around[1:-1, :-2] + around[1:-1, 2:]
    empty = counts == 0.0
    return np.where(empty, near, counts), np.where(empty[..., np.newaxis], there, sums)


def _acceleration(scene: Scene) -> FieldFunction:
    """Acceleration of one kilogram at rest by a scene's forces [m/s²]."""
    forces = [replace(force, on=None) for force in scene.forces if not isinstance(force, INTERNAL)]
    anchor = Particles(np.zeros((1, scene.dimension)), fixed=True)
    simulation = Simulation(Scene(anchor, *forces), dt=1.0)

    def felt(time: float, places: FloatArray) -> FloatArray:
        del time
        try:
            return simulation.acceleration(places)
        except PhyscoreError:
            return np.zeros_like(places)  # a place so near a center that the force has no end

    return felt
