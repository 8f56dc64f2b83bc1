"""Base classes of all styles and painters."""

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
from physcore.film.camera.view import FOG, PixelArray, View
from physcore.film.colors.colormaps import WHOLE, ColormapName, sequential
from physcore.film.colors.themes import Color, Theme
from physcore.film.page.tape import Tape
from physcore.scene.bodies import Body
from physcore.scene.periodic import Periodic
from physcore.scene.scene import Scene
from physcore.scene.system import System
from physcore.scene.targets import On, chosen, found
from physcore.simulation.sources import Source, SourceFrame

InkArray = NDArray[np.uint8]
"""Red, green, blue and opacity, 0–255, shape (N, 4)."""

SHADING = 0.85
"""Strength of the lighting of balls."""
SHOWN = 16
"""Least number of colors of a scale in a palette."""
BRIGHT = 384
"""A background is light if its red, green and blue add up to more than this."""


@dataclass(frozen=True, eq=False)
class Part:
    """A body and the slice of its particles in the arrays of a frame."""

    body: Body
    where: slice
    """Rows of the body in the fields of its particles, or of its rigid bodies."""
    prefix: str = ""
    """Prefix of the names of its fields."""


@dataclass(frozen=True, eq=False)
class SystemPart:
    """A system and the location of its fields in a frame."""

    system: System
    path: str
    """Prefix of the names of its fields."""
    index: int
    """Index among the items of the scene, bodies first."""


@dataclass(frozen=True, eq=False)
class Scale:
    """Color scale: a quantity, and its values at the ends of a table of colors."""

    quantity: str
    """Name of the quantity, such as "speed"."""
    unit: str
    """Unit in the usual symbols; empty for a ratio."""
    ends: tuple[float, float]
    """The values at the first and the last color."""
    table: FloatArray
    """Colors of equidistant values, shape (K, 3)."""


@dataclass(frozen=True)
class Style(ABC):
    """Base class of styles, which say how items are drawn. To add a style: a module here, and a line in `STYLES`."""

    overlay: ClassVar[bool] = False
    """Whether the style is drawn in addition to another style of the same items."""

    dimensions: ClassVar[tuple[int, ...]] = (2, 3)
    """Numbers of dimensions that the style supports."""

    raises: ClassVar[bool] = False
    """Whether the style shows a 2D scene in 3D."""

    draws_items: ClassVar[type[Body] | type[System] | tuple[type, ...]]
    """The class or classes of items that the style can draw."""

    on: Any = field(default=None, kw_only=True)
    """The item or items drawn in this style, or their names; None: all items that the style can draw."""

    def __post_init__(self) -> None:
        self._set(on=_chosen(self.on, self.draws_items, f"{type(self).__name__}.on"))

    def _set(self, **values: object) -> None:
        """Replace the user's values by their validated form; only for `__post_init__` and `among`."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _set_positive(self, *names: str) -> None:
        """Check numbers above zero, each of which may be None."""
        for name in names:
            value = getattr(self, name)
            if value is not None:
                self._set(**{name: number(value, f"{type(self).__name__}.{name}", above=0.0)})

    def items(self) -> tuple[Body | System, ...] | None:
        """The items drawn in this style; None: all items that the style can draw. Names are resolved by `among`."""
        return cast("tuple[Body | System, ...] | None", self.on)  # converted by __post_init__ and `among`

    def among(self, items: Sequence[Body | System]) -> Self:
        """A copy of the style in which names are replaced by the items of the film.

        Raises:
            SceneError: no item has such a name.
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
        """Whether an item has the properties that this style shows."""
        del item
        return True

    @abstractmethod
    def painters(self, source: Source, items: Sequence[Body | System], theme: Theme) -> list[Painter]:
        """The painters of items that are all drawn in this style."""


