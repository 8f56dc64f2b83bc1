"""Layout of a picture: panels in rows or one after the other, titles above, lines of text below."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from physcore.checks import count as whole_number
from physcore.checks import shown, word
from physcore.errors import SceneError
from physcore.film.labels.heading import LEADING, SUBTITLE, Heading, Line
from physcore.film.labels.parameters import ParameterBar
from physcore.film.labels.text import text_height

MARGIN = 0.03
"""Margin around the motion, as a fraction of a panel's shorter side."""
LARGEST = 16384
"""Longest side of a picture [pixels]; a square picture of this size takes a gigabyte."""
ASPECTS = (4 / 3, 1.0, 3 / 4, 16 / 9, 9 / 16, 2.4)
"""Candidate aspect ratios of the panels (width over height). The first is taken unless another is clearly better."""
PIXELS = 640 * 480
"""Area of a panel [pixels]; more than two panels in a row share the area of two, and all panels that of four."""
ROW = 4
"""Largest number of panels that are in one row if nothing else is asked for."""
Arrangement = Literal["panels", "sequence"]
ARRANGEMENTS: tuple[Arrangement, ...] = ("panels", "sequence")
"""Recordings beside each other, or one after the other."""
WIDEST = 1280
"""Largest width of a picture whose size was not given [pixels]."""
CLEARLY = 1.1
"""Factor by which another format must show the motion larger than the first."""
Format = Literal["square", "wide", "story"]
FORMATS: dict[Format, tuple[int, int]] = {"square": (480, 480), "wide": (640, 360), "story": (360, 640)}
"""Common formats: 1 : 1, 16 : 9 and 9 : 16 [pixels]."""
VIDEO: dict[Format, tuple[int, int]] = {"square": (1080, 1080), "wide": (1920, 1080), "story": (1080, 1920)}
"""Common formats of videos, in which pixels take few bytes [pixels]."""


