"""Common parts of the looks of boundaries: the placement of scenery, and drawing functions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias, cast

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.themes import Color, Theme, mixed
from physcore.film.page.tape import Tape
from physcore.scene.periodic import Periodic

SHADING = 0.9
GRID = 10
"""Number of squares across the ground."""
WIDE = 1.5
"""Radius of the lit ground, over its size."""
LINES = 0.35
"""Opacity of the lines of the grid on the ground."""
WALL = 0.3
"""Opacity of the walls of a box."""
LARGEST = 1e30
"""Largest radius of a disc [m], within the range of single precision."""
_Three: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Scenery:
    """Placement of scenery that is infinite or has no position of its own."""

    domain: Periodic | None
    """The periodic domain, drawn as a frame; None without one."""
    middle: FloatArray
    """The middle of the ground in 3D, the middle of the view in 2D [m], shape (D,)."""
    size: float
    """Half the width of the ground [m]."""


class Look:
    """How a boundary or a constraint is drawn. To add a look: a file in `looks`, and a line in `LOOKS`."""

    def landmarks(self) -> Iterator[tuple[FloatArray, float]]:
        """Points (P, D) [m] that belong in the picture, each with a margin [m]."""
        return iter(())

    def ground(self, lower: FloatArray, upper: FloatArray) -> FloatArray:
        """Points (P, D) [m] that belong in the picture if they are near an axis-aligned box."""
        del upper
        return np.empty((0, len(lower)))

    def draw_behind(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """Draw immediately all parts that are behind every moving object."""

    def draw_among(self, canvas: Canvas, view: View, theme: Theme) -> None:
        """Queue the parts that can hide moving objects and be hidden by them."""

    def record(self, tape: Tape, view: View, theme: Theme, scenery: Scenery) -> None:
        """Put all parts on the tape of a page. A look whose drawing depends on the direction of view has a way of its
        own.
        """
        canvas = cast("Canvas", tape)
        self.draw_behind(canvas, view, theme, scenery)
        self.draw_among(canvas, view, theme)


def ground(
    canvas: Canvas, view: View, theme: Theme, normal: FloatArray, center: FloatArray, size: float, pitch: float
) -> None:
    """Draw level ground immediately, lit around `center` [m], with a grid of the given pitch [m]. The ground receives
    shadows.
    """
    grid = (mixed(theme.surface, theme.edge, 0.5), pitch, LINES)
    canvas.ground(*_plane(view, normal, center), WIDE * size, theme.surface, _three(view.axes @ _level(normal)), grid)


def wall(canvas: Canvas, view: View, theme: Theme, normal: FloatArray, corners: FloatArray) -> None:
    """Draw a translucent wall immediately between corners (4, 3) [m] in order. The wall receives shadows, and is
    invisible from behind.
    """
    pixels = view.project(corners)[0].tolist()
    part = ([(x, y) for x, y in pixels], WALL)
    place, first = _plane(view, normal, corners.mean(axis=0)), _three(view.axes @ _level(normal))
    canvas.ground(*place, 1.0, theme.surface, first, None, part)


def _plane(view: View, normal: FloatArray, center: FloatArray) -> tuple[_Three, _Three]:
    """A normal and a point of a plane, in the coordinates of the camera."""
    return _three(view.axes @ normal), _three(view.axes @ center - view.center)


def _level(normal: FloatArray) -> FloatArray:
    """A unit vector in the plane with a given normal."""
    helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
    return _unit(np.cross(np.cross(normal, helper), normal))


def _unit(vector: FloatArray) -> FloatArray:
    unit: FloatArray = vector / np.linalg.norm(vector)
    return unit


def _three(vector: FloatArray) -> _Three:
    first, second, third = vector.tolist()
    return first, second, third


def disc(
    canvas: Canvas,
    view: View,
    center: FloatArray,
    radius: float,
    color: Color,
    extra: float = 0.0,
    shading: float = 0.0,
) -> None:
    """Queue a disc with a radius [m] and `extra` pixels more."""
    pixels, depth, scale = view.project(center[np.newaxis])
    length = np.float32(min(radius, LARGEST))
    canvas.discs(pixels, scale * length + np.float32(extra), _ink(color, 1), depth, shading)


def lines(
    canvas: Canvas, ends: PixelArray, color: Color, width: float, alpha: int = 255, depths: PixelArray | None = None
) -> None:
    """Queue lines between pixels (M, 2, 2), each at one of the depths (M,)."""
    count = len(ends)
    flat = np.ascontiguousarray(ends).reshape(count, 4)
    both = None if depths is None else np.stack([depths, depths], axis=1)
    canvas.lines(flat, np.full(count, width, dtype=np.float32), _ink(color, count, alpha), both)


def _ink(color: Color, count: int, alpha: int = 255) -> np.ndarray:
    return np.tile(np.array([*color, alpha], dtype=np.uint8), (count, 1))
