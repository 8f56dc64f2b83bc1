"""Looks of solid obstacles: polygons in 2D, lit facets in 3D."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from physcore._core import Canvas, convex_hull
from physcore.boundaries.capsule import Capsule
from physcore.boundaries.convex_hull import ConvexHull
from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.film.colors.light import lit
from physcore.film.colors.themes import Theme
from physcore.film.looks.base import Look, Scenery, lines
from physcore.film.page.tape import Tape

ARC = 24
"""Segments of a semicircle in 2D."""
PARTS = 6
"""Subdivisions of each side of a facet. Each part is sorted by depth on its own among the other objects."""
SHORTEST = 8.0
"""Least length of such a part along a capsule [pixels]."""
MOST_PARTS = 256
"""Largest number of parts along a capsule, however far it reaches beyond the view."""
SAGITTA = 0.25
"""Largest deviation of the outline of a capsule in 3D from a circle [pixels]."""
FINEST = 12
"""Largest number of segments of a quarter of that circle."""


class SolidLook(Look):
    """The look of the convex hull of points, rounded by a radius [m]."""

    def __init__(self, points: FloatArray, radius: float = 0.0) -> None:
        self.points, self.radius = points, radius

    @classmethod
    def hull(cls, item: ConvexHull) -> SolidLook:
        """The look of a convex hull."""
        return cls(item.points)

    @classmethod
    def capsule(cls, item: Capsule) -> SolidLook:
        """The look of a capsule."""
        return cls(np.array([item.start, item.end]), item.radius)

    def landmarks(self) -> Iterator[tuple[FloatArray, float]]:
        """All points, with the radius as margin."""
        yield self.points, self.radius

    def draw_behind(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """Draw a polygon in 2D."""
        if view.flat:
            pixels = view.project(self._outline())[0]
            canvas.polygon(pixels, (*theme.surface, 255))
            lines(canvas, np.stack([pixels, np.roll(pixels, -1, axis=0)], axis=1), theme.edge, 2.0)

    def draw_among(self, canvas: Canvas, view: View, theme: Theme) -> None:
        """Queue lit triangles in 3D."""
        if view.flat:
            return
        draw_facets(canvas, view, theme, *(self._rounded(view) if self.radius else self._facets()))

    def record(self, tape: Tape, view: View, theme: Theme, scenery: Scenery) -> None:
        """Put the polygon, or the whole surface, on a tape."""
        if view.flat:
            super().record(tape, view, theme, scenery)
        else:
            record_facets(tape, theme, *(self._rounded(view) if self.radius else self._facets()))

    def _outline(self) -> FloatArray:
        """The corners of the polygon in 2D (N, 2), counterclockwise."""
        if not self.radius:
            middle = self.points.mean(axis=0)
            corners = self.points[np.unique(np.concatenate(convex_hull(self.points)))]
            around = corners[np.argsort(np.arctan2(*(corners - middle).T[::-1]))]
            return around
        start, end = self.points
        heading = float(np.arctan2(*(end - start)[::-1]))
        turns = heading + np.linspace(-0.5 * np.pi, 0.5 * np.pi, ARC + 1)
        caps = [np.stack([np.cos(turns + half), np.sin(turns + half)], axis=1) for half in (0.0, np.pi)]
        return np.concatenate([end + self.radius * caps[0], start + self.radius * caps[1]])

    def _facets(self) -> tuple[FloatArray, FloatArray]:
        """Triangles (T, 3, 3) and the normals at each corner."""
        steps = np.array([(i, j) for i in range(PARTS) for j in range(PARTS - i)], dtype=float)
        upward = steps[:, np.newaxis] + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
        inner = steps[steps.sum(axis=1) < PARTS - 1]
        downward = inner[:, np.newaxis] + np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        weights = np.concatenate([upward, downward]) / PARTS
        corners, normals = [], []
        for first, *around in (self.points[facet] for facet in convex_hull(self.points)):
            for one, other in pairwise(around):
                corners.append(first + weights[..., :1] * (one - first) + weights[..., 1:] * (other - first))
                normal = np.cross(one - first, other - first)
                normals.append(np.broadcast_to(normal / np.linalg.norm(normal), corners[-1].shape))
        return np.concatenate(corners), np.concatenate(normals)

    def _rounded(self, view: View) -> tuple[FloatArray, FloatArray]:
        """The triangles of a capsule and the normals at their corners. Their number depends on the size in the view.

        The sagitta of one of q segments of a quarter circle is r (1 − cos(π/4q)) ≈ π² r / 32 q².
        """
        start, end = self.points
        scale = float(view.project(self.points)[2].max())
        quarter = math.ceil(math.pi * math.sqrt(self.radius * scale / (32.0 * SAGITTA)))
        quarter = min(max(quarter, 2), FINEST)
        length = float(np.linalg.norm(end - start))
        axis = (end - start) / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
        first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        first /= np.linalg.norm(first)
        level = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2 * quarter + 1)
        sides = max(1, round(min(length * scale / max(self.radius * scale / PARTS, SHORTEST), MOST_PARTS)))
        heights = np.concatenate([level[level < 0.0], np.zeros(sides + 1), level[level > 0.0]])
        feet = np.concatenate([np.zeros(quarter), np.linspace(0.0, 1.0, sides + 1), np.ones(quarter)])
        turn = np.linspace(0.0, 2.0 * np.pi, 4 * quarter + 1)
        ring = np.cos(turn)[:, np.newaxis] * first + np.sin(turn)[:, np.newaxis] * np.cross(axis, first)
        normals = np.cos(heights)[:, np.newaxis, np.newaxis] * ring + np.sin(heights)[:, np.newaxis, np.newaxis] * axis
        places = start + feet[:, np.newaxis, np.newaxis] * (end - start) + self.radius * normals
        pick = [(slice(None, -1), slice(None, -1)), (slice(None, -1), slice(1, None)), (slice(1, None), slice(1, None))]
        pick += [pick[0], pick[2], (slice(1, None), slice(None, -1))]

        def triangles(values: FloatArray) -> FloatArray:
            return np.concatenate(
                [np.stack([values[each].reshape(-1, 3) for each in pick[k : k + 3]], axis=1) for k in (0, 3)]
            )

        return triangles(places), triangles(normals)


def record_facets(tape: Tape, theme: Theme, corners: FloatArray, normals: FloatArray) -> None:
    """Put triangles (T, 3, 3) with `normals` per corner on a tape, in the color of solids."""
    points = corners.reshape(-1, 3)
    order, color = np.arange(len(points)).reshape(-1, 3), np.array([theme.solid], dtype=float)
    place = np.zeros((1, 3)), np.eye(3)[np.newaxis]
    tape.solids(points, normals.reshape(-1, 3), np.ones(len(points)), order, *place, color)


def draw_facets(canvas: Canvas, view: View, theme: Theme, corners: FloatArray, normals: FloatArray) -> None:
    """Queue the triangles (T, 3, 3) that face the camera, with lighting; counterclockwise from outside, `normals` per
    corner.
    """
    pixels, depth, _ = view.project(corners.reshape(-1, 3))
    assert depth is not None  # views in 3D have depths
    first, second, third = np.moveaxis(pixels.reshape(-1, 3, 2), 1, 0)
    # The y axis of pixels points down, which reverses the orientation.
    along, across = (second - first).T, (third - first).T
    seen = along[0] * across[1] < along[1] * across[0]
    facing = normals[seen].reshape(-1, 3) @ view.axes.T
    colors = lit(np.tile(np.array(theme.solid, dtype=float), (len(facing), 1)), facing)
    inks = np.concatenate([colors, np.full((len(colors), 1), 255.0)], axis=1).astype(np.uint8)
    canvas.triangles(
        np.ascontiguousarray(pixels.reshape(-1, 6)[seen]),
        inks.reshape(-1, 12),
        np.ascontiguousarray(depth.reshape(-1, 3)[seen]),
    )
