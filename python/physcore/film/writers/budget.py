"""How a film is made to fit into a number of bytes: what is given up first, and by how much."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from physcore.errors import SceneError

SMALLER, SMALLEST = 0.5, 0.25
"""How much narrower the picture becomes before anything else is given up, and at last [1]."""
SLOWEST = 10.0
"""Frames per second that are always left, if the film has as many."""
FEWEST = 32
"""Colors that are always left."""
ROOM = 0.95
"""The fraction of the bytes that is aimed at, because the size of a film is only estimated."""


@dataclass(frozen=True)
class Cut:
    """A reduction of a film: size, rate and colors; at first none."""

    scale: float = 1.0
    """The width of the picture, over that asked for."""
    stride: int = 1
    """Of so many frames one is shown."""
    colors: int = 255
    """In the palette."""

    def size(self, whole: tuple[int, int]) -> tuple[int, int]:
        """Width and height, as even numbers of pixels."""
        width, height = (max(2 * round(self.scale * side / 2), 16) for side in whole)
        return width, height

    def deeper(self, excess: float, rate: float, limit: int) -> Cut:
        """The next cut, where a film takes `excess` times the bytes that it may.

        First the picture becomes smaller, down to half as wide; then every second frame is left out, as long as ten a
        second are left; then half of the colors, down to 32; and at last the picture shrinks to a quarter.

        Args:
            excess: the estimated bytes over those allowed, above one.
            rate: frames per second of the whole film.
            limit: the bytes allowed, for the message.

        Raises:
            SceneError: there is nothing left to give up.
        """
        # The bytes of a picture go with its area.
        shrunk = self.scale * math.sqrt(ROOM / excess)
        if self.scale > SMALLER:
            return replace(self, scale=max(shrunk, SMALLER))
        if rate / (2 * self.stride) >= SLOWEST:
            return replace(self, stride=2 * self.stride)
        if self.colors > FEWEST:
            return replace(self, colors=max(self.colors // 2, FEWEST))
        if self.scale > SMALLEST:
            return replace(self, scale=max(shrunk, SMALLEST))
        raise SceneError(
            f"max_bytes: {limit} are too few: at a quarter of the width, {rate / self.stride:g} frames per second and "
            f"{self.colors} colors the film still takes about {excess * limit:.3g}; make it shorter, or allow more"
        )
