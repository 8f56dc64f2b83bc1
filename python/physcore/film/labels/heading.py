"""The heading of a picture: title, subtitle and formula above all panels, and titles and bars above each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from physcore._core import text_width
from physcore.checks import items, text
from physcore.errors import SceneError
from physcore.film.labels.parameters import ParameterBar, parameter_bars
from physcore.film.labels.text import GAP, broken, fitting, warn_of_missing

TITLE, SUBTITLE, LEADING = 1.2, 0.85, 1.25
"""Heights of title and subtitle, and the line spacing, in heights of the text."""


@dataclass(frozen=True)
class Line:
    """A line of a heading, in pixels from the upper left of its block."""

    text: str
    left: int
    top: int
    height: int
    align: int = -1
    """-1: it begins at `left`; 1: it ends there."""
    quiet: bool = False
    """Whether it has the color of labels."""


@dataclass(frozen=True)
class Heading:
    """The lines above a picture."""

    title: str = ""
    subtitle: str = ""
    """A smaller line below the title."""
    formula: str = ""
    """At the right of the title, or in a line of its own where there is no room."""
    titles: tuple[str, ...] = ()
    """One for each panel, or none."""
    bars: tuple[tuple[ParameterBar, ...], ...] = ()
    """The bars of parameters of each panel, as many in all; or none."""

    @property
    def of_panels(self) -> Heading:
        """The lines and bars above single panels."""
        return Heading(titles=self.titles, bars=self.bars)

    def common(self, text: int, width: int) -> tuple[list[Line], int]:
        """The lines above all panels for a height of the text and a width of the picture, and their height [pixels]."""
        edge, room, large = text // 2, width - text, round(TITLE * text)
        lines, top = list[Line](), 0
        titles = broken(self.title, large, room)
        beside = len(titles) == 1 and text_width(f"{titles[0]}{GAP}", large) + text_width(self.formula, text) <= room
        if self.formula and beside:
            lines.append(Line(self.formula, width - edge, round(0.1 * text), text, 1))
        below = [] if beside else broken(self.formula, text, room)
        small = round(SUBTITLE * text)
        rows = [
            *((line, large, False) for line in titles),
            *((line, small, True) for line in broken(self.subtitle, small, room)),
            *((line, text, False) for line in below),
        ]
        for line, height, quiet in rows:
            lines.append(_fitted(line, edge, top, height, room, quiet=quiet))
            top += round(LEADING * height)
        return lines, top

    def own(self, index: int, text: int, width: int) -> tuple[list[Line], int]:
        """The lines above a panel of some width, and their height with that of its bars [pixels]."""
        high = round(TITLE * text)
        lines = [_fitted(self.titles[index], text // 2, 0, high, width - text)] if self.titles else []
        bars = len(self.bars[index]) if self.bars else 0
        return lines, round(LEADING * high) * len(lines) + round(LEADING * SUBTITLE * text * bars)


def _fitted(line: str, left: int, top: int, height: int, room: int, *, quiet: bool = False) -> Line:
    """A line, made lower as far as it needs to fit, in the middle of its row."""
    fits = fitting(line, height, room)
    return Line(line, left, top + (height - fits) // 2, fits, quiet=quiet)


def check_heading(
    title: str | None,
    titles: Sequence[str] | None,
    subtitle: str | None,
    panels: int,
    parameters: object = None,
    formula: str | None = None,
) -> Heading:
    """The requested lines and bars of parameters.

    Raises:
        SceneError: the lines are not valid.
    """
    each = [] if titles is None else items(titles, "titles", "strings")
    lines = [line_of(line, f"titles[{index}]") for index, line in enumerate(each)]
    if titles is not None and len(lines) != panels:
        raise SceneError(f"titles: must be one for each of the {panels} panels, got {len(lines)}")
    bars = parameter_bars(parameters, panels)
    above = {"title": title, "subtitle": subtitle, "formula": formula}
    return Heading(**{name: line_or_none(line, name) for name, line in above.items()}, titles=tuple(lines), bars=bars)


def line_or_none(value: object, path: str) -> str:
    """A line of text; empty for None."""
    return "" if value is None else line_of(value, path)


def line_of(value: object, path: str) -> str:
    """A line of text; signs that no font has cause a warning.

    Raises:
        SceneError: the value is not a string.
    """
    line = text(value, path)
    warn_of_missing(line, path)
    return line
