"""Text and numbers in lines of limited width, in the fonts of the canvas."""

from __future__ import annotations

import math
from collections.abc import Sequence

from physcore._core import missing_signs, text_width
from physcore.errors import SceneWarning, warn

GAP = "   "
"""Space between two pieces of a line."""
FIGURE_SPACE = "\u2007"
"""A space as wide as a digit."""
PHONE = 360
"""Width at which a picture is assumed to be viewed [pixels]: a column of a page, or a telephone."""
LEGIBLE = 14
"""Height of a line at this width [pixels]; its capitals have 7 pixels."""
SMALLEST = 16
"""Least height of a line [pixels]."""
SHARE = 14
"""Ratio of a picture's height to the largest height of a line."""


def text_height(width: int, height: int) -> int:
    """The height of a line in a picture of this size, legible if the picture is scaled to a width of 360 pixels
    [pixels].
    """
    return max(min(math.ceil(LEGIBLE * width / PHONE), height // SHARE), SMALLEST)


def fitting(line: str, height: int, width: int) -> int:
    """The height at which a line fits the width: at most `height`, and at least half of it."""
    needed = text_width(line, height)
    return height if needed <= width else max(height * width // needed, height // 2)


def broken(line: str, height: int, width: int) -> list[str]:
    """A text in as few lines as fit the width, each about as long as the others; empty without text. A word is never
    split.
    """
    words = line.split()
    if not words or text_width(line, height) <= width:
        return [line] if words else []
    least = _lines(words, height, width)
    narrow, wide = 0, width
    while wide - narrow > height // 2:  # the least width that takes as few lines
        middle = (narrow + wide) // 2
        narrow, wide = (narrow, middle) if len(_lines(words, height, middle)) <= len(least) else (middle, wide)
    return _lines(words, height, wide)


def _lines(words: Sequence[str], height: int, width: int) -> list[str]:
    """Words in lines of at most this width, where they are not longer."""
    lines = [words[0]]
    for word in words[1:]:
        if text_width(longer := f"{lines[-1]} {word}", height) <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def wrapped(pieces: Sequence[str], height: int, width: int) -> list[list[str]]:
    """Distribute pieces over lines of at most this width [pixels]; a piece is never split."""
    lines: list[list[str]] = []
    for piece in pieces:
        if lines and text_width(GAP.join([*lines[-1], piece]), height) <= width:
            lines[-1].append(piece)
        else:
            lines.append([piece])
    return lines


def warn_of_missing(line: str, name: str) -> None:
    """Warn of the signs of a text that no font has."""
    if missing := missing_signs(line):
        codes = ", ".join(f"U+{ord(sign):04X}" for sign in missing)
        warn(
            f"{name}: no face has {' '.join(missing)} ({codes}), which is drawn as \N{REPLACEMENT CHARACTER}",
            SceneWarning,
        )


def ends(low: float, high: float) -> tuple[str, str]:
    """Two values with as many decimals as two digits of their difference need."""
    span, most = abs(high - low), max(abs(low), abs(high))
    if span == 0.0 or not math.isfinite(span) or most >= 1e5 or most < 1e-3:
        return _short(low), _short(high)
    decimals = max(0, 1 - math.floor(math.log10(span)))
    first, second = ("0" if value == 0.0 else f"{value:.{decimals}f}" for value in (low, high))
    return first, second


def _short(value: float) -> str:
    """A number with two digits, such as 1.2e5."""
    if value == 0.0:
        return "0"
    digits, _, exponent = f"{value:.1e}".partition("e")
    return f"{digits}e{int(exponent)}" if exponent else digits
