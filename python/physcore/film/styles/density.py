"""Very many tracers, drawn as a density."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray, number
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.colormaps import WHOLE, ColormapName, ramp
from physcore.film.colors.themes import Theme
from physcore.film.page.tape import Tape
from physcore.film.styles.base import BRIGHT, Painter, SystemPart, SystemStyle
from physcore.film.styles.typical import MANY
from physcore.scene.points import PointSystem
from physcore.scene.system import System
from physcore.simulation.sources import Source, SourceFrame

SPREADS = (0.55, 1.3)
"""Smallest and largest standard deviation of a tracer's light that is chosen automatically [pixels]."""
WIDEST = 1000.0
"""Largest standard deviation that may be given [pixels]."""
SPACING = 0.25
"""Standard deviation as a fraction of the mean spacing of tracers that fill the panel evenly."""
FEW = 200
"""Number of tracers up to which they are drawn one by one by default."""
STRAY = 5e-4
"""Fraction of tracers at either end of each axis that the framing ignores as outliers."""


@dataclass(frozen=True)
class Density(SystemStyle):
    """Density of any number of tracers, as additive light with a filmic tone curve.

        pc.film(recording, "butterfly.gif", style=pc.styles.Density(colormap="magma", exposure=1.5))

    The exposure of each frame is set by the density at its typical tracer. Thin sheets and the dense middle are thus
    visible together. Light from behind is not absorbed.

    Args:
        colormap: "inferno", "magma", "plasma", "viridis", "cividis", "water" or "ember"; None: "inferno".
        exposure: factor of the brightness, above zero; 1 is the automatic exposure.
        spread: the standard deviation of a tracer's light [pixels]; None: a value that suits the number of tracers.
        on: the tracers drawn in this style; None: all systems of more than 200 points.

    Raises:
        SceneError: a value is not valid, or positions were not recorded.

    Source: K. Narkowicz, "ACES filmic tone mapping curve", 2016, for the tone curve.
    """

    colormap: ColormapName | None = None
    exposure: float = 1.0
    spread: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        ramp(self.colormap, "inferno", WHOLE, "Density.colormap")
        self._set(exposure=number(self.exposure, "Density.exposure", above=0.0, most=1e6))
        if self.spread is not None:
            self._set(spread=number(self.spread, "Density.spread", above=0.0, most=WIDEST))

    def can_draw(self, item: System) -> bool:
        """Whether an item has many points."""
        return item.elements.get("points", 0) > FEW

    def painter(self, source: Source, part: SystemPart, theme: Theme) -> Painter:
        """The painter of one system."""
        return DensityPainter(self, source, part, theme)


class PointsPainter(Painter):
    """Base class of painters of points."""

    def __init__(self, style: SystemStyle, source: Source, part: SystemPart) -> None:
        kind = type(style).__name__
        if "points" not in part.system.elements:
            raise SceneError(f"{kind}.on: {part.system!r} has no points; only tracers and vortices have")
        self.style, self._system, self._field = style, cast("PointSystem", part.system), f"{part.path}.positions"
        if not source.has(self._field):
            raise SceneError(f"{kind}.on: {self._field} were not recorded; record them: channels=({self._field!r},)")

    def observe(self, frame: SourceFrame) -> None:
        """Do nothing: the painter does not depend on the whole film."""

    def places(self, frame: SourceFrame) -> FloatArray:
        """The points. For very many points, two corners of their bounding box without outliers."""
        points = frame.fields[self._field]
        few = points[:: 1 + len(points) // MANY]
        stray = int(STRAY * len(few))
        if stray == 0:
            return points
        ordered = np.partition(few, (stray, len(few) - 1 - stray), axis=0)
        return np.stack([ordered[stray], ordered[-1 - stray]])


class DensityPainter(PointsPainter):
    """Painter of a density, behind all shapes."""

    def __init__(self, style: Density, source: Source, part: SystemPart, theme: Theme) -> None:
        super().__init__(style, source, part)
        self._exposure, self._spread = style.exposure, style.spread
        ends = (1.0, 0.0) if sum(theme.background) > BRIGHT else (0.0, 1.0)
        table = ramp(style.colormap, "inferno", WHOLE, "Density.colormap")
        self._table = np.ascontiguousarray(np.round(table if ends[0] < ends[1] else table[::-1]).astype(np.uint8))

    def inset(self, pixels: float) -> float:
        """The radius of a tracer's light."""
        return 2.0 * self._chosen(pixels)

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Draw the density immediately."""
        centers, _, _ = view.project(frame.fields[self._field])
        canvas.density(np.ascontiguousarray(centers), self._table, self._exposure, self._chosen(pixels))

    def record(self, tape: Tape, frame: SourceFrame, view: View, pixels: float) -> None:
        """Put the tracers on a tape, in 3D with their places."""
        points = frame.fields[self._field]
        centers = np.ascontiguousarray(view.project(points)[0])
        tape.density(centers, self._table, self._exposure, self._chosen(pixels), None if view.flat else points)

    def _chosen(self, pixels: float) -> float:
        """The standard deviation of a tracer's light [pixels]."""
        if self._spread is not None:
            return self._spread
        least, most = SPREADS
        return float(np.clip(SPACING * math.sqrt(pixels / max(len(self._system), 1)), least, most))