@dataclass(frozen=True)
class Layout:
    """A picture of a given size with its panels."""

    size: tuple[int, int]
    panels: int
    heading: Heading
    columns: int
    """Number of panels side by side."""
    footer: int = 0
    """Height of the lines below the panels [pixels]."""
    in_turn: bool = False
    """Whether the panels are shown one after the other, each in the whole picture."""

    @property
    def rows(self) -> int:
        """The number of rows of panels."""
        return 1 if self.in_turn else math.ceil(self.panels / self.columns)

    @property
    def text(self) -> int:
        """The height of a line of text, smaller if there are several rows [pixels]."""
        return text_height(self.size[0], self.size[1] // self.rows)

    @property
    def bar_text(self) -> int:
        """The height of the text of bars and diagrams [pixels]."""
        return round(SUBTITLE * self.text)

    def written(self, shown: Sequence[int]) -> list[Line]:
        """The lines above some panels, in pixels of the picture."""
        width = self.size[0]
        lines = [replace(line, top=line.top + self._edge) for line in self.heading.common(self.text, width)[0]]
        for index in shown:
            left, _, right, _ = self.panel(index)
            first = self._first(index)
            own, _ = self.heading.own(index, self.text, right - left)
            lines += [replace(line, left=left + line.left, top=first + line.top) for line in own]
        return lines

    def bars(self, index: int) -> list[tuple[ParameterBar, tuple[int, int, int]]]:
        """The bars of a panel, each with its left, top and right [pixels]."""
        if not self.heading.bars:
            return []
        left, _, right, _ = self.panel(index)
        line, edge = LEADING * SUBTITLE * self.text, self.text // 2
        own = self.heading.bars[index]
        below = self._first(index) + self.heading.own(index, self.text, right - left)[1] - round(len(own) * line)
        return [(bar, (left + edge, below + round(number * line), right - edge)) for number, bar in enumerate(own)]

    def panel(self, index: int) -> tuple[int, int, int, int]:
        """Left, top, right and bottom of a panel [pixels]. A single row has the height of the picture."""
        width, height = self.size
        if self.in_turn:
            return 0, 0, width, height
        row, column = divmod(index, self.columns)
        left, right = width * column // self.columns, width * (column + 1) // self.columns
        if self.rows == 1:
            return left, 0, right, height
        top = min(self._header, height - self.rows)
        free = max(height - self.footer - top, self.rows)
        return left, top + free * row // self.rows, right, top + free * (row + 1) // self.rows

    def area(self, index: int) -> tuple[int, int, int, int]:
        """The part of a panel that is free of text."""
        left, above, right, bottom = self.panel(index)
        own = self.heading.own(index, self.text, right - left)[1]
        # At least one row of pixels is left free of text.
        top = min(self._first(index) + own if own else max(above, self._header), bottom - 1)
        return left, top, right, max(bottom - self.footer * (self.rows == 1), top + 1)

    @property
    def _header(self) -> int:
        """The height of the lines above all panels with the distance from the edge; zero without lines [pixels]."""
        height = self.heading.common(self.text, self.size[0])[1]
        return height + self._edge * (height > 0)

    def _first(self, index: int) -> int:
        """The top of a panel's own lines [pixels]."""
        header = self._header
        return (header or self._edge) if self.rows == 1 else self.panel(index)[1] + self._edge

    @property
    def _edge(self) -> int:
        """Distance of the first line from an edge [pixels]."""
        return round(0.3 * self.text)

    def pixels(self, index: int) -> float:
        """The area of a panel [pixels]."""
        left, top, right, bottom = self.panel(index)
        return float((right - left) * (bottom - top))

    def margin(self, index: int) -> float:
        """The margin around the motion [pixels]."""
        left, top, right, bottom = self.panel(index)
        return MARGIN * min(right - left, bottom - top)


def check_size(size: object) -> tuple[int, int] | None:
    """The requested size.

    Raises:
        SceneError: the value is not a valid size.
    """
    if size is None:
        return None
    if not isinstance(size, (tuple, list)) or len(size) != 2:
        raise SceneError(f"size: must be (width, height) in pixels, got {shown(size)}")
    width, height = (whole_number(side, f"size[{axis}]", least=16, most=LARGEST) for axis, side in enumerate(size))
    return width, height


def check_format(format: object, size: tuple[int, int] | None, *, video: bool) -> tuple[int, int] | None:
    """The size of the requested format, or `size` if there is none.

    Raises:
        SceneError: there is no such format, or a size was given too.
    """
    if format is None:
        return size
    if size is not None:
        raise SceneError("format: give a format or a size, not both")
    chosen = word(format, "format", (*FORMATS,))
    return VIDEO[chosen] if video else FORMATS[chosen]


def columns_for(columns: object, panels: int) -> int:
    """The number of panels side by side; None: all of up to four, otherwise as many as there are rows, or one more.

    Raises:
        SceneError: the value is not a number of panels.
    """
    if columns is None:
        return panels if panels <= ROW else math.ceil(math.sqrt(panels))
    return min(whole_number(columns, "columns", least=1), panels)


def sizes(columns: int, rows: int = 1) -> list[tuple[int, int]]:
    """Candidate sizes, all of about equal area: 640 × 480 for one panel, at most 1280 wide for several."""
    pixels = min(PIXELS, 2 * PIXELS / columns, 4 * PIXELS / (columns * rows))
    result = []
    for aspect in ASPECTS:
        width = min(math.sqrt(pixels * aspect), WIDEST / columns)
        result.append((_even(columns * width), _even(rows * width / aspect)))
    return result


def best(columns: int, rows: int, magnification: Callable[[tuple[int, int]], float], *, fixed: bool) -> tuple[int, int]:
    """The size that shows the motion largest, or the default if no other is clearly better.

    Args:
        columns: the number of panels side by side.
        rows: the number of rows of panels.
        magnification: gives the pixels per meter in a picture of some size.
        fixed: whether the extent of the view was given, so that the default size is taken.
    """
    usual, *others = sizes(columns, rows)
    if fixed:
        return usual
    scales = {size: magnification(size) for size in others}
    largest = max(others, key=lambda size: scales[size])
    return largest if scales[largest] > CLEARLY * magnification(usual) else usual


def _even(side: float) -> int:
    """The nearest even number of pixels, as video needs."""
    return 2 * round(side / 2)
