"""How a film is made to fit into a number of bytes: what is given up first, and how the room that is left is used."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from physcore.errors import SceneError

NEAR, FAR, FARTHEST = 8, 16, 24
"""How far a pixel's color may be from the nearest of the palette [levels of 255]: always, in a film that would be
large, and in one that has to become smaller."""
SMALLER, SMALLEST = 0.5, 0.25
"""How much narrower the picture becomes, and at last [1]."""
SLOW, SLOWEST = 12.0, 6.0
"""Frames per second that are left before the picture becomes smaller, and at last, if the film has as many."""
FEW, FEWEST = 63, 31
"""Colors that are left before the picture becomes smaller, and at last."""
ROOM = 0.95
"""The fraction of the bytes that is aimed at, because the size of a film is only estimated."""
ENOUGH = 0.85
"""The fraction of the bytes that is to be used."""
REFINEMENTS = 3
"""How often a film that fits is made again to use more of them."""


@dataclass(frozen=True)
class Cut:
    """A reduction of a film: tolerance of colors, rate, number of colors and size; at first none."""

    scale: float = 1.0
    """The width of the picture, over that asked for."""
    stride: int = 1
    """Of so many frames one is shown."""
    colors: int = 255
    """In the palette."""
    tolerance: int = NEAR
    """How far a pixel's color may be from the nearest of the palette [levels of 255]."""

    def size(self, whole: tuple[int, int]) -> tuple[int, int]:
        """Width and height, as even numbers of pixels."""
        width, height = (max(2 * round(self.scale * side / 2), 16) for side in whole)
        return width, height

    def deeper(self, excess: float, rate: float, limit: int) -> Cut:
        """The next cut, where a film takes `excess` times the bytes that it may.

        First colors may be farther off; then every second frame is left out, as long as twelve a second are left; then
        half of the colors, down to 63; then the picture becomes smaller, down to half as wide; at last all of these go
        on, to six frames a second, 31 colors and a quarter of the width.

        Args:
            excess: the estimated bytes over those allowed, above one.
            rate: frames per second of the whole film.
            limit: the bytes allowed, for the message.

        Raises:
            SceneError: there is nothing left to give up.
        """
        if self.tolerance < FARTHEST:
            return replace(self, tolerance=FAR if self.tolerance < FAR and excess < 1.4 else FARTHEST)
        # The bytes of a picture go with its area.
        shrunk = self.scale * math.sqrt(ROOM / excess)
        for slowest, fewest, smallest in ((SLOW, FEW, SMALLER), (SLOWEST, FEWEST, SMALLEST)):
            if rate / (2 * self.stride) >= slowest:
                return replace(self, stride=2 * self.stride)
            if self.colors > fewest:
                return replace(self, colors=max(self.colors // 2, fewest))
            if self.scale > smallest:
                return replace(self, scale=max(shrunk, smallest))
        raise SceneError(
            f"max_bytes: {limit} are too few: at a quarter of the width, {rate / self.stride:g} frames per second and "
            f"{self.colors} colors the film still takes about {excess * limit:.3g}; make it shorter, or allow more"
        )


@dataclass
class Search:
    """The search for the least cut with which a film fits into its bytes."""

    rate: float
    """Frames per second of the whole film."""
    limit: int | None
    """The bytes allowed."""
    cut: Cut = field(default_factory=Cut)
    """What is tried."""
    fits: Cut | None = None
    """The least cut so far with which the film fits."""
    tries: int = 0
    _failed: Cut | None = None

    def too_large(self, excess: float) -> bool:
        """Go on after a film that took `excess` times its bytes; False: the one that fitted stays.

        Raises:
            SceneError: there is nothing left to give up.
        """
        assert self.limit is not None  # without one nothing is too large
        self._failed = self.cut
        if self.fits is None:
            self.cut = self.cut.deeper(excess, self.rate, self.limit)
            return True
        return self._between(self.fits, self.cut)

    def fitted(self, size: int) -> bool:
        """Go on after a film that fits; False: it uses its bytes."""
        self.fits = self.cut
        if self.limit is None or self._failed is None or size >= ENOUGH * self.limit:
            return False
        if self.cut.scale < 1.0:
            largest = self._failed.scale if self._failed.scale > self.cut.scale else 1.0
            wider = min(self.cut.scale * math.sqrt(ROOM * self.limit / size), 0.5 * (self.cut.scale + largest))
            return self._try(replace(self.cut, scale=wider))
        return self._between(self.cut, replace(self.cut, tolerance=self._lowest()))

    def _lowest(self) -> int:
        """The tolerance below which the film does not fit, as far as it is known."""
        failed, fits = self._failed, self.cut
        alike = failed is not None and replace(failed, tolerance=fits.tolerance) == fits
        return failed.tolerance if failed is not None and alike else NEAR

    def _between(self, fits: Cut, other: Cut) -> bool:
        """Try the middle of a cut with which the film fits and one with which it does not."""
        tolerance = (fits.tolerance + other.tolerance) // 2
        middle = replace(fits, tolerance=tolerance, scale=0.5 * (fits.scale + other.scale))
        return middle not in (fits, other) and self._try(middle)

    def _try(self, cut: Cut) -> bool:
        self.cut, self.tries = cut, self.tries + 1
        return self.tries <= REFINEMENTS
