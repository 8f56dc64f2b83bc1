"""Fields in 1D as curves, with the area below filled."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from physcore._core import Canvas, text_width
from physcore.checks import FloatArray, text
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.themes import Color, Theme, mixed
from physcore.film.labels.text import GAP, ends, fitting, text_height
from physcore.film.looks.base import lines
from physcore.film.styles.base import Painter, SystemPart, SystemStyle
from physcore.film.styles.grid_field import GridPainter
from physcore.scene.bodies import Body
from physcore.scene.edges import holds_value
from physcore.scene.system import System
from physcore.simulation.sources import Source, SourceFrame

ASPECT = 0.3
"""Least aspect ratio of the view: height over width."""
FULL = 0.8
"""Height of the largest value, relative to half the height of the view."""
WIDTH = 2.4
"""Width of a curve [pixels]."""
FILL = (0.5, 0.06)
"""Opacity of the area at the largest value, and at zero."""
BEHIND = 0.6
"""Height of the largest potential of a wave function, relative to the largest value."""
PER_PIXEL = 2
"""Points of a smooth curve per pixel."""


@dataclass(frozen=True)
class Line(SystemStyle):
    """Field in 1D as a curve over x, with the area between curve and zero filled.

    The scale is the same for the whole film. The zero line of a nonnegative quantity is at the lower edge of the
    picture. The potential of a wave function is a gray area behind its density, with a scale of its own. Several
    systems in one scene share the picture, each with its own color and scale.

    Args:
        quantity: the name of the field; None: the first field of the system.
        range: the value at the end of the scale; None: the largest value of the film.
        width: width of the curve [pixels].
        on: the system or systems drawn in this style; None: all with fields on a grid in 1D.

    Raises:
        SceneError: a value is not valid, or the quantity was not recorded.
    """

    dimensions: ClassVar[tuple[int, ...]] = (1,)

    quantity: str | None = None
    range: float | None = None
    width: float = WIDTH

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.quantity is not None:
            text(self.quantity, "Line.quantity")
        self._set_positive("range", "width")

    def can_draw(self, item: System) -> bool:
        """Whether an item is on a grid in 1D."""
        return "cells" in item.elements and item.dimension in self.dimensions

    def painter(self, source: Source, part: SystemPart, theme: Theme) -> Painter:
        """The painter with the scale of one film."""
        if not self.can_draw(part.system):
            raise SceneError(f"Line.on: {part.system!r} has no field on a grid in 1D; use Field() in 2D and 3D")
        return LinePainter(self, source, part, theme)


class LinePainter(GridPainter):
    """Painter of an axis, a filled area and a curve."""

    def __init__(self, style: Line, source: Source, part: SystemPart, theme: Theme) -> None:
        super().__init__(style, style.quantity, source, part, theme, "Line")
        self._style = style
        self._color = theme.bodies[part.index % len(theme.bodies)]
        self.top = style.range or 0.0
        self.together: Sequence[LinePainter] = [self]
        """All painters of curves in the same picture, in order."""
        self._potential = self._system.landscape

    def meet(self, painters: Sequence[Painter]) -> None:
        """Know the other curves."""
        self.together = [painter for painter in painters if isinstance(painter, LinePainter)]

    @property
    def legend(self) -> list[tuple[Body | System, Color]]:
        """The system and its color."""
        return [(self._system, self._color)]

    @property
    def settled(self) -> bool:
        """Whether the range was given."""
        return self._style.range is not None

    @property
    def landmarks(self) -> FloatArray:
        """The ends of the line, with room for the curve."""
        low, high = self._grid.origin[0], self._grid.upper[0]
        room = 0.5 * ASPECT * (high - low)
        return np.array([[low, -room], [high, room]])

    def observe(self, frame: SourceFrame) -> None:
        """Update the largest value by a frame."""
        if not self.settled:
            largest = float(np.abs(self.values(frame)).max(initial=0.0))
            self.top = max(self.top, largest if math.isfinite(largest) else 0.0)

    def inset(self, pixels: float) -> float:
        """Half the width of the curve."""
        del pixels
        return self._style.width / 2 + 1.0

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue the axis, the area and the curve, in this order."""
        del pixels
        theme = self._theme
        places = np.array([[self._grid.origin[0], 0.0], [self._grid.upper[0], 0.0]])
        (left, middle), (right, _) = view.project(places)[0].astype(float).tolist()
        full = 0.5 * FULL * view.height
        zero, reach = (middle, full) if self.signed else (middle + full, 2.0 * full)
        if self._potential is not None:
            x, heights = self._curve(self._potential, left, right, smooth=False)
            self._fill(canvas, (x, zero - BEHIND * reach * heights), zero, reach, theme.edge)
        x, values = self._curve(self.values(frame), left, right)
        y = zero - reach * values / (self.top or 1.0)
        self._paint_axis(canvas, left, right, zero, reach)
        self._fill(canvas, (x, y), zero, reach, self._color)
        points = np.stack([x, y], axis=1).astype(np.float32)
        segments = np.concatenate([points[:-1], points[1:]], axis=1)
        ink = np.tile(np.array([*self._color, 255], dtype=np.uint8), (len(segments), 1))
        canvas.lines(segments, np.full(len(segments), self._style.width, dtype=np.float32), ink)
        for end, place in zip(("x-", "x+"), ((left, y[0]), (right, y[-1])), strict=True):
            if holds_value(self._system.conditions(self.quantity)[end == "x+"]):
                radius, white = np.array([1.6 * self._style.width], dtype=np.float32), [[*theme.text, 255]]
                canvas.discs(np.array([place], dtype=np.float32), radius, np.array(white, dtype=np.uint8))

    @property
    def _words(self) -> str:
        """The quantity, and its value at the end of the scale, as text."""
        return f"{self.quantity} {ends(0.0, self.top)[1]}{self._suffix}" if self.top > 0.0 else self.quantity

    def _paint_axis(self, canvas: Canvas, left: float, right: float, zero: float, reach: float) -> None:
        """Draw lines at zero and at the ends of the scale, with the value there.

        Curves of one picture share these lines. If they differ in scale, each value has the color of its curve.
        """
        if any(other.signed == self.signed for other in self.together[: self.together.index(self)]):
            return
        heights = [zero, zero - reach, *([zero + reach] if self.signed else [])]
        rules = np.array([[[left, height], [right, height]] for height in heights], dtype=np.float32)
        lines(canvas, rules[:1], self._theme.edge, 1.0)
        lines(canvas, rules[1:], mixed(self._theme.background, self._theme.edge, 0.4), 1.0)
        if self is not self.together[0]:
            return
        scales: dict[str, Color] = {}
        for painter in self.together:
            scales.setdefault(painter._words, painter._color)
        line = GAP.join(scales)
        text = text_height(round(right - left), round(2.0 * zero if self.signed else zero))
        text = fitting(line, text, round(right - left))
        x, top = round(left), max(2, round(zero - reach - 1.1 * text))
        for words, color in scales.items():
            ink = self._theme.label if len(scales) == 1 else color
            canvas.text(words, x, top, text, (*ink, 255), -1)
            x += text_width(words + GAP, text)

    def _curve(
        self, values: FloatArray, left: float, right: float, smooth: bool = True
    ) -> tuple[FloatArray, FloatArray]:
        """The horizontal pixels and the values of points along a curve, from edge to edge."""
        count = len(values)
        if not smooth:  # steps at the faces of cells
            marks, values = np.repeat(np.arange(count + 1) / count, 2)[1:-1], np.repeat(values, 2)
            return left + (right - left) * marks, values
        marks = (np.arange(count) + 0.5) / count
        outer = self._system.outer(self.quantity, values)
        marks, values = np.array([0.0, *marks, 1.0]), np.array([outer[0], *values, outer[1]])
        fine = PER_PIXEL * max(1, math.ceil(right - left))
        if fine > count:  # few cells: a smooth curve through them
            places = np.linspace(0.0, 1.0, fine)
            values, marks = hermite(marks, values, places), places
        return left + (right - left) * marks, values

    def _fill(
        self, canvas: Canvas, curve: tuple[FloatArray, FloatArray], zero: float, reach: float, color: Color
    ) -> None:
        """Queue the area between a curve and zero, which fades toward zero."""
        x, y = curve
        fresh, faint = (np.array([*mixed(self._theme.background, color, share), 255]) for share in FILL)
        share = np.minimum(np.abs(y - zero) / reach, 1.0)[:, np.newaxis]
        tops = np.round(faint + (fresh - faint) * share).astype(np.uint8)
        low = np.tile(faint.astype(np.uint8), (len(x), 1))
        upper, lower = np.stack([x, y], axis=1), np.stack([x, np.full_like(x, zero)], axis=1)
        first = np.stack([upper[:-1], upper[1:], lower[:-1]], axis=1)
        second = np.stack([upper[1:], lower[1:], lower[:-1]], axis=1)
        inks = np.concatenate(
            [np.stack([tops[:-1], tops[1:], low[:-1]], 1), np.stack([tops[1:], low[1:], low[:-1]], 1)]
        )
        canvas.triangles(np.concatenate([first, second]).reshape(-1, 6).astype(np.float32), inks.reshape(-1, 12))


def hermite(x: FloatArray, y: FloatArray, places: FloatArray) -> FloatArray:
    """Cubic Hermite interpolation with slopes from finite differences, at places within the points."""
    slopes = np.gradient(y, x)
    index = np.clip(np.searchsorted(x, places, side="right") - 1, 0, len(x) - 2)
    width = x[index + 1] - x[index]
    s = (places - x[index]) / width
    h = s * s * (3.0 - 2.0 * s)
    straight = (1.0 - h) * y[index] + h * y[index + 1]
    bent: FloatArray = straight + width * s * (1.0 - s) * ((1.0 - s) * slopes[index] - s * slopes[index + 1])
    return bent
