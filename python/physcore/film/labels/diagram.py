"""Inset of a panel: a small diagram that is drawn while the film plays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from physcore._core import Canvas, text_width
from physcore.checks import FloatArray
from physcore.errors import SceneError
from physcore.film.camera.view import Area, PixelArray
from physcore.film.colors.themes import Color, Theme
from physcore.film.labels.curves import Graph
from physcore.film.labels.drawing import stroke
from physcore.film.labels.text import GAP, ends, wrapped

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


class Diagram:
    """The diagram of one panel.

    Args:
        graph: the curves.
        panel: the number of the panel.
        area: the part of the panel that is free of text.
        text: the height of its text [pixels].
        theme: the colors.
        occupied: positions of particles in sampled frames (N, 2) [pixels]; the diagram takes the emptiest corner.
        taken: the rectangles of other diagrams [pixels].

    Raises:
        SceneError: the panel is too small.
    """

    def __init__(
        self,
        graph: Graph,
        panel: int,
        area: Area,
        text: int,
        theme: Theme,
        occupied: PixelArray,
        taken: Sequence[Area] = (),
    ) -> None:
        left, top, right, bottom = area
        if right - left < LEAST[0] or bottom - top < LEAST[1]:
            raise SceneError(
                f"size: a panel with an inset needs {LEAST[0]} × {LEAST[1]} pixels beside its text, got "
                f"{right - left:g} × {bottom - top:g}"
            )
        self._text, self._theme, self._graph = text, theme, graph
        pad = text // 3
        room = max(text_width(LEAST_LEGEND, text), round(WIDTH * (right - left)) - 2 * pad)
        self._words = self._legend(room)
        self._axis = self._below(room)
        width = room + 2 * pad
        rows = len(self._words) + bool(self._axis)
        height = max(HEIGHT * (bottom - top), (rows + 1.5) * text + 2 * pad)
        self._box = _corner(area, width, height, text // 2, occupied, taken)
        first, last = self._box[1] + pad + len(self._words) * text, self._box[3] - pad - bool(self._axis) * text
        inner = self._box[0] + pad, first, self._box[2] - pad, last
        self._pad, self._lines = pad, self._placed(panel, inner)
        low, high = graph.range
        zero = 0.0 if low <= 0.0 <= high and not graph.logarithmic else low
        self._zero = inner[3] - (inner[3] - inner[1]) * (zero - low) / ((high - low) or 1.0)
        self._sides = inner[0], inner[2]

    @property
    def box(self) -> Area:
        """The rectangle of the diagram [pixels]."""
        return self._box

    @property
    def colors(self) -> list[Color]:
        """The color of each curve; a total has the color of the text."""
        count = max(len(self._graph.names), 1) - self._graph.total
        own = [self._theme.bodies[index % len(self._theme.bodies)] for index in range(count)]
        return [*own, self._theme.text] if self._graph.total else own

    def draw(self, canvas: Canvas, frame: int) -> None:
        """Draw the diagram over a painted panel: the curves up to a frame, or the curve of this frame."""
        left, top, right, bottom = self._box
        corners = np.array([[left, top], [right, top], [right, bottom], [left, bottom]], dtype=np.float32)
        canvas.polygon(corners, (*self._theme.background, OPACITY))
        self._write(canvas)
        stroke(canvas, np.concatenate([corners, corners[:1]]), self._theme.edge, 1.0, alpha=FRAME)
        stroke(canvas, np.array([[self._sides[0], self._zero], [self._sides[1], self._zero]]), self._theme.edge, 1.0)
        width = self._text / 10
        if self._graph.anew:
            line = self._lines[min(frame, len(self._lines) - 1)]
            self._trace(canvas, line, self.colors[0], 1.5 * width)
            canvas.paint()
            return
        # A total is drawn first and twice as wide, so that it stays visible below an equal curve.
        for index, color in reversed(list(enumerate(self.colors))):
            drawn = self._lines[index][: frame + 1]
            own = 2.0 * width if self._graph.total and index == len(self._lines) - 1 else width
            drawn = drawn[np.isfinite(drawn).all(axis=1)]
            if len(drawn) == 0:
                continue
            self._trace(canvas, drawn, color, own)
            ink = np.array([[*color, 255]], dtype=np.uint8)
            canvas.discs(drawn[-1:].astype(np.float32), np.array([0.7 * own + 1.0], dtype=np.float32), ink)
        canvas.paint()

    def _trace(self, canvas: Canvas, line: FloatArray, color: Color, width: float) -> None:
        """Draw a curve, with at most one point per half pixel."""
        line = line[np.isfinite(line).all(axis=1)]
        if len(line) > 1:
            keep = np.unique((2.0 * line[:, 0]).round(), return_index=True)[1]
            stroke(canvas, np.concatenate([line[keep], line[-1:]]), color, width)

    def _legend(self, room: int) -> list[list[tuple[str, int | None]]]:
        """The lines of the legend: words, each with the index of its curve."""
        graph, range_ = self._graph, " to ".join(self._graph.ends)
        label, unit = graph.label, graph.unit
        # What is too long has a line of its own.
        whole = " ".join(filter(None, (label, range_, unit)))
        named = f"{label} [{unit}]" if label and unit else label or unit
        forms = ([whole], [f"{range_} {unit}"] if graph.total else [named, range_], [named, range_], [unit, range_])
        fits = (form for form in forms if all(text_width(line, self._text) <= room for line in form))
        heads = [line for line in next(fits, forms[-1]) if line]
        legend: list[list[tuple[str, int | None]]] = [[(head, None)] for head in heads]
        lines = wrapped(graph.names, self._text, room) if graph.names else []
        return legend + [[(name, graph.names.index(name)) for name in line] for line in lines]

    def _below(self, room: int) -> str:
        """The name of the horizontal axis with its ends; empty without a name."""
        if not self._graph.axis:
            return ""
        low, high = ends(*self._graph.across)
        whole = f"{self._graph.axis} {low} to {high}"
        return whole if text_width(whole, self._text) <= room else f"{low} to {high}"

    def _write(self, canvas: Canvas) -> None:
        """Write the range, the legend and the name of the axis."""
        left, color = round(self._box[0]) + self._pad, (*self._theme.label, 255)
        for row, words in enumerate(self._words):
            x, y = left, round(self._box[1]) + self._pad // 2 + row * self._text
            for word, curve in words:
                ink = color if curve is None else (*self.colors[curve], 255)
                canvas.text(word, x, y, self._text, ink, -1)
                x += text_width(word + GAP, self._text)
        if self._axis:
            canvas.text(self._axis, left, round(self._box[3]) - self._pad // 2 - self._text, self._text, color, -1)

    def _placed(self, panel: int, inner: Area) -> list[FloatArray]:
        """The points (F, 2) of each curve, or (K, 2) of each frame [pixels]."""
        left, top, right, bottom = inner
        (low, high), (start, end) = self._graph.range, self._graph.across
        x = left + (right - left) * (self._graph.places[panel] - start) / ((end - start) or 1.0)
        share = (self._graph.values[panel] - low) / ((high - low) or 1.0)
        return [np.stack([x, bottom - (bottom - top) * each], axis=1) for each in share]


def _corner(
    area: Area, width: float, height: float, gap: float, occupied: PixelArray, taken: Sequence[Area] = ()
) -> Area:
    """The emptiest corner of an area beside some rectangles. Among equally empty corners, the order is upper right,
    upper left, lower right, lower left.

    Raises:
        SceneError: no corner is free.
    """
    left, top, right, bottom = area
    xs, ys = {"right": right - gap - width, "left": left + gap}, {"upper": top + gap, "lower": bottom - gap - height}
    boxes = [(x, y, x + width, y + height) for y in ys.values() for x in xs.values()]
    free = [
        box
        for box in boxes
        if all(box[0] >= one[2] or box[2] <= one[0] or box[1] >= one[3] or box[3] <= one[1] for one in taken)
    ]
    if not free:
        raise SceneError(
            f"size: {len(taken) + 1} insets need a larger panel than {right - left:g} × {bottom - top:g} pixels beside "
            "its text"
        )

    def count(box: Area) -> int:
        return int(((occupied >= box[:2]) & (occupied <= box[2:])).all(axis=1).sum())

    return min(free, key=count)
