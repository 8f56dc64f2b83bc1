"""Opening angle of the tree of a long-range force."""

from __future__ import annotations

from typing import Literal

from physcore.checks import is_word, number

WIDEST = 2.0
"""Largest opening angle: beyond it the error of accelerations hardly grows."""


def opening_angle(value: object, path: str) -> float | Literal["auto"]:
    """A number from 0 to `WIDEST`, or "auto"."""
    if is_word(value, "auto"):
        return "auto"
    return number(value, path, least=0.0, most=WIDEST)
