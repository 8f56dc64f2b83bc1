"""Opening angle of the tree of a long-range force."""

from __future__ import annotations

from typing import Literal

from physcore.checks import is_word, number


def opening_angle(value: object, path: str) -> float | Literal["auto"]:
    """A number, at least zero, or "auto"."""
    if is_word(value, "auto"):
        return "auto"
    return number(value, path, least=0.0)