@dataclass(frozen=True)
class BodyStyle(Style):
    """Base class of styles of bodies."""

    draws_items: ClassVar[type[Body] | type[System]] = Body

    rigid: ClassVar[bool] = False
    """Whether the style draws rigid bodies, which are no particles."""

    on: On = field(default=None, kw_only=True)
    """The body or bodies drawn in this style, or their names; None: all bodies that the style can draw."""

    def draws(self, item: Body | System) -> bool:
        """Whether an item is drawn in this style."""
        kind = self.items() is not None or getattr(item, "is_rigid", False) == self.rigid
        return kind and super().draws(item)

    def painters(self, source: Source, items: Sequence[Body | System], theme: Theme) -> list[Painter]:
        """One painter for all bodies."""
        bodies = cast("Sequence[Body]", items)
        for body in bodies:
            if body.is_rigid != self.rigid:
                kind, other = ("rigid bodies", "Solids") if body.is_rigid else ("particles", "Points")
                raise SceneError(f"{type(self).__name__}.on: {body!r} consists of {kind}; draw it by {other}")
        parts = [part_of(source.scene, body) for body in bodies]
        painter = self.painter(source, parts, theme)
        painter.parts = parts
        return [painter]

    @abstractmethod
    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter of the given bodies."""


@dataclass(frozen=True)
class SystemStyle(Style):
    """Base class of styles of systems that are not bodies, such as fields on grids."""

    draws_items: ClassVar[type[Body] | type[System]] = System

    on: System | str | Sequence[System | str] | None = field(default=None, kw_only=True)
    """The system or systems drawn in this style, or their names; None: all systems that the style can draw."""

    def painters(self, source: Source, items: Sequence[Body | System], theme: Theme) -> list[Painter]:
        """One painter for each system."""
        scene = source.scene
        every = [*scene.bodies, *scene.systems]
        parts = [
            SystemPart(item, str(scene.system(item)), next(at for at, each in enumerate(every) if each is item))
            for item in cast("Sequence[System]", items)
        ]
        return [self.painter(source, part, theme) for part in parts]

    @abstractmethod
    def painter(self, source: Source, part: SystemPart, theme: Theme) -> Painter:
        """The painter of one system."""


class Painter(ABC):
    """Base class of painters, which draw some bodies of one source. A painter first observes the whole film, to find
    ranges that are valid for all frames.
    """

    style: Style
    """The style of the painter."""
    quantity: str = ""
    """Name of the quantity shown by colors, if it is not given by the style."""
    top: float = 0.0
    """Value at the upper end of the color scale. Panels with equal styles and quantities share it."""
    low: float = 0.0
    """Value at the lower end of the color scale, likewise."""
    domain: Periodic | None = None
    """The periodic domain as it is shown in the frame to be painted; None without one."""
    parts: Sequence[Part] = ()
    """The bodies that the painter draws."""
    fixed: FloatArray | None = None
    """Constant colors (N, 3) of the particles; None if colors show a quantity, or for a picture."""

    @property
    def legend(self) -> list[tuple[Body | System, Color]]:
        """The bodies or the system that are drawn in one color, each with this color."""
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
        """The color scale, after the first pass; None if colors show no quantity."""
        return None

    @property
    def traced(self) -> FloatArray | None:
        """Colors (K, 3) of lines between successive frames, which samples of a film do not contain; None without such
        lines.
        """
        return None

    @property
    def palette(self) -> FloatArray:
        """Colors (K, 3) that may occur in any frame: some of the scale, and the first color of each body."""
        firsts = np.cumsum([0, *(len(part.body) for part in self.parts)])[:-1]
        bodies = np.empty((0, 3)) if self.fixed is None else self.fixed[firsts[firsts < len(self.fixed)]]
        table = np.empty((0, 3)) if self.scale is None else self.scale.table
        return np.concatenate([bodies, table[:: max(len(table) // SHOWN, 1)]])

    @property
    def settled(self) -> bool:
        """Whether the painter is ready without a first pass."""
        return True

    def begin(self) -> None:  # noqa: B027 - most painters remember nothing
        """Reset all state that depends on earlier frames, at the start of the film."""

    @property
    def margin(self) -> float:
        """Extent of the drawn shapes beyond the centers of the particles [m], in addition to their radii."""
        return 0.0

    @property
    def landmarks(self) -> FloatArray | None:
        """Points (P, D) [m] that belong in the picture, if the drawn object is at rest; otherwise None."""
        return None

    @property
    def scenery(self) -> list[tuple[FloatArray, float]]:
        """Points (P, D) [m] of bodies at rest, each with a margin [m], which belong in the picture if they are near."""
        return []

    @property
    def reach(self) -> float:
        """Extent of rigid bodies beyond their centers [m]."""
        return 0.0

    def places(self, frame: SourceFrame) -> FloatArray | None:
        """Points (P, D) [m] of a frame that belong in the picture, in addition to the particles."""
        del frame
        return None

    def spread(self, part: Part, frame: SourceFrame) -> tuple[FloatArray, FloatArray]:
        """The centers (N, D) and radii (N,) [m] of a body that the painter draws."""
        return frame.positions[part.where], part.body.radius

    def meet(self, painters: Sequence[Painter]) -> None:
        """Take from all painters of the same picture what the own drawing depends on; called once, before the film."""
        del painters

    def raised(self, frame: SourceFrame) -> SourceFrame:
        """The frame with particles raised to the height that this painter shows."""
        return frame

    @abstractmethod
    def observe(self, frame: SourceFrame) -> None:
        """Observe a frame in the first pass; called for every frame before the first one is drawn."""

    @abstractmethod
    def inset(self, pixels: float) -> float:
        """Extent of the drawn shapes beyond the centers of the particles [pixels], in a panel of `pixels` pixels."""

    @abstractmethod
    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Draw or queue the bodies in a panel of `pixels` pixels."""

    def record(self, tape: Tape, frame: SourceFrame, view: View, pixels: float) -> None:
        """Put the bodies on the tape of a page, as `paint` draws them. A painter of surfaces in 3D has a way of its
        own, because `paint` leaves out what the camera does not see.

        Raises:
            SceneError: a page cannot show this.
        """
        self.paint(cast("Canvas", tape), frame, view, pixels)


