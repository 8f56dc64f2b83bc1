"""Few tracers as discs with fading trails."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physcore._core import Canvas
from physcore.checks import number
from physcore.film.camera.view import View
from physcore.film.colors.themes import Color, Theme, color
from physcore.film.styles.base import SHADING, SystemPart, SystemStyle, inks, only
from physcore.film.styles.curve import BETWEEN
from physcore.film.styles.density import FEW, PointsPainter
from physcore.film.styles.past import Past
from physcore.scene.bodies import Body
from physcore.scene.system import System
from physcore.simulation.sources import Source, SourceFrame

SHARE = 0.3
"""Default duration of a trail, as a fraction of the film."""
FRESH = 0.9
"""Opacity of the newest part of a trail."""
LONGEST = 400_000
"""Largest number of points of all trails."""


@dataclass(frozen=True)
class Trails(SystemStyle):
    """Tracers as discs with trails, which taper and fade.

        pc.film(recording, "lorenz.gif", style=pc.styles.Trails(duration=4.0))

    Trails are cubic interpolants of the positions and velocities in the frames, if velocities were recorded. Each
    tracer has its own color; with several systems of tracers in a scene, each system has its own color. Vortices have
    one color for each sign of their circulation.

    Args:
        duration: duration of a trail [s]; None: three tenths of the film.
        width: width of a trail at its newest end [pixels].
        size: diameter of the discs [pixels].
        color: one color for all, such as "tomato" or "#10c0ff".
        on: the tracers drawn in this style; None: all systems of up to 200 points.

    Raises:
        SceneError: a value is not valid, or positions were not recorded.
    """

    duration: float | None = None
    width: float = 1.8
    size: float = 5.0
    color: str | Color | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.duration is not None:
            self._set(duration=number(self.duration, "Trails.duration", least=0.0))
        self._set_positive("width", "size")
        if self.color is not None:
            self._set(color=color(self.color, "Trails.color"))

    def can_draw(self, item: System) -> bool:
        """Whether an item has few points."""
        return item.elements.get("points", FEW + 1) <= FEW

    def painter(self, source: Source, part: SystemPart, theme: Theme) -> TrailsPainter:
        """The painter of one system."""
        return TrailsPainter(self, source, part, theme)


class TrailsPainter(PointsPainter):
    """Painter of trails and discs."""

    def __init__(self, style: Trails, source: Source, part: SystemPart, theme: Theme) -> None:
        super().__init__(style, source, part)
        self._trails, self._theme = style, theme
        rates = f"{part.path}.velocities"
        self._rates = rates if source.has(rates) else None
        frames = SHARE * source.count if style.duration is None else min(style.duration * source.fps, source.count)
        most = LONGEST // max(len(self._system) * BETWEEN, 1)
        self._past = Past(1.0 / source.fps, max(1, min(round(frames), most)))
        palette = np.array(theme.bodies, dtype=float)
        each = np.arange(len(self._system)) % len(palette)
        if self._system.signs is not None:
            each = self._system.signs.astype(int)
        elif sum(other.signs is None for other in source.scene.clouds) > 1:
            each[:] = part.index % len(palette)
        self._colors = palette[each]
        if style.color is not None:
            self._colors[:] = style.color

    @property
    def legend(self) -> list[tuple[Body | System, Color]]:
        """The system, if all its points have the same color."""
        color = only(self._colors)
        return [] if color is None else [(self._system, color)]

    def begin(self) -> None:
        """Forget the trails."""
        self._past.begin()

    def inset(self, pixels: float) -> float:
        """The radius of a disc."""
        del pixels
        return self._trails.size / 2 + 1.0

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue the trails, then the discs."""
        del pixels
        points = frame.fields[self._field]
        self._past.add(frame.time, points, None if self._rates is None else frame.fields[self._rates])
        places, depth = self._past.seen(view)
        widths = np.full(len(points), self._trails.width, dtype=np.float32)
        plain = inks(self._colors, self._theme, None)
        canvas.trails(places, widths, plain, (self._theme.background, FRESH), None, depth)
        centers, near, scale = view.project(points)
        radii = (0.5 * self._trails.size * scale / view.scale).astype(np.float32)
        ink = inks(self._colors, self._theme, None if near is None else view.farness(near))
        canvas.discs(centers, radii, ink, near, 0.0 if view.flat else SHADING)
