"""Numbers and words that fit: the canvas writes in a face of fixed width, in four sizes."""

from __future__ import annotations

import math
from collections.abc import Sequence

ADVANCE = {32: 14, 24: 11, 20: 9, 16: 7}
"""Width of a character for each height of a line [pixels]."""
GAP = "  "
"""Between two pieces of a line."""


def text_height(height: int) -> int:
    """The height of a line in a picture of this height [pixels]."""
    return min(max(height // 24, min(ADVANCE)), max(ADVANCE))


def advance(height: int) -> int:
    """The width of a character in a line of this height [pixels]."""
    return next((width for least, width in ADVANCE.items() if height >= least), min(ADVANCE.values()))


def wrapped(pieces: Sequence[str], columns: int) -> list[str]:
    """Lines of at most so many characters, if each piece is; a piece is never torn."""
    lines: list[str] = []
    for piece in pieces:
        if lines and len(lines[-1]) + len(GAP) + len(piece) <= columns:
            lines[-1] += GAP + piece
        else:
            lines.append(piece)
    return lines


def ends(low: float, high: float) -> tuple[str, str]:
    """Two values with as many decimals as tell them apart: two digits of their difference."""
    span, most = abs(high - low), max(abs(low), abs(high))
    if span == 0.0 or not math.isfinite(span) or most >= 1e5 or most < 1e-3:
        return _short(low), _short(high)
    decimals = max(0, 1 - math.floor(math.log10(span)))
    first, second = ("0" if value == 0.0 else f"{value:.{decimals}f}" for value in (low, high))
    return first, second


def _short(value: float) -> str:
    """Two digits, such as 1.2e5."""
    if value == 0.0:
        return "0"
    digits, _, exponent = f"{value:.1e}".partition("e")
    return f"{digits}e{int(exponent)}" if exponent else digits
