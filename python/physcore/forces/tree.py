"""Forces between all pairs of particles, and the opening angle of their trees."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal

from physcore.checks import is_word, number
from physcore.scene.items import Force

WIDEST = 2.0
"""Largest opening angle: beyond it the error of accelerations hardly grows."""


LARGEST_ERROR = 0.02
"""Largest rms error of accelerations that may be requested, relative to their rms."""


@dataclass(frozen=True)
class DistantForce(Force):
    """Base class of forces between all pairs of particles, as exact sums or by a tree."""

    naming: ClassVar[tuple[str, ...]] = ("on", "sources")
    is_distant: ClassVar[bool] = True

    def finer(self) -> Any:
        """The force with a tree of half the opening angle, or of a tenth of the error."""
        own: Any = self
        if own.opening_angle == 0.0:
            return self
        if own.opening_angle == "auto":
            return replace(own, force_error=0.1 * own.force_error)
        return replace(own, opening_angle=0.5 * own.opening_angle)


def opening_angle(value: object, path: str) -> float | Literal["auto"]:
    """A number from 0 to `WIDEST`, or "auto"."""
    if is_word(value, "auto"):
        return "auto"
    return number(value, path, least=0.0, most=WIDEST)


def force_error(value: object, path: str) -> float:
    """A number from above zero to `LARGEST_ERROR`."""
    return number(value, path, above=0.0, most=LARGEST_ERROR)
