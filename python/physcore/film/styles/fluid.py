"""Fluids as smooth surfaces or as discs of the size of their spacing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, cast

import numpy as np

from physcore._core import Canvas, norms, tint
from physcore.checks import FloatArray, flag, number
from physcore.errors import SceneError
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.chosen import Chosen, ColorChoice, PerBody, PerParticle
from physcore.film.colors.colormaps import WHOLE, ColormapName, ramp
from physcore.film.colors.light import sky_above
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import SHADING, BodyStyle, InkArray, Painter, Part, Scale, inks, places
from physcore.film.styles.coloring import Coloring, checked
from physcore.film.styles.typical import Typical
from physcore.scene import fluid
from physcore.scene.bodies import Body
from physcore.simulation.sources import Source, SourceFrame

ColorBy = Literal["speed", "pressure", "density"]
COLOR_BY = ("speed", "pressure", "density")

CHANNEL = {"speed": "velocities", "pressure": "pressures", "density": "densities"}
"""The channel of each quantity."""
UNITS = {"speed": "m/s", "pressure": "Pa"}
FULL = 1.6
"""Diameter of a disc over the spacing. Discs on a square lattice cover the plane from √2 on."""
CALM = 95.0
"""Percentile of a frame's values for the top of the color scale. Faster particles are spray, which is white."""
SMALLEST = 0.7
"""Least radius of a disc [pixels]."""
FLAT_REACH, DEEP_REACH = 1.7, 1.15
"""Reach of a particle of a smooth surface in 2D and in 3D, over the spacing."""
OPACITY = (0.35, 0.9)
"""Default opacity of a fluid colored by a quantity, and of one with chosen colors."""
MIRROR = 0.4
"""Strength of the sky that a surface of particles reflects; its ripples are partly those of the particles."""
FOAM = 0.6
"""Fraction of the color scale above which fast water is foam."""
NEVER = 1e-12
"""Least end of the color scale: smaller pressures [Pa] and compressions are rounding errors."""


