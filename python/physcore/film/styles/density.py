"""Very many tracers as the density of their light."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray, number
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.colormaps import ColormapName, sequential
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import BRIGHT, Painter, SystemPart, SystemStyle
from physcore.film.styles.typical import MANY
from physcore.scene.points import PointSystem
from physcore.simulation.sources import Source, SourceFrame

SPREADS = (0.55, 1.3)
"""The smallest and the largest standard deviation of a tracer's light that is chosen by itself [pixels]."""
WIDEST = 1000.0
"""The largest one that can be asked for [pixels]."""
SPACING = 0.25
"""That as a fraction of the mean distance that the tracers would have if they filled the panel."""
FEW = 200
"""Up to so many tracers are drawn one by one, where nothing is said."""
STRAY = 5e-4
"""The share of tracers at either end of each axis for which the picture does not become larger."""


@dataclass(frozen=True)
class Density(SystemStyle):
    """Tracers as light that adds up, however many they are, exposed by the tone curve of a film.

        pc.film(recording, "butterfly.gif", style=pc.styles.Density(colormap="magma", exposure=1.5))

    Each frame is exposed for the density in which its typical tracer is, so that thin sheets and the dense middle are
    seen together. Light from behind passes through.

    Args:
        colormap: "inferno", "magma", "plasma", "viridis", "cividis", "water" or "ember".
        exposure: how bright it is, above zero; 1 is exposed well.
        spread: the standard deviation of a tracer's light [pixels]; None: as fits their number.
        on: the tracers drawn in this style; None: all systems of more than 200 points.

    Raises:
        SceneError: a value is not valid, or positions were not recorded.

    Source: of the tone curve, K. Narkowicz, "ACES filmic tone mapping curve", 2016.
    """

    colormap: ColormapName = "inferno"
    exposure: float = 1.0
    spread: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        sequential(self.colormap, (0.0, 1.0), "Density.colormap")
        self._set(exposure=number(self.exposure, "Density.exposure", above=0.0, most=1e6))
        if self.spread is not None:
            self._set(spread=number(self.spread, "Density.spread", above=0.0, most=WIDEST))

    def can_draw(self, item: object) -> bool:
        """Whether it consists of many points."""
        return isinstance(item, PointSystem) and len(item) > FEW

    def painter(self, source: Source, part: SystemPart, theme: Theme) -> Painter:
        """A painter of one system."""
        return DensityPainter(self, source, part, theme)


class PointsPainter(Painter):
    """The base of painters of points."""

    def __init__(self, style: SystemStyle, source: Source, part: SystemPart) -> None:
        kind = type(style).__name__
        if not isinstance(part.system, PointSystem):
            raise SceneError(f"{kind}.on: {part.system!r} has no points; only tracers and vortices have")
        self.style, self._system, self._field = style, part.system, f"{part.path}.positions"
        if not source.has(self._field):
            raise SceneError(f"{kind}.on: {self._field} were not recorded; record them: channels=({self._field!r},)")

    def observe(self, frame: SourceFrame) -> None:
        """Nothing depends on the film."""

    def places(self, frame: SourceFrame) -> FloatArray:
        """The points; of very many the box of all but strays, by its corners."""
        points = frame.fields[self._field]
        few = points[:: 1 + len(points) // MANY]
        stray = int(STRAY * len(few))
        if stray == 0:
            return points
        ordered = np.partition(few, (stray, len(few) - 1 - stray), axis=0)
        return np.stack([ordered[stray], ordered[-1 - stray]])


class DensityPainter(PointsPainter):
    """Draws the density behind all shapes."""

    def __init__(self, style: Density, source: Source, part: SystemPart, theme: Theme) -> None:
        super().__init__(style, source, part)
        self._exposure, self._spread = style.exposure, style.spread
        ends = (1.0, 0.0) if sum(theme.background) > BRIGHT else (0.0, 1.0)
        table = sequential(style.colormap, (0.0, 1.0), "Density.colormap")
        self._table = np.ascontiguousarray(np.round(table if ends[0] < ends[1] else table[::-1]).astype(np.uint8))

    def inset(self, pixels: float) -> float:
        """The reach of a tracer's light."""
        return 2.0 * self._chosen(pixels)

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Draw the density at once."""
        centers, _, _ = view.project(frame.fields[self._field])
        canvas.density(np.ascontiguousarray(centers), self._table, self._exposure, self._chosen(pixels))

    def _chosen(self, pixels: float) -> float:
        """The standard deviation of a tracer's light [pixels]."""
        if self._spread is not None:
            return self._spread
        least, most = SPREADS
        return float(np.clip(SPACING * math.sqrt(pixels / max(len(self._system), 1)), least, most))
