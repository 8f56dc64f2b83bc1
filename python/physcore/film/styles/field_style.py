"""Base class of the styles of vector fields."""

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
"""Largest length and spacing [pixels], larger than any picture."""


@dataclass(frozen=True)
class FieldStyle(BodyStyle):
    """Overlay of a vector field, colored by its magnitude; `of`, `colormap` and `top` as in Arrows."""

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
        """The painter with the color scale of one film."""
        return self.field_painter(field(self.of, source, parts, f"{type(self).__name__}.of"), theme)

    @abstractmethod
    def field_painter(self, shown: Field, theme: Theme) -> Painter:
        """The painter of a field."""


class FieldPainter(Painter):
    """Base painter, which finds the magnitude of the field at the particles, because the view is not known yet."""

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
        """The color scale; None if all arrows have one color."""
        quantity, unit = UNITS.get(self._of, ("field", ""))
        return None if self._plain else Scale(quantity, unit, (0.0, self.top), self._table)

    def observe(self, frame: SourceFrame) -> None:
        """Update the end of the scale by a frame."""
        if not self.settled:
            self.top = self._typical.add(norms(self._field.known(frame)))
