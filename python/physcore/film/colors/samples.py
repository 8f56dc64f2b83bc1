"""Samples of the colors of a film, drawn before the film itself, so that one pass suffices to choose the palette."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.film.camera.view import FOG
from physcore.film.colors.themes import Theme
from physcore.film.styles import Painter
from physcore.film.styles.base import SHADING

PITCH = 6
"""Distance between samples [pixels]. Each sample has edges, where colors mix with the background."""
COLUMNS = 64
"""Number of colors shown of each scale."""
FLAT = (1.0, 1.0, 1.0, 1.0, 1.0, 0.65, 0.5, 0.35, 0.2)
"""Opacities of the rows in 2D. Most drawn colors are opaque, and trails fade."""
DEEP = tuple(np.linspace(1.0, 1.0 - FOG, 8).tolist())
"""Opacities of the rows in 3D, where distant objects fade into the background."""


def palette_samples(painters: Sequence[Painter], bodies: int, theme: Theme, *, flat: bool, once: bool) -> Canvas:
    """A canvas with the colors of the painters' scales, of the bodies and of the theme, from opaque to faded.

    Args:
        painters: the painters of the film.
        bodies: the number of bodies.
        theme: the colors.
        once: whether the film is drawn in a single pass, so that no frame has been seen before.
        flat: whether the film is in 2D, without lighting.
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
