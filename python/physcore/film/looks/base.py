"""What all looks of boundaries share: where scenery is, and the marks that it is drawn with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.themes import Color, Theme, mixed
from physcore.scene.periodic import Periodic

SHADING = 0.9
GRID = 10
"""Squares across the ground."""
WIDE = 1.5
"""How far the ground is lit, over its size."""
LINES = 0.35
"""The opacity of the lines of its grid."""
WALL = 0.3
"""The opacity of the walls of a box."""
_Three: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Scenery:
    """The place of scenery that has no end or no place of its own."""

    domain: Periodic | None
    """The periodic domain, drawn as a frame."""
    middle: FloatArray
    """The middle of the ground in 3D, the middle of the view in 2D [m], shape (D,)."""
    size: float
    """Half the width of the ground [m]."""


class Look:
    """How a boundary is drawn. To add one: a file in `looks`, and a line in `LOOKS`."""

    def landmarks(self) -> Iterator[tuple[FloatArray, float]]:
        """Points (P, D) [m], and a distance around them, that belong in the picture."""
        return iter(())

    def ground(self, lower: FloatArray, upper: FloatArray) -> FloatArray:
        """Points (P, D) [m] that belong in the picture beside a box along the axes, if it is near."""
        del upper
        return np.empty((0, len(lower)))

    def draw_behind(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """Draw at once what is behind everything that moves."""

    def draw_among(self, canvas: Canvas, view: View, theme: Theme) -> None:
        """Add to the painting what hides things that move, and is hidden by them."""


def corners(lower: FloatArray, upper: FloatArray) -> FloatArray:
    """The 2^D corners of a box along the axes; the bits of a corner's number say which are upper."""
    upper_in = np.array(list(np.ndindex(*(2,) * len(lower))), dtype=bool)
    return np.where(upper_in, upper, lower)


def ground(
    canvas: Canvas, view: View, theme: Theme, normal: FloatArray, center: FloatArray, size: float, pitch: float
) -> None:
    """Draw level ground at once, lit around a place [m], with a grid of such a pitch [m], and take shadows on it."""
    grid = (mixed(theme.surface, theme.edge, 0.5), pitch, LINES)
    canvas.ground(*_plane(view, normal, center), WIDE * size, theme.surface, _three(view.axes @ _level(normal)), grid)


def wall(canvas: Canvas, view: View, theme: Theme, normal: FloatArray, corners: FloatArray) -> None:
    """Draw a faint wall at once between corners (4, 3) [m] in order, and take shadows on it; no effect from behind."""
    pixels = view.project(corners)[0].tolist()
    part = ([(x, y) for x, y in pixels], WALL)
    place, first = _plane(view, normal, corners.mean(axis=0)), _three(view.axes @ _level(normal))
    canvas.ground(*place, 1.0, theme.surface, first, None, part)


def _plane(view: View, normal: FloatArray, center: FloatArray) -> tuple[_Three, _Three]:
    """A normal and a place, as the camera has them."""
    return _three(view.axes @ normal), _three(view.axes @ center - view.center)


def _level(normal: FloatArray) -> FloatArray:
    """A unit vector in a plane."""
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
    """Add a disc of a radius [m] and some more pixels."""
    pixels, depth, scale = view.project(center[np.newaxis])
    canvas.discs(pixels, scale * np.float32(radius) + np.float32(extra), _ink(color, 1), depth, shading)


def lines(
    canvas: Canvas, ends: PixelArray, color: Color, width: float, alpha: int = 255, depths: PixelArray | None = None
) -> None:
    """Add lines between pixels (M, 2, 2), each at one of the depths (M,)."""
    count = len(ends)
    flat = np.ascontiguousarray(ends).reshape(count, 4)
    both = None if depths is None else np.stack([depths, depths], axis=1)
    canvas.lines(flat, np.full(count, width, dtype=np.float32), _ink(color, count, alpha), both)


def _ink(color: Color, count: int, alpha: int = 255) -> np.ndarray:
    return np.tile(np.array([*color, alpha], dtype=np.uint8), (count, 1))
