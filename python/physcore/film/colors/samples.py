"""The colors that a film will need, painted before it is known: for a palette that is chosen in a single pass."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.film.colors.themes import Theme
from physcore.film.styles import Painter
from physcore.film.styles.base import FOG, SHADING

PITCH = 6
"""From one sample to the next [pixels]; each has edges, where colors mix with the background."""
COLUMNS = 64
"""How many colors of a scale are shown."""
FLAT = (1.0, 1.0, 1.0, 1.0, 1.0, 0.65, 0.5, 0.35, 0.2)
"""How fresh the colors of each row are in 2D: most of what is drawn is, and trails fade away."""
DEEP = tuple(np.linspace(1.0, 1.0 - FOG, 8).tolist())
"""The same in 3D, where what is far away fades into the background."""


def palette_samples(painters: Sequence[Painter], bodies: int, theme: Theme, *, flat: bool, once: bool) -> Canvas:
    """A canvas with the colors of the painters' scales, of so many bodies and of the theme, from fresh to faded.

    Args:
        painters: what draws the film.
        bodies: how many bodies there are.
        theme: the colors.
        once: whether nothing of the film was seen, not even its scales and bodies.
        flat: whether the film is in 2D, where nothing is lit from the side.
    """
    tables = [painter.scale.table for painter in painters if painter.scale is not None and once]
    tables += [painter.traced for painter in painters if painter.traced is not None]
    named = np.array(
        [*theme.bodies[: bodies if once else 0], theme.text, theme.label, theme.edge, theme.surface, theme.solid], float
    )
    strengths = FLAT if flat else DEEP
    canvas = Canvas(COLUMNS * PITCH, PITCH * (len(strengths) * len(tables) + 1), theme.background)
    background = np.array(theme.background, dtype=float)
    _row(canvas, 0, named, lit=False)
    for index, table in enumerate(tables):
        colors = table[np.linspace(0, len(table) - 1, COLUMNS).round().astype(int)]
        for row, strength in enumerate(strengths):
            faded = strength * colors + (1.0 - strength) * background
            _row(canvas, index * len(strengths) + row + 1, faded, lit=not flat and row % 2 == 0)
    canvas.paint()
    return canvas


def _row(canvas: Canvas, row: int, colors: FloatArray, *, lit: bool) -> None:
    """Add a row of discs."""
    centers = np.stack([PITCH * (np.arange(len(colors)) + 0.5), np.full(len(colors), PITCH * (row + 0.5))], axis=1)
    inks = np.full((len(colors), 4), 255, dtype=np.uint8)
    inks[:, :3] = colors
    radii = np.full(len(colors), PITCH / 2, dtype=np.float32)
    canvas.discs(centers.astype(np.float32), radii, inks, None, SHADING if lit else 0.0)