def _chosen(
    on: object, kind: type[Body] | type[System] | tuple[type, ...], path: str
) -> tuple[Body | System | str, ...] | None:
    """The validated value of `on`, as items or names; None: all."""
    if isinstance(kind, tuple):
        return chosen(on, path, kind)
    if on is None or kind.section == "bodies":
        return chosen(on, path)
    systems = (on,) if isinstance(on, (System, str)) else on
    if not isinstance(systems, (tuple, list)) or not all(isinstance(each, (System, str)) for each in systems):
        raise SceneError(
            f"{path}: must be a system of the scene, such as a Wave, its name, or several, got {shown(on)}"
        )
    return tuple(systems)


def drawn_dimension(scene: Scene) -> int:
    """The dimension of the picture's space. A system in 1D is drawn in 2D, as a curve."""
    return max(scene.dimension, 2)


def part_of(scene: Scene, body: Body) -> Part:
    """A body with its rows in the fields of a scene."""
    if not body.is_rigid:
        return Part(body, scene.slice(body))
    return Part(body, cast("slice", scene.parts(body)["positions"][1]), "rigid_")


def places(parts: Sequence[Part]) -> slice | IntArray:
    """Indices of the particles of some bodies in the arrays of frames; a slice, which avoids a copy, if they are
    contiguous.
    """
    if all(one.where.stop == other.where.start for one, other in pairwise(parts)):
        return slice(parts[0].where.start, parts[-1].where.stop)
    return np.concatenate([np.arange(part.where.start, part.where.stop) for part in parts])


def body_color(source: Source, part: Part, theme: Theme) -> FloatArray:
    """The color (3,) of a body: each body has its own, in turn."""
    return np.array(theme.bodies[list(source.scene.bodies).index(part.body) % len(theme.bodies)], dtype=float)


def straight(domain: Periodic | None, steps: FloatArray) -> BoolArray:
    """Mask of the steps (…, D) [m] that do not cross a face of the periodic domain."""
    if domain is None:
        return np.ones(steps.shape[:-1], dtype=bool)
    flat = steps.reshape(-1, steps.shape[-1])
    same: BoolArray = (domain.nearest(flat) == flat).all(axis=1).reshape(steps.shape[:-1])
    return same


def only(colors: FloatArray) -> Color | None:
    """The common color of several colors (N, 3); None if they differ."""
    different = np.unique(colors, axis=0)
    if len(different) != 1:
        return None
    red, green, blue = different[0].astype(int).tolist()
    return red, green, blue


def table(colormap: ColormapName | None, theme: Theme, path: str) -> FloatArray:
    """The colors (K, 3) of a map that contrast with the background; without a map, the color of text."""
    return np.array([theme.text], dtype=float) if colormap is None else sequential(colormap, WHOLE, path)


def inks(colors: FloatArray, theme: Theme, farness: PixelArray | None) -> InkArray:
    """Opaque inks (N, 4) of colors (N, 3). Distant objects fade into the background."""
    result = np.full((len(colors), 4), 255, dtype=np.uint8)
    if farness is not None:
        fog = FOG * farness[:, np.newaxis]
        colors = colors * (1.0 - fog) + np.array(theme.background) * fog
    result[:, :3] = colors
    return result
