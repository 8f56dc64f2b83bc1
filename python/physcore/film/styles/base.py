"""The base of all styles."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, ClassVar, Self, cast

import numpy as np
from numpy.typing import NDArray

from physcore._core import Canvas
from physcore.checks import BoolArray, FloatArray, IntArray, number, shown
from physcore.errors import SceneError
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.colormaps import ColormapName, sequential
from physcore.film.colors.themes import Color, Theme
from physcore.scene.bodies import Body
from physcore.scene.items import On, System, chosen, found
from physcore.scene.periodic import Periodic
from physcore.scene.scene import Scene
from physcore.simulation.sources import Source, SourceFrame

InkArray = NDArray[np.uint8]
"""Red, green, blue and opacity, 0–255, shape (N, 4)."""

FOG = 0.2
"""How much of its color the farthest thing in a 3D picture has lost to the background."""
SHADING = 0.85
"""How much the light matters on balls."""
SHOWN = 16
"""How many colors of a scale a palette has for certain."""
BRIGHT = 384
"""A ground whose red, green and blue add up to more is light."""


@dataclass(frozen=True, eq=False)
class Part:
    """A body, and where its particles are in a frame's arrays."""

    body: Body
    where: slice


@dataclass(frozen=True, eq=False)
class SystemPart:
    """A further system, and where its fields are in a frame."""

    system: System
    path: str
    """What the names of its fields begin with."""
    index: int
    """Its place among the items of the scene, bodies first."""


@dataclass(frozen=True, eq=False)
class Scale:
    """A scale of colors: a quantity, and its values at the ends of a table of colors."""

    quantity: str
    """A word or two, such as "speed"."""
    unit: str
    """In the usual symbols; empty for a ratio."""
    ends: tuple[float, float]
    """The values at the first and the last color."""
    table: FloatArray
    """Colors, shape (K, 3), as far apart as the values are."""


