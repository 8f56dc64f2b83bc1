"""Streamlines of vector fields in 2D."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from physcore._core import Canvas, tint
from physcore.checks import number
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import Painter, Part
from physcore.film.styles.field_style import LONGEST, FieldPainter, FieldStyle
from physcore.film.styles.fields import Field, pattern
from physcore.scene.bodies import Body
from physcore.simulation.sources import Source, SourceFrame

STEP = 3.0
"""Length of an integration step along a streamline [pixels]."""
LEAST = 0.02
"""Lines end where the field is below this fraction of its top, because its direction is not meaningful there."""


@dataclass(frozen=True)
class Streamlines(FieldStyle):
    """Short streamlines on a regular pattern, tapered toward their upstream end; for 2D scenes.

    Streamlines are an overlay, in addition to the styles of the bodies: `style=[Fluid(), Streamlines()]`. They are
    integrated by the midpoint method in steps of three pixels.

    Args:
        of: as in Arrows.
        spacing: distance between the ends of lines [pixels], at most 10 000.
        length: length of a line [pixels], at most 10 000.
        width: width at a line's downstream end [pixels].
        colormap: as in Points; None: all in the color of text.
        top: the magnitude at the end of the color scale, above zero; None: a typical value of the film.
        on: as in Style: the bodies whose velocities are shown.

    Raises:
        SceneError: a value is not valid, the scene is in 3D, or velocities are needed and were not recorded.
    """

    dimensions: ClassVar[tuple[int, ...]] = (2,)

    spacing: float = 22.0
    length: float = 60.0
    width: float = 2.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(
            spacing=number(self.spacing, "Streamlines.spacing", least=6.0, most=LONGEST),
            length=number(self.length, "Streamlines.length", least=2.0 * STEP, most=LONGEST),
            width=number(self.width, "Streamlines.width", above=0.0),
        )

    def can_draw(self, body: Body) -> bool:
        """Whether a body is in 2D."""
        return body.dimension in self.dimensions

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter with the scale of one film."""
        if source.scene.dimension not in self.dimensions:
            raise SceneError("Streamlines: show the plane, and this scene is in 3D; Arrows() shows space")
        return super().painter(source, parts, theme)

    def field_painter(self, shown: Field, theme: Theme) -> Painter:
        """The painter of streamlines."""
        return StreamlinesPainter(self, shown, theme)


class StreamlinesPainter(FieldPainter):
    """Painter of streamlines."""

    def __init__(self, style: Streamlines, shown: Field, theme: Theme) -> None:
        super().__init__(style, shown, theme)
        self._style = style

    def inset(self, pixels: float) -> float:
        """Half the width of a line."""
        del pixels
        return self._style.width / 2 + 0.5

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue lines whose downstream ends are on the pattern."""
        del pixels
        at, step = self._field.around(frame, view, 0.5 * self._style.spacing), STEP / view.scale
        places = pattern(view, self._style.spacing)
        values = np.linalg.norm(at(places), axis=1)
        places, values = places[values > LEAST * self.top], values[values > LEAST * self.top]
        line = [places]
        for _ in range(round(self._style.length / STEP)):
            # Upstream from the points of the pattern. A line ends where the direction is zero.
            middle = places - 0.5 * step * self._direction(at(places))
            places = places - step * self._direction(at(middle))
            line.append(places)
        if len(places) == 0:
            return
        past = np.stack([view.project(points)[0] for points in reversed(line)])
        ink = tint(values, (0.0, self.top or 1.0), self._table, self._theme.background)
        widths = np.full(len(places), self._style.width, dtype=np.float32)
        canvas.trails(past, widths, ink)

    def _direction(self, vectors: np.ndarray) -> np.ndarray:
        """Unit vectors; zero vectors where the field is negligible."""
        length = np.linalg.norm(vectors, axis=1)[:, np.newaxis]
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(length > LEAST * self.top, vectors / length, 0.0)
