"""Looks of wires: thin lines."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.constraints.wire import Wire
from physcore.film.camera.view import View
from physcore.film.colors.themes import Theme, mixed
from physcore.film.looks.base import Look, Scenery, lines

WIDTH = 1.6
"""Width of the line in pixels."""
SEGMENTS = 400
"""Approximate number of segments of the line."""


class WireLook(Look):
    """The look of a wire."""

    def __init__(self, wire: Wire) -> None:
        self.points = wire.curve(max(1, SEGMENTS // len(wire.points)))

    def landmarks(self) -> Iterator[tuple[FloatArray, float]]:
        """All points of the curve."""
        yield self.points, 0.0

    def draw_behind(self, canvas: Canvas, view: View, theme: Theme, scenery: Scenery) -> None:
        """Draw the curve in 2D."""
        del scenery
        if view.flat:
            pixels = view.project(self.points)[0]
            lines(canvas, np.stack([pixels[:-1], pixels[1:]], axis=1), theme.edge, WIDTH)
            canvas.paint()

    def draw_among(self, canvas: Canvas, view: View, theme: Theme) -> None:
        """Queue the curve in 3D, part by part at its depth."""
        pixels, depths, _ = view.project(self.points)
        if depths is not None:
            ends = np.stack([pixels[:-1], pixels[1:]], axis=1)
            color = mixed(theme.edge, theme.surface, 0.2)
            lines(canvas, ends, color, WIDTH, depths=0.5 * (depths[:-1] + depths[1:]))
