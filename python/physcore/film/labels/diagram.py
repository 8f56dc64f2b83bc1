"""Inset of a panel: a small diagram of energy against time, drawn while the film plays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from physcore._core import Canvas, text_width
from physcore.checks import FloatArray, is_word, shown
from physcore.errors import SceneError
from physcore.film.camera.view import Area, PixelArray
from physcore.film.colors.themes import Color, Theme
from physcore.film.labels.drawing import stroke
from physcore.film.labels.text import GAP, ends, wrapped
from physcore.simulation.energy import Energy
from physcore.simulation.sources import Source
from physcore.units.systems import SI, UnitSystem

Inset = Literal["energy"]
WIDTH, HEIGHT = 0.4, 0.36
"""Width and height of the diagram, as fractions of its panel."""
LEAST_LEGEND = "potential   internal"
"""Text that determines the least width of the legend: two words side by side."""
LEAST = (140, 110)
"""Width and height of the smallest panel with room for a diagram [pixels]."""
OPACITY = 215
"""Opacity of its background, out of 255: moving objects behind it remain visible, and the curves stand out."""
FRAME = 90
"""Opacity of its frame, out of 255."""


def check_inset(inset: object, found: Sequence[Source]) -> Inset | None:
    """The requested diagram.

    Raises:
        SceneError: there is no such diagram, or its energies were not recorded.
    """
    if inset is not None and not is_word(inset, "energy"):
        raise SceneError(f"inset: must be 'energy' or None, got {shown(inset)}")
    if inset is not None and not all(source.audited for source in found):
        raise SceneError("inset: 'energy' is known of a Scene and of what simulate(…) gives, and of nothing else")
    return None if inset is None else "energy"


@dataclass(frozen=True, eq=False)
class History:
    """Energies of all panels: names of the curves, and ranges for the whole film."""

    energies: Sequence[Sequence[Energy]]
    """The energies of each panel, frame by frame."""
    duration: float
    """Time from the first to the last frame [s]."""
    units: UnitSystem = SI
    """Units of the scene."""

    @property
    def names(self) -> list[str]:
        """The names of the curves; internal energy only if it is not zero."""
        internal = any(energy.internal != 0.0 for panel in self.energies for energy in panel)
        return ["kinetic", "potential", *(["internal"] if internal else []), "total"]

    def curves(self, panel: int) -> FloatArray:
        """Energies (C, F) [J] of one panel."""
        return np.array([[getattr(energy, name) for energy in self.energies[panel]] for name in self.names])

    @property
    def range(self) -> tuple[float, float]:
        """The least and the largest energy of all panels, including zero [J]."""
        values = np.concatenate([self.curves(panel).ravel() for panel in range(len(self.energies))])
        finite = values[np.isfinite(values)]
        return min(float(finite.min(initial=0.0)), 0.0), max(float(finite.max(initial=0.0)), 0.0)


class Diagram:
    """The diagram of one panel.

    Args:
        history: the energies.
        panel: the number of the panel.
        area: the part of the panel that is free of text.
        text: the height of its text [pixels].
        theme: the colors.
        occupied: positions of particles in sampled frames (N, 2) [pixels]; the diagram takes the emptiest corner.

    Raises:
        SceneError: the panel is too small.
    """

    def __init__(self, history: History, panel: int, area: Area, text: int, theme: Theme, occupied: PixelArray) -> None:
        left, top, right, bottom = area
        if right - left < LEAST[0] or bottom - top < LEAST[1]:
            raise SceneError(
                f"size: a panel with an inset needs {LEAST[0]} × {LEAST[1]} pixels beside its text, got "
                f"{right - left:g} × {bottom - top:g}"
            )
        self._text, self._theme, self._names, self._unit = text, theme, history.names, history.units.suffix("J")
        pad = text // 3
        room = max(text_width(LEAST_LEGEND, text), round(WIDTH * (right - left)) - 2 * pad)
        self._words = self._legend(room, ends(*history.range))
        width = room + 2 * pad
        height = max(HEIGHT * (bottom - top), (len(self._words) + 1.5) * text + 2 * pad)
        self._box = _corner(area, width, height, text // 2, occupied)
        inner = self._box[0] + pad, self._box[1] + pad + len(self._words) * text, self._box[2] - pad, self._box[3] - pad
        self._pad, self._lines = pad, self._placed(history, panel, inner)
        low, high = history.range
        self._zero = inner[3] + (inner[3] - inner[1]) * low / ((high - low) or 1.0)
        self._sides = inner[0], inner[2]

    @property
    def box(self) -> Area:
        """The rectangle of the diagram [pixels]."""
        return self._box

    @property
    def colors(self) -> list[Color]:
        """The color of each curve; the total energy has the color of the text."""
        return [*self._theme.bodies[: len(self._names) - 1], self._theme.text]

    def draw(self, canvas: Canvas, frame: int) -> None:
        """Draw the diagram over a painted panel, with the curves up to a frame."""
        left, top, right, bottom = self._box
        corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]], dtype=np.float32)
        canvas.polygon(corners, (*self._theme.background, OPACITY))
        self._write(canvas)
        stroke(canvas, np.concatenate([corners, corners[:1]]), self._theme.edge, 1.0, alpha=FRAME)
        stroke(canvas, np.array([[self._sides[0], self._zero], [self._sides[1], self._zero]]), self._theme.edge, 1.0)
        width = self._text / 10
        # The total energy is drawn first and twice as wide, so that it stays visible below an equal curve.
        for curve, color in reversed(list(zip(self._lines, self.colors, strict=True))):
            drawn, own = curve[: frame + 1], 2.0 * width if curve is self._lines[-1] else width
            keep = np.unique((2.0 * drawn[:, 0]).round(), return_index=True)[1]  # at most one point per half pixel
            stroke(canvas, np.concatenate([drawn[keep], drawn[-1:]]), color, own)
            ink = np.array([[*color, 255]], dtype=np.uint8)
            canvas.discs(drawn[-1:].astype(np.float32), np.array([0.7 * own + 1.0], dtype=np.float32), ink)
        canvas.paint()

    def _legend(self, room: int, limits: tuple[str, str]) -> list[list[tuple[str, int | None]]]:
        """The lines of the legend: words, each with the index of its curve."""
        ends = f"{limits[0]} to {limits[1]}"
        unit = self._unit.strip()
        # A long unit has a line of its own.
        forms = ([f"energy {ends}{self._unit}"], [f"{ends}{self._unit}"], [f"energy [{unit}]", ends], [unit, ends])
        fits = (form for form in forms if text_width(form[0], self._text) <= room)
        heads = next(fits, forms[-1]) if unit else next(fits, [ends])
        legend: list[list[tuple[str, int | None]]] = [[(head, None)] for head in heads]
        lines = wrapped(self._names, self._text, room)
        return legend + [[(name, self._names.index(name)) for name in line] for line in lines]

    def _write(self, canvas: Canvas) -> None:
        """Write the range and the legend."""
        for row, words in enumerate(self._words):
            x, y = round(self._box[0]) + self._pad, round(self._box[1]) + self._pad // 2 + row * self._text
            for word, curve in words:
                color = self._theme.label if curve is None else self.colors[curve]
                canvas.text(word, x, y, self._text, (*color, 255), -1)
                x += text_width(word + GAP, self._text)

    def _placed(self, history: History, panel: int, inner: Area) -> list[FloatArray]:
        """The points (F, 2) of each curve [pixels]."""
        left, top, right, bottom = inner
        low, high = history.range
        times = np.array([energy.time for energy in history.energies[panel]])
        x = left + (right - left) * (times - times[:1]) / (history.duration or 1.0)
        curves = history.curves(panel)
        return [
            np.stack([x, bottom - (bottom - top) * (curve - low) / ((high - low) or 1.0)], axis=1) for curve in curves
        ]


def _corner(area: Area, width: float, height: float, gap: float, occupied: PixelArray) -> Area:
    """The emptiest corner of an area. Among equally empty corners, the order is upper right, upper left, lower right,
    lower left.
    """
    left, top, right, bottom = area
    xs, ys = {"right": right - gap - width, "left": left + gap}, {"upper": top + gap, "lower": bottom - gap - height}
    boxes = [(x, y, x + width, y + height) for y in ys.values() for x in xs.values()]

    def count(box: Area) -> int:
        return int(((occupied >= box[:2]) & (occupied <= box[2:])).all(axis=1).sum())

    return min(boxes, key=count)
