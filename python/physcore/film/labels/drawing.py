"""Drawing of lines and text over a picture."""

from __future__ import annotations

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.film.colors.themes import Color


def write(
    canvas: Canvas,
    line: str,
    x: int,
    top: int,
    height: int,
    color: Color,
    align: int = -1,
    outline: Color | None = None,
) -> None:
    """Write a line of text immediately, with an outline around its glyphs if `outline` is given. `align` is -1, 0 or 1
    for left, center and right.
    """
    if outline is not None:
        for right, down in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
            canvas.text(line, x + right, top + down, height, (*outline, 255), align)
    canvas.text(line, x, top, height, (*color, 255), align)


def stroke(canvas: Canvas, points: FloatArray, color: Color, width: float, alpha: int = 255) -> None:
    """Add a polyline through points (N, 2)."""
    sides = np.concatenate([points[:-1], points[1:]], axis=1).astype(np.float32)
    inks = np.tile(np.array([*color, alpha], dtype=np.uint8), (len(sides), 1))
    canvas.lines(sides, np.full(len(sides), width, dtype=np.float32), inks)
