"""Inset of a panel: a small diagram that is drawn while the film plays."""

from __future__ import annotations

import numpy as np

from physcore._core import Canvas, text_width
from physcore.checks import FloatArray
from physcore.errors import SceneError
from physcore.film.camera.view import Area
from physcore.film.colors.themes import Color, Theme
from physcore.film.labels.curves import Graph
from physcore.film.labels.drawing import stroke
from physcore.film.labels.text import GAP, ends, wrapped

SHARE = 0.36
"""Share of a panel that diagrams take: of its width beside the picture, or of its height below it."""
MOST = 0.6
"""Largest share of the width, where the text needs more."""
TALLEST = 0.8
"""Largest height of a diagram, over its width."""
LEAST_LEGEND = "potential   internal"
"""Text that determines the least width of the legend: two words side by side."""
LEAST = 1.5
"""Least height of the curves, in heights of the text."""
OPACITY = 215
"""Opacity of its background, out of 255: moving objects behind it remain visible, and the curves stand out."""
FRAME = 90
"""Opacity of its frame, out of 255."""


def beside(area: Area, count: int, text: int) -> tuple[Area, list[Area]]:
    """Divide an area between the picture and some diagrams: at its right in a wide area, below it in a tall one.

    Raises:
        SceneError: the area is too small.
    """
    left, top, right, bottom = area
    width, height, gap = right - left, bottom - top, text // 2
    if count == 0:
        return area, []
    least = text_width(LEAST_LEGEND, text) + 2 * (text // 3)
    wide = width >= height
    across = max(SHARE * width, least) if wide else (width - gap * (count + 1)) / count
    down = min(height / count - gap if wide else SHARE * height, TALLEST * across)
    if across < least or across > (MOST * width if wide else width) or down < 4.0 * text:
        raise SceneError(
            f"size: a panel with {count} inset{'s' * (count > 1)} needs more than {width:g} × {height:g} pixels beside "
            "its text"
        )
    if wide:
        first = (top + bottom - count * down - (count - 1) * gap) / 2
        start, tops = right - gap - across, [first + number * (down + gap) for number in range(count)]
        return (left, top, start, bottom), [(start, each, start + across, each + down) for each in tops]
    low = bottom - gap - down
    starts = [left + gap + number * (across + gap) for number in range(count)]
    return (left, top, right, low), [(each, low, each + across, low + down) for each in starts]


class Diagram:
    """The diagram of one panel.

    Args:
        graph: the curves.
        panel: the number of the panel.
        box: its rectangle [pixels].
        text: the height of its text [pixels].
        theme: the colors.

    Raises:
        SceneError: the rectangle is too small.
    """

    def __init__(self, graph: Graph, panel: int, box: Area, text: int, theme: Theme) -> None:
        self._text, self._theme, self._graph, self._box = text, theme, graph, box
        pad = text // 3
        room = round(box[2] - box[0]) - 2 * pad
        self._words, self._axis = self._legend(room), self._below(room)
        first, last = box[1] + pad + len(self._words) * text, box[3] - pad - bool(self._axis) * text
        if last - first < LEAST * text:
            needed = round(box[3] - box[1] + LEAST * text - (last - first))
            raise SceneError(f"size: an inset with these labels needs {needed} pixels, got {box[3] - box[1]:.0f}")
        inner = box[0] + pad, first, box[2] - pad, last
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
