"""Colors of particles chosen by the user."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from physcore.checks import FloatArray, is_word, shown
from physcore.errors import SceneError
from physcore.film.colors.chosen import Chosen, PerBody, PerParticle, chosen, numbers
from physcore.film.colors.colormaps import look_up
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import Part, Scale, body_color, places
from physcore.film.styles.typical import Typical
from physcore.simulation.sources import Source, SourceFrame


def checked(value: object, path: str, words: Sequence[str]) -> str | Chosen:
    """One of a style's own words, or a valid choice of colors.

    Raises:
        SceneError: the value is neither.
    """
    for word in words:
        if is_word(value, word):
            return word
    return chosen(value, path, words)


def require_known(color: object, parts: Sequence[Part], path: str) -> None:
    """Check that there are as many colors as particles, and that each body with a color is drawn.

    Raises:
        SceneError: one of these is not true.
    """
    count = sum(len(part.body) for part in parts)
    if isinstance(color, PerParticle) and len(color.values) != count:
        raise SceneError(f"{path}: must be one, or {count} for the particles, got {len(color.values)}")
    if isinstance(color, PerBody):
        known = [key for part in parts for key in (part.body, part.body.name)]
        for key in color.colors:
            if key not in known:
                raise SceneError(f"{path}: {shown(key)} is not among the bodies that are drawn")


def fixed_colors(color: object, source: Source, parts: Sequence[Part], theme: Theme) -> FloatArray | None:
    """The constant colors (N, 3) of particles; None if values or a function determine them."""
    count = sum(len(part.body) for part in parts)
    if isinstance(color, PerParticle):
        return color.values if color.values.ndim == 2 else None
    if isinstance(color, tuple):
        return np.tile(np.array(color, dtype=float), (count, 1))
    if not (is_word(color, "body") or isinstance(color, PerBody)):
        return None
    each = []
    for part in parts:
        own = color.of(part.body) if isinstance(color, PerBody) else None
        each.append(body_color(source, part, theme) if own is None else np.array(own, dtype=float))
    return np.repeat(np.stack(each), [len(part.body) for part in parts], axis=0)


class Coloring:
    """The colors of the particles of some bodies, frame by frame."""

    def __init__(
        self, color: Chosen | str, table: FloatArray, path: str, source: Source, parts: Sequence[Part], theme: Theme
    ) -> None:
        require_known(color, parts, path)
        self._color, self._table, self._path = color, table, path
        self._where, self._count = places(parts), sum(len(part.body) for part in parts)
        prefix = parts[0].prefix if parts else ""
        self._names = f"{prefix}positions", f"{prefix}velocities"
        self.fixed = fixed_colors(color, source, parts, theme)
        """The constant colors (N, 3) of the particles; None if values or a function determine them."""
        self.low, self.top = math.inf, -math.inf
        self._least, self._most = Typical(), Typical()
        if isinstance(color, PerParticle) and color.values.ndim == 1:
            self.low, self.top = float(color.values.min(initial=math.inf)), float(color.values.max(initial=-math.inf))

    @property
    def settled(self) -> bool:
        """Whether the ends of the scale are known, or there is no scale."""
        return not callable(self._color)

    def scale(self, low: float, top: float) -> Scale | None:
        """The color scale between two values; None if there are only colors."""
        if self.fixed is not None or low > top:
            return None
        name = getattr(self._color, "__name__", "value")
        return Scale("value" if name.startswith("<") else name.replace("_", " "), "", (low, top), self._table)

    def observe(self, frame: SourceFrame) -> None:
        """Update the ends of the scale by a frame."""
        if self.settled:
            return
        values = self.values(frame)
        if values.ndim == 1:
            self.low, self.top = -self._least.add(-values), self._most.add(values)

    def colors(self, frame: SourceFrame, low: float, top: float) -> FloatArray:
        """The colors (N, 3) of the particles, with a scale between two values."""
        if self.fixed is not None:
            return self.fixed
        values = self.values(frame)
        return values if values.ndim == 2 else look_up(self._table, (values - low) / ((top - low) or 1.0))

    def values(self, frame: SourceFrame) -> FloatArray:
        """The values (N,) of a frame; or colors (N, 3), if the function returns these."""
        if isinstance(self._color, PerParticle):
            return self._color.values
        assert callable(self._color)
        positions, velocities = self._names
        known = frame.fields[velocities][self._where] if velocities in frame.fields else None
        given = self._color(frame.time, frame.fields[positions][self._where], known)
        values = numbers(given, f"{self._path}(time, positions, velocities)")
        if len(values) != self._count:
            name = self._path
            raise SceneError(f"{name}: the function must give {self._count} values, got {len(values)}")
        return values
