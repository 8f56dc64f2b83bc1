"""Scale bar: a line in a corner of the picture with its length in the scene."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal, TypeAlias

import numpy as np

from physcore._core import Canvas, text_width
from physcore.checks import shown, word
from physcore.errors import SceneError
from physcore.film.camera.view import Area, View
from physcore.film.colors.themes import Theme
from physcore.film.labels.drawing import stroke, write
from physcore.units.symbols import SYMBOLS
from physcore.units.systems import SI, UnitSystem

LengthUnit: TypeAlias = (
    Literal["fm", "pm", "nm", "µm", "mm", "cm", "m", "km", "AU", "ly", "pc", "kpc", "Mpc", "R⊕", "R☉"] | str
)
"""Symbol of a unit of length: one of these, or that of the scene's unit."""
UNITS = SYMBOLS["length"]
"""Units of length by symbol [m]."""
CHOSEN = ("fm", "pm", "nm", "µm", "mm", "cm", "m", "km", "AU", "ly")
"""Units that are chosen automatically."""
LEAST = 0.01
"""Least length for which AU or ly is chosen, in this unit; for other units it is 1."""
LONGEST = 0.25
"""Largest length of a bar, as a fraction of the width that is free of text."""
STEPS = (5.0, 2.0, 1.0)
"""Mantissas of the length of a bar."""
HEIGHT = 0.8
"""Height of the text, relative to that of the other text."""
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def check_scale_bar(given: object, units: UnitSystem = SI) -> LengthUnit | bool:
    """Whether there is a scale bar, or its unit.

    Raises:
        SceneError: the value is neither a bool nor a unit of length, or is a unit and the scene has none.
    """
    if isinstance(given, (bool, np.bool_)):
        return bool(given)
    if units.is_dimensionless:
        raise SceneError(f"scale_bar: must be True or False for a scene without units, got {shown(given)}")
    return word(given, "scale_bar", (*_known(units),))


def rounded(most: float, unit: LengthUnit | None, units: UnitSystem = SI) -> tuple[float, str]:
    """The largest length of 1, 2 or 5 times a power of ten that is at most `most`, and its text.

    Args:
        most: the upper bound, above zero, in the unit of the scene.
        unit: the unit in which the length is such a number; None: that of the scene, or in the SI a suitable one.
        units: the units of the scene.
    """
    if unit is None and not units.is_si:
        unit = units.length.symbol
    if unit is None:
        least = {each: LEAST if each in ("AU", "ly") else 1.0 for each in CHOSEN}
        suitable = [each for each in CHOSEN if most >= least[each] * UNITS[each] * (1.0 - 1e-9)]
        unit = suitable[-1] if suitable else CHOSEN[0]
    own = _known(units)[unit]
    ratio = most / own * (1.0 + 1e-9)
    exponent = math.floor(math.log10(ratio))
    digit = next(step for step in STEPS if step * 10.0**exponent <= ratio)
    value = digit * 10.0**exponent
    number = f"{value:g}"
    if exponent > 4 or exponent < -3:
        power = f"10{str(exponent).translate(SUPERSCRIPTS)}"
        number = power if digit == 1.0 else f"{digit:g} · {power}"
    return value * own, f"{number} {unit}".rstrip()


def _known(units: UnitSystem) -> Mapping[str, float]:
    """Units of length by symbol, in the unit of a scene; its own is among them."""
    own = units.length
    return {**({} if own.value is None else {name: each / own.value for name, each in UNITS.items()}), own.symbol: 1.0}


class ScaleBar:
    """The scale bar of one panel, at its lower left, or at the lower right if that place is taken.

    In 3D the bar is valid at the target of the camera. Nearer objects appear larger.

    Args:
        unit: the unit of its length; True: a suitable one in each frame.
        area: the part of the panel that is free of text.
        text: the height of the text [pixels].
        theme: the colors.
        units: the units of the scene.
    """

    def __init__(
        self, unit: LengthUnit | Literal[True], area: Area, text: int, theme: Theme, units: UnitSystem = SI
    ) -> None:
        self._units = units
        self._unit: LengthUnit | None = None if unit is True else unit
        self._area, self._gap, self._height, self._theme = area, text // 2, round(HEIGHT * text), theme

    def placed(self, view: View, taken: Sequence[Area] = ()) -> tuple[Area, float, str]:
        """The rectangle and the length of the line [pixels], and the text."""
        left, _, right, bottom = self._area
        length, words = rounded(LONGEST * (right - left) / view.scale, self._unit, self._units)
        line = length * view.scale
        width, height = max(line, float(text_width(words, self._height))), 1.5 * self._height
        top = bottom - self._gap - height
        start = left + self._gap
        if any(each[3] > top and each[0] < start + width for each in taken):
            start = right - self._gap - width
        return (start, top, start + width, top + height), line, words

    def draw(self, canvas: Canvas, view: View, taken: Sequence[Area] = ()) -> Area:
        """Draw the bar immediately over a panel, beside rectangles that are taken, and return its own rectangle
        [pixels].
        """
        box, line, words = self.placed(view, taken)
        middle, width = (box[0] + box[2]) / 2, float(text_width(words, self._height))
        left, top, theme = round(middle - width / 2), round(box[1]), self._theme
        write(canvas, words, left, top, self._height, theme.text, outline=theme.background)
        thick = max(self._height / 8, 1.5)
        start, end, base, tick = middle - line / 2, middle + line / 2, box[3] - thick, box[3] - 0.35 * self._height
        points = np.array([[start, tick], [start, base], [end, base], [end, tick]])
        stroke(canvas, points, self._theme.background, thick + 2.0)
        stroke(canvas, points, self._theme.text, thick)
        canvas.paint()
        return box
