"""Opening angle of the tree of a long-range force."""

from __future__ import annotations

from typing import Literal

from physcore.checks import is_word, number

WIDEST = 2.0
"""Largest opening angle: beyond it the error of accelerations hardly grows."""


LARGEST_ERROR = 0.02
"""Largest rms error of accelerations that may be requested, relative to their rms."""


def opening_angle(value: object, path: str) -> float | Literal["auto"]:
    """A number from 0 to `WIDEST`, or "auto"."""
    if is_word(value, "auto"):
        return "auto"
    return number(value, path, least=0.0, most=WIDEST)


def force_error(value: object, path: str) -> float:
    """A number from above zero to `LARGEST_ERROR`."""
    return number(value, path, above=0.0, most=LARGEST_ERROR)
