"""Very many tracers or particles, drawn as a density or as light."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, cast

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray, number
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.chosen import Chosen, ColorChoice, PerBody, PerParticle
from physcore.film.colors.colormaps import WHOLE, ColormapName, ramp
from physcore.film.colors.themes import Theme
from physcore.film.page.tape import Tape
from physcore.film.styles.base import BRIGHT, Painter, Part, Scale, Style, SystemPart, SystemStyle, part_of, places
from physcore.film.styles.coloring import Coloring, checked
from physcore.film.styles.typical import MANY
from physcore.scene.bodies import Body
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
HALO = 128
"""Opacity of the halo of a particle on a page."""
STRAY = 5e-4
"""Fraction of tracers at either end of each axis that the framing ignores as outliers."""


@dataclass(frozen=True)
class Density(Style):
    """Density of any number of tracers or particles, as additive light with a filmic tone curve.

        pc.film(recording, "butterfly.gif", style=pc.styles.Density(colormap="magma", exposure=1.5))
        pc.film(recording, "galaxies.gif", style=pc.styles.Density(color={"near": "#9fc4ff", "far": "#ffc98a"}))

    The exposure of each frame is set by the density at its typical tracer. Thin sheets and the dense middle are thus
    visible together. Light from behind is not absorbed.

    Args:
        colormap: "inferno", "magma", "plasma", "viridis", "cividis", "water" or "ember", for the density; None:
            "inferno".
        exposure: factor of the brightness, above zero; 1 is the automatic exposure.
        spread: the standard deviation of a tracer's light [pixels]; None: a value that suits the number of tracers.
        color: the color of the light of each particle, as of stars: one such as "tomato", one for each body or
            particle, or a function that gives colors, as in Points; "body": the color of each body. The light of all
            particles is added, and is white where it is bright. None: colors show the density.
        on: the tracers or bodies of particles drawn in this style; None: all with more than 200 points.

    Raises:
        SceneError: a value is not valid, or positions were not recorded.

    Source: K. Narkowicz, "ACES filmic tone mapping curve", 2016, for the tone curve.
    """

    draws_items: ClassVar[tuple[type, ...]] = (Body, System)

    colormap: ColormapName | None = None
    exposure: float = 1.0
    spread: float | None = None
    color: ColorChoice | PerBody | PerParticle | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        ramp(self.colormap, "inferno", WHOLE, "Density.colormap")
        self._set(exposure=number(self.exposure, "Density.exposure", above=0.0, most=1e6))
        if self.spread is not None:
            self._set(spread=number(self.spread, "Density.spread", above=0.0, most=WIDEST))
        if self.color is not None:
            self._set(color=checked(self.color, "Density.color", ("body",)))

    def can_draw(self, item: Body | System) -> bool:
        """Whether an item has many points, and no springs or fluid between them."""
        if item.section != "bodies":
            return item.elements.get("points", 0) > FEW
        body = cast("Body", item)
        return not (body.is_rigid or body.is_fluid or body.network is not None) and len(body) > FEW

    def painters(self, source: Source, items: Sequence[Body | System], theme: Theme) -> list[Painter]:
        """One painter for each system, and one for all bodies."""
        found: list[Painter] = []
        every = [*source.scene.bodies, *source.scene.systems]
        bodies = [cast("Body", item) for item in items if item.section == "bodies"]
        for system in [cast("System", item) for item in items if item.section != "bodies"]:
            if self.color is not None:
                raise SceneError(f"Density.color: must be None for {system!r}, whose colors show the density")
            index = next(at for at, each in enumerate(every) if each is system)
            part = SystemPart(system, str(source.scene.system(system)), index)
            found.append(DensityPainter(self, source, part, theme))
        for body in bodies:
            if body.is_rigid:
                raise SceneError(f"Density.on: {body!r} consists of rigid bodies; draw it by Solids")
        if bodies:
            parts = [part_of(source.scene, body) for body in bodies]
            painter = StarsPainter(self, source, parts, theme)
            painter.parts = parts
            found.append(painter)
        return found


class _Light:
    """How much light a style gives to points."""

    def __init__(self, style: Density, count: int, theme: Theme) -> None:
        self.exposure, self._spread, self._count = style.exposure, style.spread, count
        self.shadow = sum(theme.background) > BRIGHT
        table = ramp(style.colormap, "inferno", WHOLE, "Density.colormap")
        self.table = np.ascontiguousarray(np.round(table[::-1] if self.shadow else table).astype(np.uint8))

    def spread(self, pixels: float) -> float:
        """The standard deviation of a point's light in a panel of `pixels` pixels [pixels]."""
        if self._spread is not None:
            return self._spread
        least, most = SPREADS
        return float(np.clip(SPACING * math.sqrt(pixels / max(self._count, 1)), least, most))

    def paint(self, canvas: Canvas, points: FloatArray, view: View, pixels: float) -> None:
        """Draw the density of points immediately."""
        centers = np.ascontiguousarray(view.project(points)[0])
        canvas.density(centers, self.table, self.exposure, self.spread(pixels))

    def record(self, tape: Tape, points: FloatArray, view: View, pixels: float) -> None:
        """Put the density of points on a tape, in 3D with their places."""
        centers = np.ascontiguousarray(view.project(points)[0])
        tape.density(centers, self.table, self.exposure, self.spread(pixels), None if view.flat else points)


