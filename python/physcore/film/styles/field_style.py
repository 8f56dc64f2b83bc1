"""The base of the styles that show vector fields."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from physcore._core import norms
from physcore.film.colors.colormaps import ColormapName, sequential
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import BodyStyle, Painter, Part, Scale, table
from physcore.film.styles.fields import UNITS, Field, Of, check_field, field
from physcore.film.styles.typical import Typical
from physcore.simulation.sources import Source, SourceFrame

LONGEST = 10_000.0
"""The greatest length and spacing [pixels]: more than crosses any picture."""


@dataclass(frozen=True)
class FieldStyle(BodyStyle):
    """A field drawn over what moves, colored by its strength; `of`, `colormap` and `top` as in Arrows."""

    overlay: ClassVar[bool] = True

    of: Of = "velocities"
    colormap: ColormapName | None = None
    top: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.colormap is not None:
            sequential(self.colormap, (0.0, 1.0), f"{type(self).__name__}.colormap")
        check_field(self.of, f"{type(self).__name__}.of")
        self._set_positive("top")

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """A painter with the scale of one film."""
        return self.field_painter(field(self.of, source, parts, f"{type(self).__name__}.of"), theme)

    @abstractmethod
    def field_painter(self, shown: Field, theme: Theme) -> Painter:
        """The painter of a field."""


class FieldPainter(Painter):
    """Finds how strong the field is, among the particles themselves: there is no picture yet."""

    def __init__(self, style: FieldStyle, shown: Field, theme: Theme) -> None:
        self.style, self._top, self._field, self._theme = style, style.top, shown, theme
        self._of, self._plain = str(style.of), style.colormap is None
        self._table = table(style.colormap, theme, f"{type(style).__name__}.colormap")
        self.top, self._typical = style.top or 0.0, Typical()

    @property
    def settled(self) -> bool:
        """Whether the end of the scale was given."""
        return self._top is not None

    @property
    def scale(self) -> Scale | None:
        """The scale of colors, where there is more than one."""
        quantity, unit = UNITS.get(self._of, ("field", ""))
        return None if self._plain else Scale(quantity, unit, (0.0, self.top), self._table)

    def observe(self, frame: SourceFrame) -> None:
        """Find the end of the scale."""
        if not self.settled:
            self.top = self._typical.add(norms(self._field.known(frame)))
