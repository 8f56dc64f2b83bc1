"""Bars of parameters: where the value of a panel lies among the values of all panels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from physcore._core import Canvas, text_width
from physcore.arithmetic import log
from physcore.checks import shown
from physcore.errors import SceneError
from physcore.film.colors.themes import Color, Theme
from physcore.film.labels.drawing import stroke, write
from physcore.film.labels.text import GAP, fitting, warn_of_missing

ScaleName = Literal["linear", "log", "words"]
"""How values lie along an axis."""
HALF = 0.3
"""Half of the height of the mark of a value, in heights of the text."""
SHORTEST = 2.0
"""Least length of a bar, in heights of the text."""


@dataclass(frozen=True)
class ParameterBar:
    """Bar of one parameter in one panel."""

    name: str
    text: str
    """Value of this panel."""
    texts: tuple[str, ...]
    """Values of all panels."""
    places: tuple[float, ...]
    """Places of the values along the bar, from 0 to 1."""

    def draw(self, canvas: Canvas, box: tuple[int, int, int], text: int, theme: Theme, outline: Color | None) -> None:
        """Draw the bar from left to right at a top [pixels], with a text of this height."""
        left, top, right = box
        widest = max(self.texts, key=lambda each: text_width(each, text))
        high = fitting(f"{self.name}{GAP}{GAP}{widest}", text, round(right - left - SHORTEST * text))
        write(canvas, self.name, left, top, high, theme.label, -1, outline)
        write(canvas, self.text, right, top, high, theme.text, 1, outline)
        start = left + text_width(self.name + GAP, high)
        end = right - text_width(GAP + widest, high)
        middle, half = top + 0.54 * high, HALF * high
        if end - start < SHORTEST:
            return
        stroke(canvas, np.array([[start, middle], [end, middle]]), theme.label, max(1.0, 0.06 * high))
        for each, place in zip(self.texts, self.places, strict=True):
            x, own = start + place * (end - start), each == self.text
            color, reach = (theme.text, half) if own else (theme.label, 0.5 * half)
            stroke(
                canvas,
                np.array([[x, middle - reach], [x, middle + reach]]),
                color,
                max(1.0, (0.3 if own else 0.06) * high),
            )
        canvas.paint()


def parameter_bars(parameters: object, panels: int) -> tuple[tuple[ParameterBar, ...], ...]:
    """The bars of each panel: those of the parameters that have several values.

    Args:
        parameters: the values of each panel by name; None: no bars.
        panels: the number of panels.

    Raises:
        SceneError: they are not a mapping for each panel, all with the same names.
    """
    if parameters is None:
        return ()
    given = list(parameters) if isinstance(parameters, (list, tuple)) else []
    if len(given) != panels or not all(isinstance(each, Mapping) and each.keys() == given[0].keys() for each in given):
        raise SceneError(
            f"parameters: must be a list of mappings from names to values, one for each of the {panels} recordings, "
            f"got {shown(parameters)}"
        )
    columns = [_bars(str(name), [each[name] for each in given]) for name in given[0]]
    return tuple(zip(*(each for each in columns if each), strict=True)) or ((),) * panels


def _bars(name: str, values: Sequence[Any]) -> list[ParameterBar]:
    """The bar of a parameter in each panel; none if all values are equal."""
    texts = [value_text(each) for each in values]
    for line in (name, *texts):
        warn_of_missing(line, "parameters")
    known = dict(zip(texts, values, strict=True))
    if len(known) < 2:
        return []
    scale = scale_of(list(known.values()))
    numbers = [float(index if scale == "words" else each) for index, each in enumerate(known.values())]
    along = log(np.array(numbers)) if scale == "log" else np.array(numbers)
    places = ((along - along.min()) / (along.max() - along.min())).tolist()
    return [ParameterBar(name, each, tuple(known), tuple(places)) for each in texts]


def value_text(value: object) -> str:
    """A value of a parameter as text."""
    if isinstance(value, float):
        short = f"{value:.6g}"
        return short if float(short) == value or not math.isfinite(value) else repr(value)
    return value if isinstance(value, str) else shown(value)


def scale_of(values: Sequence[Any]) -> ScaleName:
    """The axis for some values: "log" for positive numbers whose ratios vary less than their differences, "words" for
    values that are not all numbers.
    """
    kinds = (int, float, np.integer, np.floating)
    if not all(isinstance(each, kinds) and not isinstance(each, bool) and math.isfinite(each) for each in values):
        return "words"
    numbers = sorted(map(float, values))
    if len(numbers) < 3 or numbers[0] <= 0.0:
        return "linear"
    steps = [after - before for before, after in pairwise(numbers)]
    ratios = [(after - before) / before for before, after in pairwise(numbers)]
    return "log" if max(ratios) / min(ratios) < max(steps) / min(steps) else "linear"