@dataclass(frozen=True)
class Fluid(BodyStyle):
    """Fluid as a smooth surface through its particles. In 3D the surface is lit, reflects the sky, and is
    clear where the fluid is thin.

        pc.film(recording, "milk.gif", style=pc.styles.Fluid("white"))
        pc.film(recording, "layers.gif", style=pc.styles.Fluid({"oil": "gold", "water": "#2a7fdb"}, opacity=0.5))

    Args:
        color: "speed" [m/s] or "pressure" [Pa], from zero to a typical value of the film; or "density", with the rest
            density in the middle of the scale. A recording needs the channel "velocities", "pressures" or "densities".
            Or chosen colors, as in Points: one such as "white", one for each body or particle, or values or a function
            for the color scale.
        colormap: as in Points; None: the part of "water" that contrasts with the background.
        top: the value at the end of the color scale, above zero, in the unit of the quantity; for the density, relative
            to the rest density. None: a typical value of the film.
        surface: whether to draw a common surface. If False, each particle is a disc as wide as its spacing, and in 3D a
            lit ball.
        opacity: opacity in 3D, from 0 (clear water) to 1 (milk); None: 0.35, and 0.9 for chosen colors. With "speed",
            fast particles are foam, which is more opaque. Single drops of a clear fluid are spray: small and white.
        glow: fraction of its color that the fluid emits, 0 to 1, as lava does; in 3D it lights its surroundings.
        on: as in Style; each body must be a fluid.

    Raises:
        SceneError: a value is not valid, or the quantity of the color was not recorded.
    """

    color: ColorBy | ColorChoice | PerBody | PerParticle = "speed"
    colormap: ColormapName | None = None
    top: float | None = None
    surface: bool = True
    opacity: float | None = None
    glow: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(
            color=checked(self.color, "Fluid.color", COLOR_BY),
            glow=number(self.glow, "Fluid.glow", least=0.0, most=1.0),
        )
        if self.opacity is not None:
            self._set(opacity=number(self.opacity, "Fluid.opacity", least=0.0, most=1.0))
        ramp(self.colormap, "water", WHOLE, "Fluid.colormap")
        self._set(surface=flag(self.surface, "Fluid.surface"))
        self._set_positive("top")

    def can_draw(self, body: Body) -> bool:
        """Whether a body is a fluid."""
        return body.is_fluid

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter with the color scale of one film."""
        for part in parts:
            if not self.can_draw(part.body):
                raise SceneError(f"Fluid.on: {part.body!r} is no fluid; use Points(on=…) for it")
        needed = CHANNEL[self.color] if isinstance(self.color, str) else None
        if needed is not None and not source.has(needed):
            raise SceneError(
                f"Fluid.color: {self.color!r} needs {needed}, which were not recorded; record them with "
                f"channels=(…, {needed!r}), or give it a color of its own, such as 'steelblue'"
            )
        return FluidPainter(self, source, parts, theme)


class FluidPainter(Painter):
    """Painter of surfaces or discs."""

    def __init__(self, style: Fluid, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._style, self._theme = style, style, theme
        self._where = places(parts)
        self._table = ramp(style.colormap, "water", theme.part, "Fluid.colormap")
        bodies = [cast("fluid.Fluid", part.body) for part in parts]
        sizes = [len(body) for body in bodies]
        self._radius = np.repeat([FULL / 2 * body.spacing for body in bodies], sizes).astype(np.float32)
        self._rest = np.repeat([body.density for body in bodies], sizes)
        self._coloring: Coloring | None = None
        self._typical = Typical(CALM)
        self.top = style.top or NEVER
        if not isinstance(style.color, str):
            chosen = cast("Chosen", style.color)
            self._coloring = Coloring(chosen, self._table, "Fluid.color", source, parts, theme)
            self.low, self.top = self._coloring.low, style.top or self._coloring.top
            self.fixed = self._coloring.fixed
        clear = OPACITY[self._coloring is not None] if style.opacity is None else style.opacity
        self._opacity = clear if style.surface else 1.0

    @property
    def scale(self) -> Scale | None:
        """The color scale."""
        if self._coloring is not None:
            return self._coloring.scale(self.low, self.top)
        if self._style.color == "density":
            return Scale("density / at rest", "", (1.0 - self.top, 1.0 + self.top), self._table)
        return Scale(str(self._style.color), UNITS[str(self._style.color)], (0.0, self.top), self._table)

    @property
    def settled(self) -> bool:
        """Whether the end of the color scale was given."""
        return self._style.top is not None if self._coloring is None else self._coloring.settled

    @property
    def margin(self) -> float:
        """The radius of the largest disc [m]."""
        return float(self._radius.max(initial=0.0))

    def observe(self, frame: SourceFrame) -> None:
        """Update the end of the color scale by a frame."""
        if self._coloring is not None:
            self._coloring.observe(frame)
            self.low, self.top = self._coloring.low, self._style.top or self._coloring.top
        elif self._style.top is None:
            self.top = max(NEVER, self._typical.add(np.abs(self._values(frame))))

    def inset(self, pixels: float) -> float:
        """The least radius and a rim; `margin` contains the radius itself."""
        del pixels
        return SMALLEST + 1.0

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue a surface or discs."""
        del pixels
        centers, depth, scale = view.project(frame.positions[self._where])
        ink = self._inks(frame, depth, view)
        radii = np.maximum(scale * self._radius, np.float32(SMALLEST))
        if self._style.surface:
            sky = sky_above(np.eye(3) if view.flat else view.axes, MIRROR)
            reach = (FLAT_REACH if view.flat else DEEP_REACH) * 2.0 / FULL * radii
            canvas.liquid(centers, np.maximum(reach, 2.0), ink, sky, depth, view.scale, self._style.glow)
            return
        canvas.discs(centers, radii, ink, depth, 0.0 if view.flat else SHADING)

    def _inks(self, frame: SourceFrame, depth: PixelArray | None, view: View) -> InkArray:
        """The color and opacity of each particle (N, 4)."""
        if self._coloring is not None:
            colors = self._coloring.colors(frame, self.low, self.top)
            ink = inks(colors, self._theme, None if depth is None else view.farness(depth))
            ink[:, 3] = round(255 * self._opacity)
            return ink
        values, least = self._values(frame), -self.top if self._style.color == "density" else 0.0
        ink = tint(values, (least, self.top), self._table, self._theme.background, depth, view.fog)
        foam = np.zeros(len(values))
        if self._style.color == "speed":
            foam = np.clip((values / self.top - FOAM) / (1.0 - FOAM), 0.0, 1.0)
        ink[:, 3] = np.round(255.0 * (self._opacity + (1.0 - self._opacity) * foam))
        return ink

    def _values(self, frame: SourceFrame) -> FloatArray:
        """The quantity (N,) of the color scale."""
        values: FloatArray = frame.fields[CHANNEL[str(self._style.color)]][self._where]
        match self._style.color:
            case "speed":
                return norms(values)
            case "density":
                compressions: FloatArray = values / self._rest - 1.0
                return compressions
        return values
