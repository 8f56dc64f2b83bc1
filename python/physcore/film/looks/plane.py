"""Looks of planes: solid ground in 2D; in 3D, ground with a grid that fades at a distance."""

from __future__ import annotations

import numpy as np

from physcore._core import Canvas
from physcore.boundaries.plane import Plane
from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.film.colors.themes import Theme
from physcore.film.looks.base import GRID, Look, Scenery, ground, lines
from physcore.film.shapes.box import corners


class PlaneLook(Look):
    """The look of a plane with a normal of length 1."""

    def __init__(self, plane: Plane) -> None:
        self.point, self.normal = np.array(plane.point), np.array(plane.normal)

    def ground(self, lower: FloatArray, upper: FloatArray) -> FloatArray:
        """The projection of the box's center onto the plane, unless the plane is farther from the box than the box is
        large.
        """
        middle, size = (lower + upper) / 2, float(np.linalg.norm(upper - lower))
        height = (corners(lower, upper) - self.point) @ self.normal
        if height.min() > size:
            return super().ground(lower, upper)
        foot: FloatArray = middle - ((middle - self.point) @ self.normal) * self.normal
        return foot[np.newaxis]

    def draw_behind(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """Draw the whole plane."""
        (self._half_plane if view.flat else self._ground)(canvas, view, theme, scenery)

    def _half_plane(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """Draw solid ground on the side opposite to the normal."""
        normal = self.normal
        along = np.array([normal[1], -normal[0]])
        foot = self.point + ((scenery.middle - self.point) @ along) * along
        far = 4.0 * scenery.size
        corners = [foot - far * along, foot + far * along, foot + far * (along - normal), foot - far * (along + normal)]
        pixels = view.project(np.array(corners))[0]
        canvas.polygon(pixels, (*theme.surface, 255))
        lines(canvas, pixels[np.newaxis, :2], theme.edge, 1.5)

    def _ground(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """Draw the plane below the center of the scenery, with a grid for orientation."""
        foot = scenery.middle - ((scenery.middle - self.point) @ self.normal) * self.normal
        ground(canvas, view, theme, self.normal, foot, scenery.size, 2.0 * scenery.size / GRID)
