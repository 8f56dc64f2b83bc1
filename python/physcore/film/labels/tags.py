"""Name tags: the name of each body beside it in the picture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import TypeAlias

import numpy as np

from physcore._core import Canvas, text_width
from physcore.checks import FloatArray
from physcore.errors import SceneError
from physcore.film.camera.view import Area, View
from physcore.film.colors.themes import Theme
from physcore.film.labels.drawing import write
from physcore.film.labels.text import warn_of_missing
from physcore.film.styles import Painter
from physcore.scene.bodies import Body
from physcore.scene.system import System
from physcore.scene.targets import chosen, found
from physcore.simulation.sources import Source, SourceFrame

Named: TypeAlias = bool | Body | str | Sequence[Body | str]
"""Whether to write the names of all named bodies, or the bodies with a name tag."""
Listed: TypeAlias = bool | Body | System | str | Sequence[Body | System | str]
"""Whether to list all named bodies and systems in the legend, or the bodies and systems to list."""
HEIGHT = 0.8
"""Height of a name, relative to that of the other text."""
GAP = 0.15
"""Distance of a name from its body, in heights of the name."""
SIDES = ((1, 0), (-1, 0), (0, -1), (0, 1), (1, -1), (-1, -1), (1, 1), (-1, 1))
"""Places of a name relative to its body, in order of preference: (right, down)."""


def check_named(
    given: object, path: str, filmed: Sequence[Source], *, systems: bool = False
) -> list[list[Body | System]]:
    """The bodies of each source, and with `systems` its systems, whose names are written. A warning names the signs
    that no font has.

    Raises:
        SceneError: the value is neither True nor False, nor bodies of the film that have names.
    """
    items: list[list[Body | System]] = [
        [*source.scene.bodies, *(source.scene.systems if systems else ())] for source in filmed
    ]
    every = list(chain.from_iterable(items))
    if isinstance(given, (bool, np.bool_)):
        asked: Sequence[Body | System] = [item for item in every if item.name and given]
    else:
        asked = found(chosen(given, path, (Body, System) if systems else (Body,)) or (), every, path)
    for item in asked:
        if not any(item is each for each in every):
            raise SceneError(f"{path}: {item!r} is not in what is filmed")
        if not item.name:
            raise SceneError(f"{path}: {item!r} has no name; give it name=…")
        warn_of_missing(item.name, path)
    return [[item for item in each if any(item is one for one in asked)] for each in items]


class NameTags:
    """The name tags of one panel. Tags do not overlap; a tag covers another body only if there is no other place. A tag
    without a place is left out. A tag stays on the side of the previous frame while that is free.

    Args:
        bodies: the bodies with tags, in order of priority.
        painters: the painters of the bodies.
        area: the part of the panel that is free of text.
        text: the height of the text [pixels].
        theme: the colors.
    """

    def __init__(
        self, bodies: Sequence[Body | System], painters: Sequence[Painter], area: Area, text: int, theme: Theme
    ) -> None:
        self._area, self._height, self._theme = area, round(HEIGHT * text), theme
        self._drawn = [
            (part, painter)
            for body in bodies
            for painter in painters
            for part in painter.parts
            if part.body is body and not painter.style.overlay
        ]
        self._sides: dict[int, tuple[int, int]] = {}

    def begin(self) -> None:
        """Forget the places of the tags at the start of the film."""
        self._sides.clear()

    def draw(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float, taken: Sequence[Area] = ()) -> None:
        """Write the tags of a frame immediately, over a panel of `pixels` pixels and beside the areas `taken`."""
        for left, top, name in self.placed(frame, view, pixels, taken):
            theme = self._theme
            write(canvas, name, round(left), round(top), self._height, theme.text, outline=theme.background)

    def placed(
        self, frame: SourceFrame, view: View, pixels: float, taken: Sequence[Area] = ()
    ) -> Iterator[tuple[float, float, str]]:
        """The upper left corner [pixels] of each tag, and the name."""
        boxes = [self._box(*each.spread(part, frame), view, each.inset(pixels)) for part, each in self._drawn]
        names = list(taken)
        for index, ((part, _), box) in enumerate(zip(self._drawn, boxes, strict=True)):
            if box is None:
                continue
            name = part.body.name or ""
            size = (text_width(name, self._height), self._height)
            others = [each for at, each in enumerate(boxes) if each is not None and at != index]
            place = self._place(index, box, size, [names + others, names])
            if place is not None:
                names.append(place)
                yield place[0], place[1], name

    def _box(self, positions: FloatArray, radius: FloatArray, view: View, inset: float) -> Area | None:
        """The rectangle that a body covers in the panel; None outside of it."""
        centers, _, scale = view.project(positions)
        reach = np.maximum(scale * radius, inset)[:, np.newaxis]
        seen = np.isfinite(centers).all(axis=1)
        if not seen.any():
            return None
        left, top = (centers - reach)[seen].min(axis=0).tolist()
        right, bottom = (centers + reach)[seen].max(axis=0).tolist()
        area = self._area
        box = max(left, area[0]), max(top, area[1]), min(right, area[2]), min(bottom, area[3])
        return box if box[0] < box[2] and box[1] < box[3] else None

    def _place(self, index: int, box: Area, size: tuple[float, float], taken: Sequence[list[Area]]) -> Area | None:
        """The first place beside a body that is free of all areas of the first list, or else of a later list."""
        last = self._sides.get(index)
        for areas in taken:
            for side in SIDES if last is None else (last, *SIDES):
                place = self._beside(box, size, side)
                inside = _overlap(place, self._area) >= size[0] * size[1] - 1e-6
                if inside and not any(_overlap(place, area) > 0.0 for area in areas):
                    self._sides[index] = side
                    return place
        return None

    def _beside(self, box: Area, size: tuple[float, float], side: tuple[int, int]) -> Area:
        """The rectangle of a name of some size at a side of a box."""
        gap = GAP * self._height
        corner = []
        for axis in (0, 1):
            low, high, length = box[axis], box[axis + 2], size[axis]
            places = {-1: low - gap - length, 0: (low + high - length) / 2, 1: high + gap}
            corner.append(places[side[axis]])
        return corner[0], corner[1], corner[0] + size[0], corner[1] + size[1]


def _overlap(one: Area, other: Area) -> float:
    """The area common to two rectangles [pixels]."""
    width = min(one[2], other[2]) - max(one[0], other[0])
    height = min(one[3], other[3]) - max(one[1], other[1])
    return max(width, 0.0) * max(height, 0.0)
