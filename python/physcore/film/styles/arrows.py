"""Arrows of a vector field, such as velocity or acceleration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physcore._core import Canvas, norms, tint
from physcore.checks import number
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import Painter
from physcore.film.styles.field_style import LONGEST, FieldPainter, FieldStyle
from physcore.film.styles.fields import Field
from physcore.simulation.sources import SourceFrame

HEAD = 0.34
"""Length of an arrow's head, relative to the longest arrow."""
WIDTH = 0.075
"""Width of a shaft, relative to the longest arrow."""
LEAST = 0.12
"""Arrows shorter than this fraction of the longest are not drawn, because their direction is not meaningful."""


@dataclass(frozen=True)
class Arrows(FieldStyle):
    """Arrows on a regular pattern. Their length and color show the magnitude of a vector field.

    Arrows are an overlay, in addition to the styles of the bodies: `style=[Points(), Arrows()]`.

    Args:
        of: "velocities" [m/s]: the mean over the particles around each arrow. "acceleration" [m/s²]: that of a test
            particle of 1 kg and 1 C at rest, by gravity, wind and centers of force. Or a function of the time [s] and
            positions (N, D) [m] that gives vectors (N, D).
        spacing: distance between arrows [pixels], at most 10 000.
        colormap: as in Points; None: all in the color of text.
        top: the magnitude of the longest arrow, above zero; None: a typical value of the film.
        on: as in Style: the bodies whose velocities are shown.

    Raises:
        SceneError: a value is not valid, or velocities are needed and were not recorded.
    """

    spacing: float = 26.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(spacing=number(self.spacing, "Arrows.spacing", least=6.0, most=LONGEST))

    def field_painter(self, shown: Field, theme: Theme) -> Painter:
        """The painter of arrows."""
        return ArrowsPainter(self, shown, theme)


class ArrowsPainter(FieldPainter):
    """Painter of arrows: shafts and heads."""

    def __init__(self, style: Arrows, shown: Field, theme: Theme) -> None:
        super().__init__(style, shown, theme)
        self._style = style

    def inset(self, pixels: float) -> float:
        """Half the length of an arrow."""
        del pixels
        return self._style.spacing / 2

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue arrows, above other objects at the same place."""
        del pixels
        places, vectors = self._field.samples(frame, view, self._style.spacing)
        values = norms(vectors)
        shown = np.isfinite(values) & (values > LEAST * self.top)
        places, vectors, values = places[shown], vectors[shown], values[shown]
        if len(places) == 0:
            return
        # Each arrow is centered on its point.
        length = 0.9 * self._style.spacing / view.scale
        half = 0.5 * length * np.minimum(1.0, self.top / values)[:, np.newaxis] * vectors / self.top
        tails, depth, _ = view.project(places - half)
        tips, there, _ = view.project(places + half)
        ink = tint(values, (0.0, self.top), self._table, self._theme.background)
        longest = np.float32(0.9 * self._style.spacing)
        widths = np.full(len(tips), max(WIDTH * longest, 1.2), dtype=np.float32)
        corners = heads(tails, tips, longest)
        both = None if depth is None or there is None else np.stack([depth, there], axis=1)
        canvas.lines(np.concatenate([tails, corners.mean(axis=1)], axis=1), widths, ink, both)
        inks = np.repeat(ink[:, np.newaxis], 3, axis=1).reshape(-1, 12)
        canvas.triangles(corners.reshape(-1, 6), inks, None if depth is None else depth[:, np.newaxis])


def heads(tails: PixelArray, tips: PixelArray, longest: np.float32) -> PixelArray:
    """The corners (N, 3, 2) of the heads of arrows [pixels]; a head is at most 0.6 of its arrow."""
    along = tips - tails
    length = np.maximum(np.sqrt(np.einsum("nd,nd->n", along, along)), np.float32(1e-6))[:, np.newaxis]
    along = along / length
    size = np.minimum(np.float32(HEAD) * longest, np.float32(0.6) * length)
    back, aside = tips - size * along, 0.5 * size * along[:, ::-1] * np.array([1.0, -1.0], dtype=np.float32)
    return np.ascontiguousarray(np.stack([tips, back + aside, back - aside], axis=1))
