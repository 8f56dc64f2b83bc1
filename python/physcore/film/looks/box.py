"""Looks of boxes: their edges. Solid boxes are drawn as other solids."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physcore._core import Canvas
from physcore.boundaries.box import Box
from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.film.colors.themes import Theme
from physcore.film.looks.base import GRID, Look, Scenery, ground, lines, wall
from physcore.film.shapes.box import corners


class BoxLook(Look):
    """The look of a box."""

    def __init__(self, box: Box) -> None:
        self.lower, self.upper = np.array(box.lower), np.array(box.upper)

    def landmarks(self) -> Iterator[tuple[FloatArray, float]]:
        """All corners."""
        yield corners(self.lower, self.upper), 0.0

    def draw_behind(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """Draw all edges in 2D; in 3D, the ground, the walls that are seen from inside, and the edges behind."""
        if not view.flat:
            foot = np.append((self.lower[:2] + self.upper[:2]) / 2, self.lower[2])
            size = float(np.linalg.norm(self.upper[:2] - self.lower[:2])) / 2
            ground(canvas, view, theme, np.array([0.0, 0.0, 1.0]), foot, size, 2.0 * size / GRID)
            for normal, outline in self._walls():
                wall(canvas, view, theme, normal, outline)
        draw_edges(canvas, self.lower, self.upper, view, theme, front=False)

    def _walls(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        """The inward normal and the corners (4, 3) [m] of each face except the floor."""
        points = corners(self.lower, self.upper)
        for axis, upper in ((0, False), (0, True), (1, False), (1, True), (2, True)):
            bit = 1 << (2 - axis)
            first, second, third, fourth = (each for each in range(8) if bool(each & bit) == upper)
            yield (-1.0 if upper else 1.0) * np.eye(3)[axis], points[[first, second, fourth, third]]

    def draw_among(self, canvas: Canvas, view: View, theme: Theme) -> None:
        """Queue the edges in front, in 3D."""
        if not view.flat:
            draw_edges(canvas, self.lower, self.upper, view, theme, front=True)


def draw_edges(
    canvas: Canvas,
    lower: FloatArray,
    upper: FloatArray,
    view: View,
    theme: Theme,
    *,
    front: bool,
    thin: bool = False,
    along: list[int] | None = None,
) -> None:
    """Draw the edges of a box, or only those along some axes. In 3D, the edges that meet in the farthest corner are
    behind all objects, and the others in front.
    """
    points = corners(lower, upper)
    count, dimension = points.shape
    bits = range(dimension) if along is None else [dimension - 1 - axis for axis in along]
    pairs = [(i, i | 1 << bit) for i in range(count) for bit in bits if not i & 1 << bit]
    pixels, depth, _ = view.project(points)
    if view.turnable and depth is not None:  # which edges are in front changes: they have their own depths
        ends = np.array(pairs[: 0 if front else None], dtype=int).reshape(-1, 2)
        flat, ink = pixels[ends].reshape(-1, 4), np.tile(np.array([*theme.edge, 255], dtype=np.uint8), (len(ends), 1))
        canvas.lines(flat, np.full(len(ends), 0.8 if thin else 1.3, dtype=np.float32), ink, depth[ends])
        return
    if depth is None:
        lines(canvas, pixels[np.array(pairs)], theme.edge, 1.0 if thin else 2.0)
        return
    farthest = int(np.argmax(depth))
    chosen = np.array([pair for pair in pairs if (farthest not in pair) == front], dtype=int).reshape(-1, 2)
    depths = np.full(len(chosen), -np.inf if front else np.inf, dtype=np.float32)
    lines(canvas, pixels[chosen], theme.edge, 0.8 if thin else 1.3, depths=depths)
