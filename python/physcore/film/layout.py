"""Layout of a picture: panels side by side, titles above, lines of text below."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from physcore.checks import count as whole_number
from physcore.checks import items, shown, text, word
from physcore.errors import SceneError
from physcore.film.labels.text import fitting, text_height, warn_of_missing

MARGIN = 0.03
"""Margin around the motion, as a fraction of a panel's shorter side."""
LARGEST = 16384
"""Longest side of a picture [pixels]; a square picture of this size takes a gigabyte."""
ASPECTS = (4 / 3, 1.0, 3 / 4, 16 / 9, 9 / 16, 2.4)
"""Candidate aspect ratios of the panels (width over height). The first is taken unless another is clearly better."""
PIXELS = 640 * 480
"""Area of a panel [pixels]; more than two panels share the area of two."""
WIDEST = 1280
"""Largest width of a picture whose size was not given [pixels]."""
CLEARLY = 1.1
"""Factor by which another format must show the motion larger than the first."""
Format = Literal["square", "wide", "story"]
FORMATS: dict[Format, tuple[int, int]] = {"square": (480, 480), "wide": (640, 360), "story": (360, 640)}
"""Common formats: 1 : 1, 16 : 9 and 9 : 16 [pixels]."""
VIDEO: dict[Format, tuple[int, int]] = {"square": (1080, 1080), "wide": (1920, 1080), "story": (1080, 1920)}
"""Common formats of videos, in which pixels take few bytes [pixels]."""
TITLE, SUBTITLE, LEADING = 1.2, 0.85, 1.25
"""Heights of title and subtitle, and the line spacing, in heights of the text."""


@dataclass(frozen=True)
class Heading:
    """The titles above the picture."""

    titles: tuple[str, ...] = ()
    """No title, one for all panels, or one for each panel."""
    subtitle: str = ""
    """A smaller line below a common title."""

    def lines(self, text: int) -> int:
        """The height of all lines for a text of this height [pixels]."""
        heights = [TITLE] * bool(self.titles) + [SUBTITLE] * bool(self.subtitle)
        return round(LEADING * sum(heights) * text)


@dataclass(frozen=True)
class Layout:
    """A picture of a given size with its panels."""

    size: tuple[int, int]
    panels: int
    heading: Heading
    footer: int
    """Height of the lines below the panels [pixels]."""

    @property
    def text(self) -> int:
        """The height of a line of text [pixels]."""
        return text_height(*self.size)

    def written(self) -> list[tuple[str, int, int, int]]:
        """The lines above the picture: text, horizontal center, top and height [pixels]."""
        text, titles, top = self.text, self.heading.titles, round(0.3 * self.text)
        areas = [(0, 0, *self.size)] if len(titles) == 1 else [self.panel(index) for index in range(len(titles))]
        lines = [(title, area, top, round(TITLE * text)) for title, area in zip(titles, areas, strict=True)]
        if self.heading.subtitle:
            below = top + round(LEADING * TITLE * text) * bool(titles)
            lines.append((self.heading.subtitle, (0, 0, *self.size), below, round(SUBTITLE * text)))
        result = []
        for line, (left, _, right, _), start, height in lines:
            fits = fitting(line, height, right - left - text)
            result.append((line, (left + right) // 2, start + (height - fits) // 2, fits))
        return result

    def panel(self, index: int) -> tuple[int, int, int, int]:
        """Left, top, right and bottom of a panel [pixels]."""
        width, height = self.size
        return width * index // self.panels, 0, width * (index + 1) // self.panels, height

    def area(self, index: int) -> tuple[int, int, int, int]:
        """The part of a panel that is free of text."""
        left, _, right, bottom = self.panel(index)
        header = self.heading.lines(self.text)
        # At least one row of pixels is left free of text.
        top = min(header + round(0.3 * self.text) * (header > 0), bottom - 1)
        return left, top, right, max(bottom - self.footer, top + 1)

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


def check_heading(title: str | None, titles: Sequence[str] | None, subtitle: str | None, panels: int) -> Heading:
    """The requested titles: none, one for all panels, or one for each panel.

    Raises:
        SceneError: the titles are not valid.
    """
    if title is not None and titles is not None:
        raise SceneError("titles: give one title for all or titles for the panels, not both")
    if titles is not None:
        lines = [line_of(each, f"titles[{index}]") for index, each in enumerate(items(titles, "titles", "strings"))]
        if len(lines) not in (1, panels):
            raise SceneError(f"titles: must be one for each of the {panels} panels, got {len(lines)}")
    else:
        lines = [] if title is None else [each for each in (line_of(title, "title"),) if each]
    return Heading(tuple(lines), "" if subtitle is None else line_of(subtitle, "subtitle"))


def line_of(value: object, path: str) -> str:
    """A line of text; signs that no font has cause a warning.

    Raises:
        SceneError: the value is not a string.
    """
    line = text(value, path)
    warn_of_missing(line, path)
    return line


def sizes(panels: int) -> list[tuple[int, int]]:
    """Candidate sizes, all of about equal area: 640 × 480 for one panel, at most 1280 wide for several."""
    pixels = min(PIXELS, 2 * PIXELS / panels)
    result = []
    for aspect in ASPECTS:
        width = min(math.sqrt(pixels * aspect), WIDEST / panels)
        result.append((_even(panels * width), _even(width / aspect)))
    return result


def best(panels: int, magnification: Callable[[tuple[int, int]], float], *, fixed: bool) -> tuple[int, int]:
    """The size that shows the motion largest, or the default if no other is clearly better.

    Args:
        panels: the number of panels.
        magnification: gives the pixels per meter in a picture of some size.
        fixed: whether the extent of the view was given, so that the default size is taken.
    """
    usual, *others = sizes(panels)
    if fixed:
        return usual
    scales = {size: magnification(size) for size in others}
    largest = max(others, key=lambda size: scales[size])
    return largest if scales[largest] > CLEARLY * magnification(usual) else usual


def _even(side: float) -> int:
    """The nearest even number of pixels, as video needs."""
    return 2 * round(side / 2)
