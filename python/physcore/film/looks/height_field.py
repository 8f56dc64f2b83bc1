"""Height fields: solid ground below a line in 2D, a lit landscape with a skirt around it in 3D."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physcore._core import Canvas
from physcore.boundaries.height_field import HeightField
from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.film.colors.themes import Theme
from physcore.film.looks.base import Look, Scenery, lines
from physcore.film.looks.solid import draw_facets

SKIRT = 0.04
"""How far below its lowest node a landscape is cut, in units of its width."""


class HeightFieldLook(Look):
    """The look of a height field."""

    def __init__(self, ground: HeightField) -> None:
        self.nodes = ground.nodes
        flat = self.nodes.reshape(-1, ground.dimension)
        self.base = float(ground.heights.min() - SKIRT * np.ptp(flat[:, :-1], axis=0).max())
        self.corners, self.normals = _landscape(self.nodes, self.base) if ground.dimension == 3 else (flat, flat)

    def landmarks(self) -> Iterator[tuple[FloatArray, float]]:
        """All nodes."""
        yield self.nodes.reshape(-1, self.nodes.shape[-1]), 0.0

    def draw_behind(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """The ground in 2D."""
        if not view.flat:
            return
        line, deep = self.nodes, self.base - 4.0 * scenery.size
        feet = np.array([[line[-1, 0], deep], [line[0, 0], deep]])
        pixels = view.project(np.concatenate([line, feet]))[0]
        canvas.polygon(pixels, (*theme.surface, 255))
        outline = np.concatenate([pixels[-1:], pixels[:-1]])
        lines(canvas, np.stack([outline[:-1], outline[1:]], axis=1), theme.edge, 1.5)

    def draw_among(self, canvas: Canvas, view: View, theme: Theme) -> None:
        """The landscape in 3D."""
        if not view.flat:
            draw_facets(canvas, view, theme, self.corners, self.normals)


def _landscape(nodes: FloatArray, base: float) -> tuple[FloatArray, FloatArray]:
    """Triangles (T, 3, 3) of the ground and its skirt, counterclockwise from outside, and normals at each corner."""
    a, b, c, d = nodes[:-1, :-1], nodes[1:, :-1], nodes[:-1, 1:], nodes[1:, 1:]
    # The ground is bent along the higher diagonal of a cell.
    rises = (a[..., 2] + d[..., 2] >= b[..., 2] + c[..., 2])[..., np.newaxis]
    low = np.stack([a, b, np.where(rises, d, c)], axis=-2)
    high = np.stack([np.where(rises, a, b), d, c], axis=-2)
    parts = [low.reshape(-1, 3, 3), high.reshape(-1, 3, 3)]
    for top in (nodes[:, 0], nodes[-1, :], nodes[::-1, -1], nodes[::-1][-1, ::-1]):
        foot = np.concatenate([top[:, :2], np.full((len(top), 1), base)], axis=1)
        parts += [np.stack([foot[:-1], foot[1:], top[1:]], axis=1), np.stack([foot[:-1], top[1:], top[:-1]], axis=1)]
    corners = np.concatenate(parts)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return corners, np.repeat(normals[:, np.newaxis], 3, axis=1)
