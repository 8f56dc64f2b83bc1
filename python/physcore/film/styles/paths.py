"""Paths of chosen particles over the whole film."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from physcore._core import Canvas
from physcore.checks import FloatArray, IntArray, number, regular, shown
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.themes import Color, Theme, color
from physcore.film.styles.base import BodyStyle, Painter, Part, body_color, inks
from physcore.film.styles.past import Past
from physcore.scene.bodies import Body
from physcore.simulation.sources import Source, SourceFrame

FRESH = 0.85
"""Opacity of a path."""


@dataclass(frozen=True)
class Paths(BodyStyle):
    """Paths of chosen particles since the start of the film, as lines in the colors in which the particles are drawn.

        pc.film(recording, "balls.gif", style=[pc.styles.Paths([0, 5], color="gold", fade=1.0), pc.styles.Points()])

    Paths are an overlay, in addition to the styles of the bodies. Velocities, if recorded, determine the curves between
    frames, with a corner at a bounce. Fading paths are blended additively: they only lighten a dark background, or only
    darken a light one.

    Args:
        particles: indices within each body, shape (K,); negative ones count from the end. None: all.
        width: width of the lines [pixels].
        fade: duration for which a path is shown [s]; it fades and thins with age. None: for the whole film, unchanged.
        color: color of the lines, such as "tomato" or "#10c0ff"; None: the constant color that another style, such as
            Points, gives the particle, otherwise that of its body.
        on: as in Style.

    Raises:
        SceneError: a value is not valid, or an index is outside of a body.
    """

    overlay: ClassVar[bool] = True

    particles: ArrayLike | None = None
    width: float = 1.4
    fade: float | None = None
    color: str | Color | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(width=number(self.width, "Paths.width", above=0.0))
        self._set_positive("fade")
        if self.color is not None:
            self._set(color=color(self.color, "Paths.color"))
        if self.particles is not None:
            given = np.atleast_1d(regular(self.particles, "Paths.particles"))
            if given.ndim != 1 or given.size == 0 or given.dtype.kind not in "iu":
                raise SceneError(f"Paths.particles: must be a list of indices, got {shown(self.particles)}")
            object.__setattr__(self, "particles", tuple(given.tolist()))

    def can_draw(self, body: Body) -> bool:
        """Whether a body has particles with these indices."""
        chosen = self.particles if isinstance(self.particles, tuple) else (0,)
        return all(-len(body) <= index < len(body) for index in chosen)

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter of one source."""
        for part in parts:
            if not self.can_draw(part.body):
                raise SceneError(f"Paths.particles: must be particles of {part.body!r}, got {self.particles}")
        return PathsPainter(self, source, parts, theme)


class PathsPainter(Painter):
    """Painter of paths."""

    def __init__(self, style: Paths, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._width, self._theme = style, style.width, theme
        where, colors = [], []
        for part in parts:
            every = np.arange(part.where.start, part.where.stop)
            mine = every if style.particles is None else every[list(np.asarray(style.particles))]
            where.append(mine)
            own = (
                body_color(source, part, theme) if style.color is None else np.array(color(style.color, "Paths.color"))
            )
            colors.append(np.tile(own.astype(float), (len(mine), 1)))
        self._where: IntArray = np.concatenate(where)
        self._shade = theme.background
        self._colors = self._blended(np.concatenate(colors))
        frames = None if style.fade is None else 1 + round(min(style.fade * source.fps, source.count))
        self._past = Past(1.0 / source.fps, frames, source.scene.periodic)

    def _blended(self, colors: FloatArray) -> FloatArray:
        """Colors (N, 3) of lines through which the background shines."""
        return FRESH * colors + (1.0 - FRESH) * np.array(self._shade)

    def meet(self, painters: Sequence[Painter]) -> None:
        """Take the constant colors that other painters give the same particles, unless a color was asked for."""
        assert isinstance(self.style, Paths)
        if self.style.color is not None:
            return
        for painter in painters:
            if painter is self or painter.fixed is None:
                continue
            drawn = np.concatenate([np.arange(part.where.start, part.where.stop) for part in painter.parts])
            if len(drawn) == len(painter.fixed):
                known = dict(zip(drawn.tolist(), painter.fixed, strict=True))
                rows = [row for row, particle in enumerate(self._where.tolist()) if particle in known]
                if rows:
                    self._colors[rows] = self._blended(
                        np.stack([known[particle] for particle in self._where[rows].tolist()])
                    )

    @property
    def traced(self) -> FloatArray:
        """The colors of the lines."""
        return np.unique(self._colors, axis=0)

    def begin(self) -> None:
        """Forget the paths."""
        self._past.begin()

    def observe(self, frame: SourceFrame) -> None:
        """Do nothing: the painter does not depend on the whole film."""

    def inset(self, pixels: float) -> float:
        """Half the width of a line."""
        del pixels
        return self._width / 2 + 0.5

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue the lines."""
        del pixels
        velocities = frame.fields["velocities"][self._where] if "velocities" in frame.fields else None
        self._past.add(frame.time, frame.positions[self._where], velocities)
        points, depth = self._past.seen(view)
        gaps = self._past.gaps
        if self._past.frames is not None:
            widths = np.full(len(self._colors), self._width, dtype=np.float32)
            plain = inks(self._colors, self._theme, None)
            canvas.trails(points, widths, plain, (self._theme.background, 1.0), gaps, depth)
            return
        ends = np.concatenate([points[:-1], points[1:]], axis=2).reshape(-1, 4)
        far = None if depth is None else depth[1:].ravel()
        ink = inks(np.tile(self._colors, (len(points) - 1, 1)), self._theme, None if far is None else view.farness(far))
        whole = slice(None) if gaps is None else ~gaps.ravel()
        widths = np.full(len(ends[whole]), self._width, dtype=np.float32)
        both = None if depth is None else np.stack([depth[:-1].ravel(), depth[1:].ravel()], axis=1)
        canvas.lines(ends[whole], widths, ink[whole], None if both is None else both[whole])
