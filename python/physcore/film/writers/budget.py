"""Reductions that make a film fit into a number of bytes: their order, and the use of the remaining room."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from physcore.errors import SceneError

MILD, FAR, FARTHEST = 10, 18, 28
"""Tolerances of a pixel's color against the nearest one of the palette [levels of 255].

The first two are for films slightly and clearly above LARGE, the last for films that must become smaller.
"""
LARGE = 3_000_000
"""Size above which a film is large [bytes]."""
SMALLER, SMALLEST = 0.5, 0.25
"""Least widths of the picture, relative to the requested one: at first, and finally [1]."""
SLOW, SLOWEST = 12.0, 6.0
"""Least frame rates: before the picture becomes smaller, and finally. Films with a lower rate keep theirs."""
FEW, FEWEST = 63, 31
"""Least numbers of colors: before the picture becomes smaller, and finally."""
ROOM = 0.95
"""Target size as a fraction of the limit, because the size of a film is only estimated."""
ENOUGH = 0.85
"""Fraction of the limit that a film should use."""
REFINEMENTS = 3
"""Largest number of repetitions to use more of the limit, after a film fits."""


@dataclass(frozen=True)
class Cut:
    """Reduction of a film: color tolerance, frame rate, number of colors and size; by default none."""

    scale: float = 1.0
    """Width of the picture, relative to the requested one."""
    stride: int = 1
    """One of this many frames is shown."""
    colors: int = 255
    """Number of colors of the palette."""
    tolerance: int = 0
    """Tolerance of a pixel's color against the nearest one of the palette [levels of 255]."""

    def size(self, whole: tuple[int, int]) -> tuple[int, int]:
        """Width and height of the reduced picture, as even numbers of pixels."""
        width, height = (max(2 * round(self.scale * side / 2), 16) for side in whole)
        return width, height

    def farther(self, excess: float, most: int) -> int:
        """The next tolerance, at most `most`: the least that is likely to reduce the size by the factor `excess`."""
        saving = ((MILD, 1.4), (FAR, 1.9), (FARTHEST, math.inf))
        return next(min(far, most) for far, gain in saving if (far > self.tolerance and excess < gain) or far >= most)

    def deeper(self, excess: float, rate: float, limit: int) -> Cut:
        """The next reduction of a film whose size is `excess` times the limit.

        The order is: a larger color tolerance; every second frame, down to twelve per second; half of the colors, down
        to 63; a smaller picture, down to half the width. Finally the same reductions go on, to six frames per second,
        31 colors and a quarter of the width.

        Args:
            excess: the estimated size over the limit, above one.
            rate: frames per second of the complete film.
            limit: the largest size [bytes], for the message.

        Raises:
            SceneError: no further reduction is possible.
        """
        if self.tolerance < FARTHEST:
            return replace(self, tolerance=self.farther(excess, FARTHEST))
        # The size of a film is proportional to the area of the picture.
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
    """Search for the least reduction with which a film fits into its limit."""

    rate: float
    """Frames per second of the complete film."""
    limit: int | None
    """The largest size [bytes]; None: no limit, but a large film has a color tolerance if `gentle` is True."""
    gentle: bool = True
    """Whether a large film without a limit has a color tolerance."""
    cut: Cut = field(default_factory=Cut)
    """The present reduction."""
    fits: Cut | None = None
    """The least reduction so far with which the film fits; None: none yet."""
    tries: int = 0
    _failed: Cut | None = None

    @property
    def bound(self) -> int | None:
        """The size above which the present attempt is abandoned [bytes]."""
        if self.limit is None and self.gentle and self.cut.tolerance < FAR:
            return LARGE
        return self.limit

    def too_large(self, excess: float) -> bool:
        """Choose the next attempt after a film that was `excess` times too large; False: keep the last film that
        fitted.

        Raises:
            SceneError: no further reduction is possible.
        """
        if self.limit is None:
            self.cut = replace(self.cut, tolerance=self.cut.farther(excess, FAR))
            return True
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

    def _lowest(self) -> int:
        """The largest tolerance known to be too small; 0 if there is none."""
        failed, fits = self._failed, self.cut
        alike = failed is not None and replace(failed, tolerance=fits.tolerance) == fits
        return failed.tolerance if failed is not None and alike else 0

    def _between(self, fits: Cut, other: Cut) -> bool:
        """Try the mean of a reduction with which the film fits and another one."""
        tolerance = (fits.tolerance + other.tolerance) // 2
        middle = replace(fits, tolerance=tolerance, scale=0.5 * (fits.scale + other.scale))
        return middle not in (fits, other) and self._try(middle)

    def _try(self, cut: Cut) -> bool:
        self.cut, self.tries = cut, self.tries + 1
        return self.tries <= REFINEMENTS
