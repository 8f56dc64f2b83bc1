"""The footer of a film: the time, how it was computed, and what the colors mean."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray, words
from physcore.errors import SceneError
from physcore.film.colors.colormaps import look_up
from physcore.film.colors.themes import Color, Theme
from physcore.film.labels.text import GAP, advance, ends, wrapped
from physcore.film.styles.base import Scale
from physcore.simulation.energy import Drift, Energy
from physcore.simulation.sources import Source

Label = Literal["time", "dt", "integrator", "energy"]
LABELS: tuple[Label, ...] = ("time", "dt", "integrator", "energy")
"""The labels of the footer."""
LINE = 1.3
"""From one line to the next, in heights of the text."""
WIDEST, NARROWEST = 8, 4
"""Lengths of a color bar, in characters."""
THICK = 0.5
"""Thickness of a color bar, in heights of the text."""


def check_labels(labels: object, found: Sequence[Source]) -> tuple[Label, ...]:
    """The labels that were asked for.

    Raises:
        SceneError: they are not some of LABELS, or what they say was not recorded.
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
    """A scale of color with its words."""

    name: str
    low: str
    high: str
    table: FloatArray

    def columns(self, length: int) -> int:
        """Its width when the bar is so long, in characters."""
        return len(self.name) + len(self.low) + len(self.high) + length + 3

    @classmethod
    def of(cls, scale: Scale) -> Bar:
        """The bar of a scale; a ratio that is symmetric about zero, such as a strain, in percent."""
        low, high = scale.ends
        percent = not scale.unit and low == -high
        unit = "%" if percent else scale.unit
        texts = ends(100.0 * low, 100.0 * high) if percent else ends(low, high)
        return cls(f"{scale.quantity} [{unit}]" if unit else scale.quantity, *texts, scale.table)


def bars(scales: Sequence[Scale | None]) -> list[Bar]:
    """A bar for each of the scales that mean something, equal ones once."""
    result: dict[tuple[object, ...], Bar] = {}
    for scale in scales:
        if scale is not None and scale.ends[0] != scale.ends[1] and all(map(math.isfinite, scale.ends)):
            key = (scale.quantity, scale.unit, scale.ends, scale.table.tobytes())
            result.setdefault(key, Bar.of(scale))
    return list(result.values())


class Footer:
    """The lines below the picture.

    Args:
        labels: what is written.
        clock: the time of each frame of the film [s].
        fps: frames per second, which say how many decimals the time has.
        facts: the integrator's name and the time step [s] of each panel, as far as they are labels.
        scales: what colors mean.
    """

    def __init__(
        self,
        labels: Sequence[Label],
        clock: FloatArray,
        fps: float,
        facts: Sequence[tuple[str | None, float | None]],
        scales: Sequence[Bar],
    ) -> None:
        self._labels, self._clock, self._facts, self._bars = labels, clock, facts, scales
        self._decimals = max(2, math.ceil(math.log10(fps) - 1e-9))  # so that the time moves with each frame
        self._width = max((len(f"{time:.{self._decimals}f}") for time in clock[[0, -1]].tolist()), default=0)
        self._drifts = [Drift() for _ in facts]

    def begin(self) -> None:
        """Forget the energies: the film starts."""
        self._drifts = [Drift() for _ in self._facts]

    def height(self, text: int, width: int) -> int:
        """Its height in a picture of this width with a text of this height [pixels]."""
        own, common = self._lines(text, width, [0.0] * len(self._facts), 0)
        count = max(map(len, own)) + bool(common or self._bars)
        return round(LINE * text * count)

    def draw(
        self, canvas: Canvas, size: tuple[int, int], text: int, theme: Theme, frame: int, energies: list[Energy | None]
    ) -> None:
        """Write the lines of a frame; every frame of a film is to be drawn once, in order."""
        width, height = size
        errors = [0.0 if now is None else drift.add(now) for drift, now in zip(self._drifts, energies, strict=True)]
        own, common = self._lines(text, width, errors, frame)
        ink = (*theme.label, 255)
        canvas.text(common, text // 2, height - round(1.2 * text), text, ink, -1)
        rows = max(map(len, own)) + bool(common or self._bars)
        for panel, lines in enumerate(own):
            left = width * panel // len(own) + text // 2
            for row, line in enumerate(lines):
                canvas.text(line, left, height - round((LINE * (rows - row) - 0.1) * text), text, ink, -1)
        self._draw_bars(canvas, size, text, theme.label, len(common))

    def _lines(self, text: int, width: int, errors: Sequence[float], frame: int) -> tuple[list[list[str]], str]:
        """The lines of each panel, and the one for all."""
        pieces = [self._own(panel, error) for panel, error in enumerate(errors)]
        time = f"{self._clock[frame]:{self._width}.{self._decimals}f} s" if "time" in self._labels else ""
        columns = (width - text) // advance(text)
        if len(pieces) == 1:
            line = GAP.join(piece for piece in (time, *pieces[0]) if piece)
            needed = [len(line), *(bar.columns(WIDEST) for bar in self._bars)]
            if sum(needed) + len(GAP) * (len(needed) - 1) <= columns:
                return [[]], line
        each = (width // len(pieces) - text) // advance(text)
        return [wrapped(own, each) for own in pieces], time

    def _own(self, panel: int, error: float) -> list[str]:
        """The labels of one panel, always in the same width."""
        integrator, dt = self._facts[panel]
        said = {"integrator": integrator, "dt": f"dt {dt or 0.0:.3g} s", "energy": f"energy error {error:.1e}"}
        return [said[label] or "" for label in self._labels if label != "time"]

    def _draw_bars(self, canvas: Canvas, size: tuple[int, int], text: int, color: Color, taken: int) -> None:
        """As many bars as there is room for, from the right."""
        width, height = size
        pitch, top = advance(text), height - round(1.2 * text)
        right, left = width - text // 2, text // 2 + (taken + len(GAP) * (taken > 0)) * pitch
        for bar in reversed(self._bars):
            length = next((n for n in (WIDEST, NARROWEST) if right - bar.columns(n) * pitch >= left), None)
            if length is None:
                return
            start = right - bar.columns(length) * pitch
            canvas.text(f"{bar.name} {bar.low}", start, top, text, (*color, 255), -1)
            canvas.text(bar.high, right, top, text, (*color, 255), 1)
            x = start + (len(bar.name) + len(bar.low) + 2) * pitch + np.arange(length * pitch) + 0.5
            middle, half = top + 0.54 * text, THICK * text / 2
            lines = np.stack([x, np.full_like(x, middle - half), x, np.full_like(x, middle + half)], axis=1)
            inks = np.full((len(x), 4), 255, dtype=np.uint8)
            inks[:, :3] = look_up(bar.table, np.linspace(0.0, 1.0, len(x)))
            canvas.lines(lines.astype(np.float32), np.ones(len(x), dtype=np.float32), inks)
            canvas.paint()
            right = start - len(GAP) * pitch
