"""Scenery: boundaries, wires, the periodic domain and the centers of forces."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import cast

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.film.colors.themes import Theme
from physcore.film.looks import look_of
from physcore.film.looks.base import SHADING, Look, Scenery, disc
from physcore.film.looks.box import draw_edges
from physcore.film.page.tape import Tape
from physcore.film.shapes.box import corners
from physcore.scene.periodic import Periodic
from physcore.scene.scene import Scene


def landmarks(scene: Scene) -> Iterator[tuple[FloatArray, float]]:
    """Points (P, D) [m] with a margin, which belong in the picture: of boundaries, wires, the domain and the
    centers of forces.
    """
    for look in _looks(scene):
        yield from look.landmarks()
    if scene.periodic is not None and np.isfinite(scene.periodic.lengths).all():
        yield corners(np.array(scene.periodic.lower), np.array(scene.periodic.upper)), 0.0
    for center in _centers(scene):
        yield center[np.newaxis], 0.0


def grounds(scene: Scene, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Points (P, D) [m] of planes near an axis-aligned box, and of a domain that is open along some axes. A plane is
    near if its distance from the box is at most the size of the box.
    """
    points = [np.empty((0, scene.dimension)), *(look.ground(lower, upper) for look in _looks(scene))]
    if scene.periodic is not None:
        points.append(corners(*_finite(scene.periodic, lower, upper)))
    return np.concatenate(points)


def draw_backdrop(canvas: Canvas, scene: Scene, panel: tuple[int, int, int, int], theme: Theme) -> None:
    """Draw the backdrop immediately, slightly lighter in the middle, if there are boundaries, constraints, networks or
    fluids.

    Scenes of particles alone, such as stars, have a dark background.
    """
    solid = not all(body.is_loose for body in scene.bodies)
    if theme.backdrop is None or not (scene.boundaries or scene.constraints or solid):
        return
    left, top, right, bottom = panel
    center, radius = ((left + right) / 2, top + 0.4 * (bottom - top)), 0.6 * math.hypot(right - left, bottom - top)
    canvas.backdrop(center, radius, theme.backdrop, 1.0)


def draw_behind(canvas: Canvas, scene: Scene, view: View, theme: Theme, scenery: Scenery) -> None:
    """Draw immediately all scenery that is behind every moving object."""
    for look in _looks(scene):
        look.draw_behind(canvas, view, theme, scenery)
    _domain(canvas, view, theme, scenery, front=False)
    if view.flat:
        for center in _centers(scene):
            disc(canvas, view, center, 0.0, theme.edge, extra=3.0)
    canvas.paint()


def draw_among(canvas: Canvas, scene: Scene, view: View, theme: Theme, scenery: Scenery) -> None:
    """Queue the scenery that can hide moving objects and be hidden by them."""
    for look in _looks(scene):
        look.draw_among(canvas, view, theme)
    if not view.flat:
        _domain(canvas, view, theme, scenery, front=True)
        for center in _centers(scene):
            disc(canvas, view, center, 0.0, theme.edge, extra=3.0, shading=SHADING)


def record(tape: Tape, scene: Scene, view: View, theme: Theme, scenery: Scenery) -> None:
    """Put all scenery on the tape of a page."""
    canvas = cast("Canvas", tape)
    for look in _looks(scene):
        look.record(tape, view, theme, scenery)
    _domain(canvas, view, theme, scenery, front=False)
    for center in _centers(scene):
        disc(canvas, view, center, 0.0, theme.edge, extra=3.0, shading=0.0 if view.flat else SHADING)


def _looks(scene: Scene) -> Iterator[Look]:
    for item in (*scene.boundaries, *scene.constraints):
        yield look_of(item.resolved(scene.dimension))


def _centers(scene: Scene) -> Iterator[FloatArray]:
    for force in scene.forces:
        center = getattr(force, "center", None)
        if center is not None:
            yield np.asarray(center, dtype=float)


def _domain(canvas: Canvas, view: View, theme: Theme, scenery: Scenery, *, front: bool) -> None:
    """Draw a thin frame around the periodic domain; along an axis that is not periodic, lines without ends."""
    if scenery.domain is None:
        return
    lower, upper = _finite(scenery.domain, scenery.middle - scenery.size, scenery.middle + scenery.size)
    open_axes = np.flatnonzero(np.isinf(scenery.domain.lengths)).tolist()
    draw_edges(canvas, lower, upper, view, theme, front=front, thin=True, along=open_axes or None)


def _finite(domain: Periodic, lower: FloatArray, upper: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The corners of a domain; along axes that are not periodic, those of a box."""
    low, high = np.array(domain.lower), np.array(domain.upper)
    return np.where(np.isinf(low), lower, low), np.where(np.isinf(high), upper, high)
