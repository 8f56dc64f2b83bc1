"""Reductions that make a film fit into a number of bytes: their order, and the use of the remaining room."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from physcore.errors import SceneError

TOLERANCE, FAR, FARTHEST = 0.8, 1.2, 4.0
"""Tolerances of a color: at first, before the picture becomes smaller, and finally [levels of 255].

An error of this size on smooth shading counts as much as a code of the compression.
"""
SMALLER, SMALLEST = 0.5, 0.25
"""Least widths of the picture, relative to the requested one: before frames are left out, and finally [1]."""
SLOW, SLOWEST = 12.0, 6.0
"""Least frame rates: at first, and finally. Films with a lower rate keep theirs."""
FEW, FEWEST = 63, 31
"""Least numbers of colors: at first, and finally."""
ROOM = 0.95
"""Target size as a fraction of the limit, because the size of a film is only estimated."""
ENOUGH = 0.85
"""Fraction of the limit that a film should use."""
REFINEMENTS = 3
"""Largest number of repetitions to use more of the limit, after a film fits."""


@dataclass(frozen=True)
class Cut:
    """Reduction of a film: color tolerance, frame rate, number of colors and size."""

    scale: float = 1.0
    """Width of the picture, relative to the requested one."""
    stride: int = 1
    """One of this many frames is shown."""
    colors: int = 255
    """Number of colors of the palette."""
    tolerance: float = TOLERANCE
    """Tolerance of a color [levels of 255]."""

    def size(self, whole: tuple[int, int]) -> tuple[int, int]:
        """Width and height of the reduced picture, as even numbers of pixels."""
        width, height = (max(2 * round(self.scale * side / 2), 16) for side in whole)
        return width, height

    def deeper(self, excess: float, rate: float, limit: int) -> Cut:
        """The next reduction of a film whose size is `excess` times the limit.

        The order is: a larger color tolerance; a smaller picture, down to half the width; every second frame, down to
        twelve per second; half of the colors, down to 63. Finally the same reductions go on, to a quarter of the width,
        six frames per second and 31 colors.

        Args:
            excess: the estimated size over the limit, above one.
            rate: frames per second of the complete film.
            limit: the largest size [bytes], for the message.

        Raises:
            SceneError: no further reduction is possible.
        """
        # The size of a film is proportional to the area of the picture.
        shrunk = self.scale * math.sqrt(ROOM / excess)
        for farthest, smallest, slowest, fewest in ((FAR, SMALLER, SLOW, FEW), (FARTHEST, SMALLEST, SLOWEST, FEWEST)):
            if self.tolerance < farthest:
                return replace(self, tolerance=farthest)
            if self.scale > smallest:
                return replace(self, scale=max(shrunk, smallest))
            if rate / (2 * self.stride) >= slowest:
                return replace(self, stride=2 * self.stride)
            if self.colors > fewest:
                return replace(self, colors=max(self.colors // 2, fewest))
        raise SceneError(
            f"max_bytes: {limit} are too few: at a quarter of the width, {rate / self.stride:g} frames per second and "
            f"{self.colors} colors the film still takes about {excess * limit:.3g}; make it shorter, or allow more"
        )


@dataclass
class Search:
    """Search for the least reduction with which a film fits into its limit."""

    rate: float
    """Frames per second of the complete film."""
    limit: int | None
    """The largest size [bytes]; None: no limit."""
    cut: Cut = field(default_factory=Cut)
    """The present reduction."""
    fits: Cut | None = None
    """The least reduction so far with which the film fits; None: none yet."""
    tries: int = 0
    _failed: Cut | None = None

    def too_large(self, excess: float) -> bool:
        """Choose the next attempt after a film that was `excess` times too large; False: keep the last film that
        fitted.

        Raises:
            SceneError: no further reduction is possible.
        """
        assert self.limit is not None  # nothing is too large without a limit
        self._failed = self.cut
        if self.fits is None:
            self.cut = self.cut.deeper(excess, self.rate, self.limit)
            return True
        return self._between(self.fits, self.cut)

    def fitted(self, size: int) -> bool:
        """Choose the next attempt after a film of `size` bytes that fits; False: it is good enough."""
        self.fits = self.cut
        if self.limit is None or self._failed is None or size >= ENOUGH * self.limit:
            return False
        if self.cut.scale < 1.0:
            largest = self._failed.scale if self._failed.scale > self.cut.scale else 1.0
            wider = min(self.cut.scale * math.sqrt(ROOM * self.limit / size), 0.5 * (self.cut.scale + largest))
            return self._try(replace(self.cut, scale=wider))
        return self._between(self.cut, replace(self.cut, tolerance=self._lowest()))

    def _lowest(self) -> float:
        """The largest tolerance known to be too small; the first one if there is none."""
        failed, fits = self._failed, self.cut
        alike = failed is not None and replace(failed, tolerance=fits.tolerance) == fits
        return failed.tolerance if failed is not None and alike else TOLERANCE

    def _between(self, fits: Cut, other: Cut) -> bool:
        """Try the mean of a reduction with which the film fits and another one."""
        tolerance = 0.5 * (fits.tolerance + other.tolerance)
        middle = replace(fits, tolerance=tolerance, scale=0.5 * (fits.scale + other.scale))
        return middle not in (fits, other) and self._try(middle)

    def _try(self, cut: Cut) -> bool:
        self.cut, self.tries = cut, self.tries + 1
        return self.tries <= REFINEMENTS
