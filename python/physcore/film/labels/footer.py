"""The footer of a film: legend, time, numerics, color bars, figure and credit."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import zip_longest
from typing import Literal

import numpy as np

from physcore._core import Canvas, text_width
from physcore.checks import FloatArray, words
from physcore.errors import SceneError
from physcore.film.colors.colormaps import look_up
from physcore.film.colors.themes import Color, Theme
from physcore.film.labels.clock import Clock
from physcore.film.labels.drawing import write
from physcore.film.labels.text import GAP, broken, ends, fitting, wrapped
from physcore.film.styles.base import Scale
from physcore.simulation.energy import Drift, Energy
from physcore.simulation.sources import Source
from physcore.units.systems import SI, UnitSystem

Label = Literal["time", "dt", "integrator", "energy"]
LABELS: tuple[Label, ...] = ("time", "dt", "integrator", "energy")
"""All labels of the footer."""
LINE = 1.3
"""Line spacing, in heights of the text."""
WIDEST, NARROWEST = 4.0, 2.0
"""Largest and least length of a color bar, in heights of the text."""
SMALL = 0.8
"""Height of figure and credit, in heights of the text."""
THICK = 0.5
"""Thickness of a color bar, in heights of the text."""
WIDE = 1_000_000
"""Width of a line that is not wrapped [pixels]."""
MARK = "●"
"""Marker before each name of the legend, in the color of its body."""


def check_labels(labels: object, found: Sequence[Source]) -> tuple[Label, ...]:
    """The requested labels.

    Raises:
        SceneError: they are not some of LABELS, or their quantities were not recorded.
    """
    chosen = words(labels, "labels", LABELS)
    for label in chosen:
        if label != "time" and not all(source.audited for source in found):
            raise SceneError(
                f"labels: {label!r} is known of a Scene and of what simulate(…) gives, and of nothing else"
            )
    return chosen


@dataclass(frozen=True, eq=False)
class Bar:
    """A color bar with its text."""

    name: str
    low: str
    high: str
    table: FloatArray

    def width(self, text: int, length: float) -> int:
        """The width with this height of the text, if the bar is `length` heights long [pixels]."""
        return text_width(f"{self.name} {self.low}  ", text) + round(length * text) + text_width(f"  {self.high}", text)

    @classmethod
    def of(cls, scale: Scale, units: UnitSystem = SI) -> Bar:
        """The color bar of a scale in units of a scene. A dimensionless scale that is symmetric about zero, as of
        strain, is in percent.
        """
        low, high = scale.ends
        percent = not scale.unit and low == -high
        unit = "%" if percent else units.symbol(scale.unit)
        texts = ends(100.0 * low, 100.0 * high) if percent else ends(low, high)
        return cls(f"{scale.quantity} [{unit}]" if unit else scale.quantity, *texts, scale.table)


def bars(scales: Sequence[Scale | None], units: UnitSystem = SI) -> list[Bar]:
    """The color bars of all scales that are not empty, without duplicates."""
    result: dict[tuple[object, ...], Bar] = {}
    for scale in scales:
        if scale is not None and scale.ends[0] != scale.ends[1] and all(map(math.isfinite, scale.ends)):
            key = (scale.quantity, scale.unit, scale.ends, scale.table.tobytes())
            result.setdefault(key, Bar.of(scale, units))
    return list(result.values())


class Footer:
    """The lines below the picture.

    Args:
        labels: the labels to write.
        clock: the time labels.
        facts: the integrator's name and the time step [s] of each panel, as far as they are labels.
        scales: the color bars.
        figure, credit: small text at the bottom, at the left and at the right; empty: none.
        legend: names with their colors, in separate lines above all others.
        units: the units of the scene.
    """

    def __init__(
        self,
        labels: Sequence[Label],
        clock: Clock,
        facts: Sequence[tuple[str | None, float | None]],
        scales: Sequence[Bar],
        figure: str = "",
        credit: str = "",
        legend: Sequence[tuple[str, Color]] = (),
        units: UnitSystem = SI,
    ) -> None:
        self._dt = units.suffix("s")
        self._labels, self._clock, self._facts, self._bars = labels, clock, facts, scales
        self._figure, self._credit, self._legend = figure, credit, legend
        self._drifts = [Drift() for _ in facts]

    def begin(self) -> None:
        """Reset the energy drifts at the start of the film."""
        self._drifts = [Drift() for _ in self._facts]

    def go_on(self, before: Footer) -> None:
        """Go on with the energy drifts of an earlier footer."""
        self._drifts = before._drifts

    def height(self, text: int, width: int) -> int:
        """The height of the footer in a picture of this width, with a text of this height [pixels]."""
        own, common = self._lines(text, width, [0.0] * len(self._facts), self._clock.times[0])
        count = len(self._names(text, width)) + max(map(len, own)) + bool(common or self._bars)
        return round(LINE * text * count) + len(self._notes(text, width)) * round(LINE * SMALL * text)

    def line(self, time: float, energies: Sequence[Energy | None]) -> str:
        """All labels of a frame at a time [s] in one line. Every frame must be asked for once, in order."""
        errors = [0.0 if now is None else drift.add(now) for drift, now in zip(self._drifts, energies, strict=True)]
        own, common = self._lines(1, WIDE, errors, time)
        return GAP.join(filter(None, [common, *(piece for lines in own for piece in lines)]))

    @property
    def parts(self) -> tuple[Sequence[Bar], Sequence[tuple[str, Color]], tuple[str, str]]:
        """The color bars, the names of the legend with their colors, and figure and credit."""
        return self._bars, self._legend, (self._figure, self._credit)

    def draw(
        self,
        canvas: Canvas,
        size: tuple[int, int],
        text: int,
        theme: Theme,
        time: float,
        energies: list[Energy | None],
        *,
        over: bool = False,
    ) -> None:
        """Write the footer of a frame at a time [s]. Every frame must be drawn once, in order. `over` tells whether the
        text may lie over moving objects.
        """
        width, height = size
        pen = partial(write, canvas, outline=theme.background if over else None)
        for notes in reversed(self._notes(text, width)):
            for line, end, align in notes:
                small = fitting(line, round(SMALL * text), width - text)
                pen(line, end, height - round(1.2 * small), small, theme.label, align)
            height -= round(LINE * SMALL * text)
        errors = [0.0 if now is None else drift.add(now) for drift, now in zip(self._drifts, energies, strict=True)]
        own, common = self._lines(text, width, errors, time)
        pen(common, text // 2, height - round(1.2 * text), text, theme.label)
        rows = max(map(len, own)) + bool(common or self._bars)
        for row, lines in enumerate(zip_longest(*own, fillvalue="")):
            high = min(fitting(line, text, width // len(own) - text) for line in lines)
            top = height - round((LINE * (rows - row) - 0.1) * text)
            for panel, line in enumerate(lines):
                pen(line, width * panel // len(own) + text // 2, top, high, theme.label)
        self._draw_legend(pen, (width, height), text, theme.text, rows)
        taken = text_width(common + GAP, text) if common else 0
        self._draw_bars(canvas, pen, (width, height), text, theme.label, taken)

    def _notes(self, text: int, width: int) -> list[list[tuple[str, int, int]]]:
        """The rows of small text at the bottom: lines with the place of their end and their alignment."""
        small, edge = round(SMALL * text), text // 2
        lines = [(line, edge, -1) for line in broken(self._figure, small, width - text)]
        credit = [(self._credit, width - edge, 1)] if self._credit else []
        together = text_width(f"{self._figure}{GAP}{self._credit}", small) <= width - text
        return [each for each in ([[*lines, *credit]] if together else [*([line] for line in lines), credit]) if each]

    def _lines(self, text: int, width: int, errors: Sequence[float], time: float) -> tuple[list[list[str]], str]:
        """The lines of each panel, and the common line."""
        each = width // len(errors) - text
        pieces = [self._own(panel, error, text, each) for panel, error in enumerate(errors)]
        times = [self._clock.text(time), self._clock.pace] if "time" in self._labels else []
        common = GAP.join(filter(None, times))
        if len(pieces) == 1:
            line = GAP.join(piece for piece in (common, *pieces[0]) if piece)
            needed = [text_width(line, text), *(bar.width(text, WIDEST) for bar in self._bars)]
            if sum(needed) + text_width(GAP, text) * (len(needed) - 1) <= width - text:
                return [[]], line
        return [[GAP.join(line) for line in wrapped(own, text, each)] for own in pieces], common

    def _own(self, panel: int, error: float, text: int, room: int) -> list[str]:
        """The labels of one panel, of constant width; abbreviated if there is little room."""
        integrator, dt = self._facts[panel]
        drift = f"{error:.1e}".replace("e-", "e−")  # the minus sign U+2212 is as wide as a plus sign
        long = f"energy error {drift}"
        said = {
            "integrator": integrator,
            "dt": f"dt {dt or 0.0:.3g}{self._dt}",
            "energy": long if text_width(long, text) <= room else f"error {drift}",
        }
        return [said[label] or "" for label in self._labels if label != "time"]

    def _names(self, text: int, width: int) -> list[list[str]]:
        """The lines of the legend."""
        return wrapped([f"{MARK} {name}" for name, _ in self._legend], text, width - text)

    def _draw_legend(
        self, pen: Callable[..., None], size: tuple[int, int], text: int, color: Color, below: int
    ) -> None:
        """Write the lines of the legend, with `below` other lines under it."""
        width, height = size
        lines, colors = self._names(text, width), iter(self._legend)
        for row, line in enumerate(lines):
            x, top = text // 2, height - round((LINE * (len(lines) + below - row) - 0.1) * text)
            high = fitting(GAP.join(line), text, width - text)
            for piece, (name, own) in zip(line, colors, strict=False):
                pen(MARK, x, top, high, own)
                pen(name, x + text_width(f"{MARK} ", high), top, high, color)
                x += text_width(piece + GAP, high)

    def _draw_bars(
        self, canvas: Canvas, pen: Callable[..., None], size: tuple[int, int], text: int, color: Color, taken: int
    ) -> None:
        """Draw as many color bars as there is room for, from the right."""
        width, height = size
        top, right, left = height - round(1.2 * text), width - text // 2, text // 2 + taken
        for bar in reversed(self._bars):
            length = next((n for n in (WIDEST, NARROWEST) if right - bar.width(text, n) >= left), None)
            if length is None:
                return
            start = right - bar.width(text, length)
            pen(f"{bar.name} {bar.low}", start, top, text, color)
            pen(bar.high, right, top, text, color, 1)
            x = start + text_width(f"{bar.name} {bar.low}  ", text) + np.arange(round(length * text)) + 0.5
            middle, half = top + 0.54 * text, THICK * text / 2
            lines = np.stack([x, np.full_like(x, middle - half), x, np.full_like(x, middle + half)], axis=1)
            inks = np.full((len(x), 4), 255, dtype=np.uint8)
            inks[:, :3] = look_up(bar.table, np.linspace(0.0, 1.0, len(x)))
            canvas.lines(lines.astype(np.float32), np.ones(len(x), dtype=np.float32), inks)
            canvas.paint()
            right = start - text_width(GAP, text)
