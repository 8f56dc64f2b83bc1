"""Vector fields to draw: the local mean velocity, the acceleration of a test particle, or a function."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, Protocol, TypeAlias

import numpy as np

from physcore.checks import FloatArray, IntArray, called, is_word, regular, shown
from physcore.errors import PhyscoreError, SceneError
from physcore.film.camera.view import View
from physcore.film.shapes.creases import sums as row_sums
from physcore.film.styles.base import Part, places
from physcore.scene.bodies import Particles
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation
from physcore.simulation.sources import Source, SourceFrame

FieldFunction: TypeAlias = Callable[[float, FloatArray], FloatArray]
"""Function `f(time, positions)` that gives vectors (N, D) for positions (N, D), as in CustomForce."""
Of: TypeAlias = Literal["velocities", "acceleration"] | FieldFunction

LAYERS = 7
"""Number of sample points along the longest side of the view in 3D."""
MARGIN = 2
"""Number of empty squares around those with particles."""
"""Forces that are not fields in space: forces between particles, and functions that know their particles."""
UNITS = {"velocities": ("speed", "m/s"), "acceleration": ("acceleration", "m/s²")}


class Field(Protocol):
    """A vector field that can be sampled in the view."""

    def samples(self, frame: SourceFrame, view: View, spacing: float) -> tuple[FloatArray, FloatArray]:
        """Sample points (M, D) about `spacing` pixels apart, and the vectors (M, D) there."""

    def known(self, frame: SourceFrame) -> FloatArray:
        """The vectors (N, D) at the particles."""

    def around(self, frame: SourceFrame, view: View, spacing: float) -> Callable[[FloatArray], FloatArray]:
        """A function for the vectors at points in the plane (M, 2), with a resolution of `spacing` [pixels]; NaN where
        there are no particles.
        """


def field(of: object, source: Source, parts: list[Part], path: str) -> Field:
    """The field requested by a style.

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
    """Check that a value is a valid field.

    Raises:
        SceneError: the value is not valid.
    """
    if not (is_word(of, "velocities") or is_word(of, "acceleration") or callable(of)):
        raise SceneError(
            f"{path}: must be 'velocities', 'acceleration' or a function(time, positions), got {shown(of)}"
        )


@dataclass(frozen=True, eq=False)
class Motion:
    """The mean velocity of the particles in each square of the picture."""

    where: slice | IntArray
    """The particles that contribute."""

    def samples(self, frame: SourceFrame, view: View, spacing: float) -> tuple[FloatArray, FloatArray]:
        """The mean position and velocity of the particles in each nonempty square."""
        positions, velocities = frame.positions[self.where], frame.fields["velocities"][self.where]
        squares = np.floor(view.project(positions)[0] / np.float32(spacing)).astype(np.int64)
        squares -= squares.min(axis=0, initial=0)
        keys = squares[:, 1] * (squares[:, 0].max(initial=0) + 1) + squares[:, 0]
        _, index, counts = np.unique(keys, return_inverse=True, return_counts=True)
        means = [row_sums(index, values, len(counts)) / counts[:, np.newaxis] for values in (positions, velocities)]
        return means[0], means[1]

    def known(self, frame: SourceFrame) -> FloatArray:
        """The velocities of the particles."""
        velocities: FloatArray = frame.fields["velocities"][self.where]
        return velocities

    def around(self, frame: SourceFrame, view: View, spacing: float) -> Callable[[FloatArray], FloatArray]:
        """Bilinear interpolation between the means of squares; an empty square has the mean of its neighbors."""
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
    """A vector field given by a function of time and position."""

    function: FieldFunction

    def samples(self, frame: SourceFrame, view: View, spacing: float) -> tuple[FloatArray, FloatArray]:
        """The function on a square pattern in 2D, or on a cubic one through the view in 3D."""
        places = pattern(view, spacing)
        return places, self.at(frame.time, places)

    def known(self, frame: SourceFrame) -> FloatArray:
        """The function at the particles."""
        return self.at(frame.time, frame.positions)

    def around(self, frame: SourceFrame, view: View, spacing: float) -> Callable[[FloatArray], FloatArray]:
        """The function itself."""
        del view, spacing
        return lambda places: self.at(frame.time, places)

    def at(self, time: float, places: FloatArray) -> FloatArray:
        """The vectors (M, D) at points (M, D).

        Raises:
            SceneError: the function fails, or its result is not such an array.
        """
        vectors = regular(called(self.function, "of", time, places), "of")
        if vectors.shape != places.shape or vectors.dtype.kind not in "biuf":
            raise SceneError(
                f"of: the function must give vectors of shape {places.shape}, got {vectors.dtype} of {vectors.shape}"
            )
        return vectors.astype(np.float64)


def pattern(view: View, spacing: float) -> FloatArray:
    """Sample points (M, D) [m]: a square pattern over the picture in 2D, a cubic one in 3D."""
    if view.flat:
        number, step = math.ceil(max(view.middle) / spacing), spacing / view.scale
        return view.center + step * (np.indices((2 * number + 1,) * 2).reshape(2, -1).T - number)
    middle = view.axes.T @ view.center
    steps = np.indices((LAYERS,) * 3).reshape(3, -1).T / (0.5 * (LAYERS - 1)) - 1.0
    return middle + view.reach * steps


def _widened(counts: FloatArray, sums: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Fill empty squares of a pattern (rows, columns) with the sums of their four neighbors."""
    padded, around = np.pad(counts, 1), np.pad(sums, ((1, 1), (1, 1), (0, 0)))
    near = padded[:-2, 1:-1] + padded[2:, 1:-1] + padded[1:-1, :-2] + padded[1:-1, 2:]
    there = around[:-2, 1:-1] + around[2:, 1:-1] + around[1:-1, :-2] + around[1:-1, 2:]
    empty = counts == 0.0
    return np.where(empty, near, counts), np.where(empty[..., np.newaxis], there, sums)


def _acceleration(scene: Scene) -> FieldFunction:
    """The acceleration of a test particle at rest by the forces of a scene [m/s²]."""
    forces = [replace(force, on=None) for force in scene.forces if force.is_shown]
    anchor = Particles(np.zeros((1, scene.dimension)), fixed=True)
    simulation = Simulation(Scene(anchor, *forces), dt=1.0)

    def felt(time: float, places: FloatArray) -> FloatArray:
        del time
        try:
            return simulation.acceleration(places)
        except PhyscoreError:
            return np.zeros_like(places)  # a point so near to a center of force that the force overflows

    return felt
