"""Differences between frames, for formats that draw each frame over the one before."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physcore._core import Canvas


@dataclass(frozen=True, eq=False)
class Patch:
    """A rectangle that takes the place of what is there. Measured on cloths, fluids and orbits, marking in it what has
    not changed as transparent makes no file smaller.
    """

    left: int
    """Column of its first pixel; even, as WebP wants it."""
    top: int
    """Row of its first pixel; even."""
    pixels: NDArray[np.uint8]
    """Red, green and blue, shape (height, width, 3)."""


def patches(frames: Iterable[Canvas]) -> Iterator[Patch]:
    """One patch for each frame: the first is the whole picture, and one pixel stands for no change at all."""
    before: NDArray[np.uint8] | None = None
    for canvas in frames:
        now = canvas.pixels()
        changed = np.ones(now.shape[:2], dtype=np.bool_) if before is None else (now != before).any(axis=2)
        before = now
        rows, columns = changed.nonzero()
        top, bottom = _extent(rows)
        left, right = _extent(columns)
        yield Patch(left, top, now[top:bottom, left:right])


def _extent(changed: NDArray[np.int64]) -> tuple[int, int]:
    """The range of indices, from an even one on, that holds all that has changed."""
    return (int(changed.min()) & ~1, int(changed.max()) + 1) if len(changed) else (0, 1)
