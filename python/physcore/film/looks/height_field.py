"""Looks of height fields: solid ground below a line in 2D, a lit surface with vertical sides in 3D."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physcore._core import Canvas
from physcore.boundaries.height_field import HeightField
from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.film.colors.themes import Theme
from physcore.film.looks.base import Look, Scenery, lines
from physcore.film.looks.solid import draw_facets, record_facets
from physcore.film.page.tape import Tape
from physcore.film.shapes.box import corners

SKIRT = 0.04
"""Depth of the sides below the lowest node, relative to the width."""


class HeightFieldLook(Look):
    """The look of a height field."""

    def __init__(self, ground: HeightField) -> None:
        self.nodes = ground.nodes
        flat = self.nodes.reshape(-1, ground.dimension)
        self.base = float(ground.heights.min() - SKIRT * np.ptp(flat[:, :-1], axis=0).max())
        self.triangles, self.normals = _landscape(self.nodes, self.base) if ground.dimension == 3 else (flat, flat)

    def landmarks(self) -> Iterator[tuple[FloatArray, float]]:
        """All nodes, and the lower corners of the sides."""
        points = self.nodes.reshape(-1, self.nodes.shape[-1])
        yield points, 0.0
        if self.nodes.ndim == 3:
            feet = corners(points.min(axis=0), points.max(axis=0))
            yield np.column_stack([feet[:, :-1], np.full(len(feet), self.base)]), 0.0

    def draw_behind(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """Draw the ground in 2D."""
        if not view.flat:
            return
        deep = np.stack([self.nodes[:, 0], np.full(len(self.nodes), self.base - 4.0 * scenery.size)], axis=1)
        top, foot = view.project(self.nodes)[0], view.project(deep)[0]
        ink = (*theme.surface, 255)
        for segment in range(len(top) - 1):
            both = slice(segment, segment + 2)
            canvas.polygon(np.concatenate([top[both], foot[both][::-1]]), ink)
        # Antialiasing leaves a seam of half a pixel between adjacent polygons. A strip at each inner node covers it.
        for before, node, after, below in zip(top[:-2], top[1:-1], top[2:], foot[1:-1], strict=True):
            fall = max((side[1] - node[1]) / abs(side[0] - node[0]) for side in (before, after))
            under = node[1] + max(fall, 0.0)
            strip = [[node[0] - 1, under], [node[0] + 1, under], [node[0] + 1, below[1]], [node[0] - 1, below[1]]]
            canvas.polygon(np.array(strip, dtype=np.float32), ink)
        outline = np.concatenate([foot[:1], top, foot[-1:]])
        lines(canvas, np.stack([outline[:-1], outline[1:]], axis=1), theme.edge, 1.5)

    def draw_among(self, canvas: Canvas, view: View, theme: Theme) -> None:
        """Queue the surface in 3D."""
        if not view.flat:
            draw_facets(canvas, view, theme, self.triangles, self.normals)

    def record(self, tape: Tape, view: View, theme: Theme, scenery: Scenery) -> None:
        """Put the ground, or the whole surface, on a tape."""
        if view.flat:
            super().record(tape, view, theme, scenery)
        else:
            record_facets(tape, theme, self.triangles, self.normals)


def _landscape(nodes: FloatArray, base: float) -> tuple[FloatArray, FloatArray]:
    """Triangles (T, 3, 3) of ground and sides, counterclockwise from outside, and the normals at each corner."""
    a, b, c, d = nodes[:-1, :-1], nodes[1:, :-1], nodes[:-1, 1:], nodes[1:, 1:]
    # The two triangles of a cell meet along its higher diagonal.
    rises = (a[..., 2] + d[..., 2] >= b[..., 2] + c[..., 2])[..., np.newaxis]
    low = np.stack([a, b, np.where(rises, d, c)], axis=-2)
    high = np.stack([np.where(rises, a, b), d, c], axis=-2)
    parts = [low.reshape(-1, 3, 3), high.reshape(-1, 3, 3)]
    for top in (nodes[:, 0], nodes[-1, :], nodes[::-1, -1], nodes[::-1][-1, ::-1]):
        foot = np.concatenate([top[:, :2], np.full((len(top), 1), base)], axis=1)
        parts += [np.stack([foot[:-1], foot[1:], top[1:]], axis=1), np.stack([foot[:-1], top[1:], top[:-1]], axis=1)]
    triangles = np.concatenate(parts)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return triangles, np.repeat(normals[:, np.newaxis], 3, axis=1)
