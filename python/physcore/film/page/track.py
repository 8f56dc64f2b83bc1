"""Tracks of a tape: the arrays of one kind of shapes, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(eq=False)
class Track:
    """One kind of shapes, drawn by one painter, frame by frame.

    Places are pixels in 2D, from the upper left corner and downward. In 3D they are lengths relative to the point that
    the camera looks at: right, up and toward the camera. Sizes are pixels in 2D and lengths in 3D; widths of lines are
    always pixels.
    """

    kind: str
    panel: int
    deep: bool
    """Whether the places are in 3D."""
    still: bool
    """Whether the only frame is shown all the time."""
    fixed: dict[str, Any] = field(default_factory=dict)
    """All that is the same in all frames: numbers, texts, lists of these, and arrays."""
    frames: dict[int, dict[str, NDArray[Any]]] = field(default_factory=dict)
    """The arrays of each frame, one row per shape."""

    def add(self, frame: int, arrays: dict[str, NDArray[Any]]) -> int:
        """Add a frame, and return how many bytes it takes. An array equal to that of the frame before is not kept."""
        before, size = self.frames.get(frame - 1, {}), 0
        for name, values in arrays.items():
            if name in before and np.array_equal(before[name], values):
                arrays[name] = before[name]
            else:
                size += values.nbytes
        self.frames[frame] = arrays
        return size
