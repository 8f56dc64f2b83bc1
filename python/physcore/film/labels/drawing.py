"""Lines and words over a picture."""

from __future__ import annotations

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.film.colors.themes import Color, Theme


def outlined(canvas: Canvas, line: str, left: int, top: int, height: int, theme: Theme) -> None:
    """Write a line at once over a picture, with an outline of the background around its signs."""
    for x, y in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
        canvas.text(line, left + x, top + y, height, (*theme.background, 255), -1)
    canvas.text(line, left, top, height, (*theme.text, 255), -1)


def stroke(canvas: Canvas, points: FloatArray, color: Color, width: float, alpha: int = 255) -> None:
    """Add a line through points (N, 2)."""
    sides = np.concatenate([points[:-1], points[1:]], axis=1).astype(np.float32)
    inks = np.tile(np.array([*color, alpha], dtype=np.uint8), (len(sides), 1))
    canvas.lines(sides, np.full(len(sides), width, dtype=np.float32), inks)