class PointsPainter(Painter):
    """Base class of painters of points."""

    def __init__(self, style: SystemStyle | Density, source: Source, part: SystemPart) -> None:
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
        self._light = _Light(style, len(self._system), theme)

    def inset(self, pixels: float) -> float:
        """The radius of a tracer's light."""
        return 2.0 * self._light.spread(pixels)

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Draw the density immediately."""
        self._light.paint(canvas, frame.fields[self._field], view, pixels)

    def record(self, tape: Tape, frame: SourceFrame, view: View, pixels: float) -> None:
        """Put the tracers on a tape."""
        self._light.record(tape, frame.fields[self._field], view, pixels)


class StarsPainter(Painter):
    """Painter of particles as light, behind all shapes."""

    def __init__(self, style: Density, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._where = style, places(parts)
        self._light = _Light(style, sum(len(part.body) for part in parts), theme)
        self._coloring: Coloring | None = None
        if style.color is not None:
            table = ramp(style.colormap, "inferno", WHOLE, "Density.colormap")
            self._coloring = Coloring(cast("Chosen", style.color), table, "Density.color", source, parts, theme)
            self.low, self.top = self._coloring.low, self._coloring.top

    @property
    def settled(self) -> bool:
        """Whether the ends of the color scale were given, or there is no scale."""
        return self._coloring is None or self._coloring.settled

    @property
    def scale(self) -> Scale | None:
        """The color scale."""
        return None if self._coloring is None else self._coloring.scale(self.low, self.top)

    def observe(self, frame: SourceFrame) -> None:
        """Update the ends of the color scale by a frame."""
        if self._coloring is not None:
            self._coloring.observe(frame)
            self.low, self.top = self._coloring.low, self._coloring.top

    def inset(self, pixels: float) -> float:
        """The radius of a particle's light."""
        return 2.0 * self._light.spread(pixels)

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Draw the light immediately."""
        points, light = frame.positions[self._where], self._light
        if self._coloring is None:
            light.paint(canvas, points, view, pixels)
            return
        centers, colors = view.project(points)[0], np.round(self._coloring.colors(frame, self.low, self.top))
        canvas.starlight(
            np.ascontiguousarray(centers),
            np.ascontiguousarray(colors.astype(np.uint8)),
            light.exposure,
            light.spread(pixels),
            light.shadow,
        )

    def record(self, tape: Tape, frame: SourceFrame, view: View, pixels: float) -> None:
        """Put the particles on a tape, in 3D with their places: as a density, or as halos of their own colors."""
        points, light = frame.positions[self._where], self._light
        if self._coloring is None:
            light.record(tape, points, view, pixels)
            return
        centers, depths, _ = view.project(points)
        centers = np.ascontiguousarray(centers)
        colors = np.round(self._coloring.colors(frame, self.low, self.top)).astype(np.uint8)
        inks = np.column_stack([colors, np.full(len(colors), HALO, np.uint8)])
        radii = np.full(len(points), 2.0 * light.spread(pixels), np.float32)
        tape.halos(centers, radii, inks, None if view.flat else depths, light.shadow)
