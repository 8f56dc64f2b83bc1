"""Planes: solid ground in 2D, a square with a grid in 3D."""

from __future__ import annotations

import numpy as np

from physcore._core import Canvas
from physcore.boundaries.plane import Plane
from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.film.colors.themes import Theme
from physcore.film.looks.base import GRID, Look, Scenery, corners, lines


class PlaneLook(Look):
    """The look of a plane with a normal of length one."""

    def __init__(self, plane: Plane) -> None:
        self.point, self.normal = np.array(plane.point), np.array(plane.normal)

    def ground(self, lower: FloatArray, upper: FloatArray) -> FloatArray:
        """The foot of the box's middle, unless the plane is farther from the box than that is large."""
        middle, size = (lower + upper) / 2, float(np.linalg.norm(upper - lower))
        height = (corners(lower, upper) - self.point) @ self.normal
        if height.min() > size:
            return super().ground(lower, upper)
        foot: FloatArray = middle - ((middle - self.point) @ self.normal) * self.normal
        return foot[np.newaxis]

    def draw_behind(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """All of it."""
        (self._half_plane if view.flat else self._ground)(canvas, view, theme, scenery)

    def _half_plane(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """Solid ground on the side that the normal points away from."""
        normal = self.normal
        along = np.array([normal[1], -normal[0]])
        foot = self.point + ((scenery.middle - self.point) @ along) * along
        far = 4.0 * scenery.size
        corners = [foot - far * along, foot + far * along, foot + far * (along - normal), foot - far * (along + normal)]
        pixels = view.project(np.array(corners))[0]
        canvas.polygon(pixels, (*theme.surface, 255))
        lines(canvas, pixels[np.newaxis, :2], theme.edge, 1.5)

    def _ground(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """A square of a plane under the middle of what happens, with a grid for the eye to hold on to."""
        normal, middle, size = self.normal, scenery.middle, scenery.size
        foot = middle - ((middle - self.point) @ normal) * normal
        helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
        first = np.cross(normal, helper)
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        sides = np.array([-first - second, first - second, first + second, second - first])
        canvas.polygon(view.project(foot + size * sides)[0], (*theme.surface, 255))
        steps = np.linspace(-size, size, GRID + 1)[:, np.newaxis]
        starts = np.concatenate([foot + steps * first - size * second, foot + steps * second - size * first])
        ends = np.concatenate([foot + steps * first + size * second, foot + steps * second + size * first])
        pixels = np.stack([view.project(starts)[0], view.project(ends)[0]], axis=1)
        lines(canvas, pixels, theme.edge, 1.0, alpha=80)