@dataclass(frozen=True)
class Style(ABC):
    """How some items look. To add one: a file here, and a line in `STYLES`."""

    overlay: ClassVar[bool] = False
    """Whether it adds something to items that are drawn in another style too, instead of being how they look."""

    dimensions: ClassVar[tuple[int, ...]] = (2, 3)
    """In how many dimensions it draws."""

    raises: ClassVar[bool] = False
    """Whether it shows a scene of the plane in space."""

    draws_items: ClassVar[type[Body] | type[System]]
    """The kind of items that it can draw."""

    on: Any = field(default=None, kw_only=True)
    """The item or items drawn in this style, or their names; None: all that it can draw."""

    def __post_init__(self) -> None:
        self._set(on=_chosen(self.on, self.draws_items, f"{type(self).__name__}.on"))

    def _set(self, **values: object) -> None:
        """Replace what the user passed by its checked form; only for `__post_init__`."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _set_positive(self, *names: str) -> None:
        """Check numbers above zero, each of which may be None."""
        for name in names:
            value = getattr(self, name)
            if value is not None:
                self._set(**{name: number(value, f"{type(self).__name__}.{name}", above=0.0)})

    def items(self) -> tuple[Body | System, ...] | None:
        """The items drawn in this style; None: all that it can draw. Those of a film, after `among`."""
        return cast("tuple[Body | System, ...] | None", self.on)  # made so by __post_init__ and `among`

    def among(self, items: Sequence[Body | System]) -> Self:
        """The same style, with the items that are filmed in the place of their names.

        Raises:
            SceneError: there is none of a name.
        """
        if self.on is None or not any(isinstance(each, str) for each in self.on):
            return self
        resolved = copy(self)
        resolved._set(on=_chosen(found(self.on, items, f"{type(self).__name__}.on"), self.draws_items, "style.on"))
        return resolved

    def draws(self, item: Body | System) -> bool:
        """Whether an item is drawn in this style."""
        items = self.items()
        if items is not None:
            return any(item is each for each in items)
        return isinstance(item, self.draws_items) and self.can_draw(item)

    def can_draw(self, item: Any) -> bool:
        """Whether an item of its kind has what this style shows."""
        del item
        return True

    @abstractmethod
    def painters(self, source: Source, items: Sequence[Body | System], theme: Theme) -> list[Painter]:
        """What paints some items, all drawn in this style, frame by frame."""


@dataclass(frozen=True)
class BodyStyle(Style):
    """How some bodies look."""

    draws_items: ClassVar[type[Body] | type[System]] = Body

    on: On = field(default=None, kw_only=True)
    """The body or bodies drawn in this style, or their names; None: all that it can draw."""

    def painters(self, source: Source, items: Sequence[Body | System], theme: Theme) -> list[Painter]:
        """One painter of all bodies."""
        parts = [Part(body, source.scene.slice(body)) for body in items if isinstance(body, Body)]
        painter = self.painter(source, parts, theme)
        painter.parts = parts
        return [painter]

    @abstractmethod
    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """A painter of the given bodies, frame by frame."""


@dataclass(frozen=True)
class SystemStyle(Style):
    """How some systems beside the bodies look, such as fields on grids."""

    draws_items: ClassVar[type[Body] | type[System]] = System

    on: System | str | Sequence[System | str] | None = field(default=None, kw_only=True)
    """The system or systems drawn in this style, or their names; None: all that it can draw."""

    def painters(self, source: Source, items: Sequence[Body | System], theme: Theme) -> list[Painter]:
        """One painter for each system."""
        scene = source.scene
        every = [*scene.bodies, *scene.systems]
        parts = [
            SystemPart(item, str(scene.system(item)), next(at for at, each in enumerate(every) if each is item))
            for item in items
            if isinstance(item, System)
        ]
        return [self.painter(source, part, theme) for part in parts]

    @abstractmethod
    def painter(self, source: Source, part: SystemPart, theme: Theme) -> Painter:
        """A painter of one system, frame by frame."""


class Painter(ABC):
    """Draws some bodies of one source; it first sees the whole film, to find ranges that hold for all of it."""

    style: Style
    """The style that it draws by."""
    quantity: str = ""
    """What its colors show, where the style does not say."""
    top: float = 0.0
    """The value at the end of the color scale. Panels with equal styles and quantities share it."""
    low: float = 0.0
    """The value at its start, likewise."""
    parts: Sequence[Part] = ()
    """The bodies that it draws."""
    fixed: FloatArray | None = None
    """Colors (N, 3) of their particles, if those keep them; None if they show a quantity, or a picture."""

    @property
    def legend(self) -> list[tuple[Body | System, Color]]:
        """The bodies or the system that it draws in one color, with that."""
        if self.fixed is None:
            return []
        ends = np.cumsum([len(part.body) for part in self.parts])
        each = [
            (part.body, only(self.fixed[end - len(part.body) : end]))
            for part, end in zip(self.parts, ends.tolist(), strict=True)
        ]
        return [(body, color) for body, color in each if color is not None]

    @property
    def scale(self) -> Scale | None:
        """The scale of its colors, after the first pass; None if they mean no quantity."""
        return None

    @property
    def traced(self) -> FloatArray | None:
        """Colors (K, 3) of what it draws only where frames follow each other, which samples of a film do not show."""
        return None

    @property
    def palette(self) -> FloatArray:
        """Colors (K, 3) that it may draw in any frame: some of its scale, and the first of each body."""
        firsts = np.cumsum([0, *(len(part.body) for part in self.parts)])[:-1]
        bodies = np.empty((0, 3)) if self.fixed is None else self.fixed[firsts[firsts < len(self.fixed)]]
        table = np.empty((0, 3)) if self.scale is None else self.scale.table
        return np.concatenate([bodies, table[:: max(len(table) // SHOWN, 1)]])

    @property
    def settled(self) -> bool:
        """Whether it knows what to draw without having seen the film first."""
        return True

    def begin(self) -> None:  # noqa: B027 - most painters remember nothing
        """Forget earlier frames: the film starts."""

    @property
    def margin(self) -> float:
        """How far what is drawn reaches beyond the particles' centers in the scene [m], beside their radii."""
        return 0.0

    @property
    def landmarks(self) -> FloatArray | None:
        """Points (P, D) [m] of the picture's space that belong into it, if what is drawn stands still."""
        return None

    def places(self, frame: SourceFrame) -> FloatArray | None:
        """Points (P, D) [m] of a frame that belong into the picture, beside the particles."""
        del frame
        return None

    def raised(self, frame: SourceFrame) -> SourceFrame:
        """The frame as what it draws raises its particles."""
        return frame

    @abstractmethod
    def observe(self, frame: SourceFrame) -> None:
        """Take a frame into account; called for each one before any is drawn."""

    @abstractmethod
    def inset(self, pixels: float) -> float:
        """How far drawings reach beyond the particles' centers [pixels], in a panel of so many pixels."""

    @abstractmethod
    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Add the bodies to the painting of a panel of so many pixels."""


def _chosen(on: object, kind: type[Body] | type[System], path: str) -> tuple[Body | System | str, ...] | None:
    """The items that `on=` says, checked, by themselves or by their names; None: all."""
    if kind is Body or on is None:
        return chosen(on, path)
    systems = (on,) if isinstance(on, (System, str)) else on
    if not isinstance(systems, (tuple, list)) or not all(isinstance(each, (System, str)) for each in systems):
        raise SceneError(
            f"{path}: must be a system of the scene, such as a Wave, its name, or several, got {shown(on)}"
        )
    return tuple(systems)


def drawn_dimension(scene: Scene) -> int:
    """The dimension of the space that a picture shows: what is on a line is drawn in a plane, as a curve."""
    return max(scene.dimension, 2)


def places(parts: Sequence[Part]) -> slice | IntArray:
    """Indices of the particles of some bodies in the arrays of frames; a slice, which copies nothing, if it can be."""
    if all(one.where.stop == other.where.start for one, other in pairwise(parts)):
        return slice(parts[0].where.start, parts[-1].where.stop)
    return np.concatenate([np.arange(part.where.start, part.where.stop) for part in parts])


def body_color(source: Source, part: Part, theme: Theme) -> FloatArray:
    """The color (3,) of a body: each has its own, in turn."""
    return np.array(theme.bodies[list(source.scene.bodies).index(part.body) % len(theme.bodies)], dtype=float)


def straight(domain: Periodic | None, steps: FloatArray) -> BoolArray:
    """Which steps (…, D) [m] go straight; what has left a domain and come back has not crossed the picture."""
    if domain is None:
        return np.ones(steps.shape[:-1], dtype=bool)
    flat = steps.reshape(-1, steps.shape[-1])
    same: BoolArray = (domain.nearest(flat) == flat).all(axis=1).reshape(steps.shape[:-1])
    return same


def only(colors: FloatArray) -> Color | None:
    """The color of several things (N, 3), if it is the same."""
    different = np.unique(colors, axis=0)
    if len(different) != 1:
        return None
    red, green, blue = different[0].astype(int).tolist()
    return red, green, blue


def sums(index: IntArray, values: FloatArray, count: int) -> FloatArray:
    """The sums (count, D) of the rows (N, D) that have each index (N,)."""
    return np.stack([np.bincount(index, weights=column, minlength=count) for column in values.T], axis=1)


def table(colormap: ColormapName | None, theme: Theme, path: str) -> FloatArray:
    """The colors (K, 3) of a map that stand out against the background, or the one of text."""
    return np.array([theme.text], dtype=float) if colormap is None else sequential(colormap, theme.part, path)


def inks(colors: FloatArray, theme: Theme, farness: PixelArray | None) -> InkArray:
    """Opaque inks (N, 4) of colors (N, 3); what is far away fades into the background."""
    result = np.full((len(colors), 4), 255, dtype=np.uint8)
    if farness is not None:
        fog = FOG * farness[:, np.newaxis]
        colors = colors * (1.0 - fog) + np.array(theme.background) * fog
    result[:, :3] = colors
    return result
