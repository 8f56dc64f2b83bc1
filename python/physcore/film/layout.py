"""How a picture is divided: panels beside one another, titles above, lines of text below."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from physcore.checks import count as whole_number
from physcore.checks import items, shown, text
from physcore.errors import SceneError
from physcore.film.labels.text import text_height

MARGIN = 0.03
"""Free space around the motion, as a fraction of a panel's shorter side."""
LARGEST = 16384
"""The longest side of a picture [pixels]; a square one takes a gigabyte."""
ASPECTS = (4 / 3, 1.0, 3 / 4, 16 / 9, 9 / 16, 2.4)
"""Width over height of the panels to choose from; the first is taken unless another one is clearly better."""
PIXELS = 640 * 480
"""The size of a panel; more than two share that of two."""
WIDEST = 1280
"""The greatest width of a picture that was not asked for [pixels]."""
CLEARLY = 1.1
"""How much larger the motion has to look in another format."""


@dataclass(frozen=True)
class Layout:
    """A picture of some size with its panels."""

    size: tuple[int, int]
    panels: int
    header: bool
    """Whether there are titles."""
    footer: int
    """Height of the lines below the panels [pixels]."""

    @property
    def text(self) -> int:
        """The height of a line of text [pixels]."""
        return text_height(self.size[1])

    def panel(self, index: int) -> tuple[int, int, int, int]:
        """Left, top, right and bottom of a panel [pixels]."""
        width, height = self.size
        return width * index // self.panels, 0, width * (index + 1) // self.panels, height

    def area(self, index: int) -> tuple[int, int, int, int]:
        """The part of a panel that is free of text."""
        left, _, right, bottom = self.panel(index)
        return left, round(1.5 * self.text) if self.header else 0, right, bottom - self.footer

    def pixels(self, index: int) -> float:
        """The size of a panel."""
        left, top, right, bottom = self.panel(index)
        return float((right - left) * (bottom - top))

    def margin(self, index: int) -> float:
        """Free space around the motion [pixels]."""
        left, top, right, bottom = self.panel(index)
        return MARGIN * min(right - left, bottom - top)


def check_size(size: object) -> tuple[int, int] | None:
    """The size that was asked for.

    Raises:
        SceneError: it is not one.
    """
    if size is None:
        return None
    if not isinstance(size, (tuple, list)) or len(size) != 2:
        raise SceneError(f"size: must be (width, height) in pixels, got {shown(size)}")
    width, height = (whole_number(side, f"size[{axis}]", least=16, most=LARGEST) for axis, side in enumerate(size))
    return width, height


def check_titles(titles: Sequence[str] | None, panels: int) -> list[str]:
    """The titles that were asked for: none, one for all, or one for each panel.

    Raises:
        SceneError: they are something else.
    """
    if titles is None:
        return []
    lines = [text(title, f"titles[{index}]") for index, title in enumerate(items(titles, "titles", "strings"))]
    if len(lines) not in (1, panels):
        raise SceneError(f"titles: must be one for each of the {panels} panels, got {len(lines)}")
    return lines


def sizes(panels: int) -> list[tuple[int, int]]:
    """Sizes to choose from, all about equally large: 640 × 480 for one panel, at most 1280 wide for several."""
    pixels = min(PIXELS, 2 * PIXELS / panels)
    result = []
    for aspect in ASPECTS:
        width = min(math.sqrt(pixels * aspect), WIDEST / panels)
        result.append((_even(panels * width), _even(width / aspect)))
    return result


def best(panels: int, magnification: Callable[[tuple[int, int]], float], *, fixed: bool) -> tuple[int, int]:
    """The size in which the motion is shown largest, or the usual one if none is clearly better.

    Args:
        panels: how many there are.
        magnification: pixels per meter in a picture of some size.
        fixed: whether the user has said how much is shown, so that there is nothing to gain.
    """
    usual, *others = sizes(panels)
    if fixed:
        return usual
    scales = {size: magnification(size) for size in others}
    largest = max(others, key=lambda size: scales[size])
    return largest if scales[largest] > CLEARLY * magnification(usual) else usual


def _even(side: float) -> int:
    """A whole, even number of pixels: video needs it."""
    return 2 * round(side / 2)
