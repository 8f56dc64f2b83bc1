"""Fluids as lumps of the size of their spacing, colored by speed, pressure or density."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from physcore._core import Canvas, norms, tint
from physcore.checks import FloatArray, flag, word
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.colormaps import ColormapName, sequential
from physcore.film.colors.themes import Theme, mixed
from physcore.film.styles.base import FOG, SHADING, BodyStyle, Painter, Part, Scale, places, typical
from physcore.scene import fluid
from physcore.scene.bodies import Body
from physcore.simulation.sources import Source, SourceFrame

ColorBy = Literal["speed", "pressure", "density"]

CHANNEL = {"speed": "velocities", "pressure": "pressures", "density": "densities"}
"""The channel that each color shows."""
UNITS = {"speed": "m/s", "pressure": "Pa"}
FULL = 1.6
"""A lump's diameter over its spacing: discs on a square lattice just cover the plane, √2, so that water is closed."""
TYPICAL = 95.0
"""The top of the color scale is this percentile of a frame: what is faster is spray, and as white as can be."""
SMALLEST = 0.7
"""The least radius of a lump [pixels]."""
FLAT_REACH, DEEP_REACH = 1.7, 1.15
"""How far a particle of a smooth surface reaches, in 2D and in 3D, over the spacing."""
SKY = (235, 240, 245)
"""The color that, mixed with the background, is mirrored by a surface."""
NEVER = 1e-12
"""Pressures [Pa] and compressions below this are rounding."""


@dataclass(frozen=True)
class Fluid(BodyStyle):
    """Each particle of a fluid is a disc as wide as its spacing, and in 3D a lit ball; or they flow together.

    Args:
        color: by "speed" [m/s] or "pressure" [Pa], from zero to what is typical of the frame with the most, or by
            "density", with the density at rest in the middle of the scale; a recording needs the channel
            "velocities", "pressures" or "densities".
        colormap: "water", "ember", "viridis", "inferno", "plasma" or "magma".
        top: the value at the end of the color scale, in the unit of what the color shows (for the density, relative
            to that at rest), above zero; None: what is typical of the frame with the most.
        surface: whether particles flow together into a smooth surface, in 3D a lit one that is clear where it is thin,
            instead of being drawn each by itself.
        on: as in Style; it must be a fluid.

    Raises:
        SceneError: a value is not valid, or what the color shows was not recorded.
    """

    color: ColorBy = "speed"
    colormap: ColormapName = "water"
    top: float | None = None
    surface: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        word(self.color, "Fluid.color", CHANNEL)
        sequential(self.colormap, (0.0, 1.0), "Fluid.colormap")
        self._set(surface=flag(self.surface, "Fluid.surface"))
        self._set_positive("top")

    def can_draw(self, body: Body) -> bool:
        """Whether it is a fluid."""
        return isinstance(body, fluid.Fluid)

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """A painter with the color scale of one film."""
        for part in parts:
            if not self.can_draw(part.body):
                raise SceneError(f"Fluid.on: {part.body!r} is no fluid; use Points(on=…) for it")
        needed = CHANNEL[self.color]
        if not source.has(needed):
            raise SceneError(
                f"Fluid.color: {self.color!r} needs {needed}, which were not recorded; record them with "
                f"channels=(…, {needed!r}), or draw Points(color='body')"
            )
        return FluidPainter(self, parts, theme)


class FluidPainter(Painter):
    """Draws lumps."""

    def __init__(self, style: Fluid, parts: list[Part], theme: Theme) -> None:
        self.style, self._style, self._theme = style, style, theme
        self._where = places(parts)
        self._table = sequential(style.colormap, theme.part, "Fluid.colormap")
        self._sky = mixed(theme.background, SKY, 0.5)
        bodies = [part.body for part in parts if isinstance(part.body, fluid.Fluid)]
        sizes = [len(body) for body in bodies]
        self._radius = np.repeat([FULL / 2 * body.spacing for body in bodies], sizes).astype(np.float32)
        self._rest = np.repeat([body.density for body in bodies], sizes)
        self.top = style.top or NEVER

    @property
    def scale(self) -> Scale:
        """The scale of colors."""
        if self._style.color == "density":
            return Scale("density / at rest", "", (1.0 - self.top, 1.0 + self.top), self._table)
        return Scale(self._style.color, UNITS[self._style.color], (0.0, self.top), self._table)

    @property
    def settled(self) -> bool:
        """Whether the end of the color scale was given."""
        return self._style.top is not None

    @property
    def margin(self) -> float:
        """The radius of the largest lump [m]."""
        return float(self._radius.max(initial=0.0))

    def observe(self, frame: SourceFrame) -> None:
        """Find the end of the color scale."""
        if self._style.top is None:
            self.top = max(self.top, typical(np.abs(self._values(frame)), TYPICAL))

    def inset(self, pixels: float) -> float:
        """A rim: the radius is part of what the camera is fitted to."""
        del pixels
        return SMALLEST + 1.0

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Add lumps."""
        del pixels
        centers, depth, scale = view.project(frame.positions[self._where])
        least = -self.top if self._style.color == "density" else 0.0
        ends = (least, self.top)
        ink = tint(self._values(frame), ends, self._table, self._theme.background, depth, (view.reach, FOG))
        radii = np.maximum(scale * self._radius, np.float32(SMALLEST))
        if self._style.surface:
            reach = (FLAT_REACH if view.flat else DEEP_REACH) * 2.0 / FULL * radii
            canvas.liquid(centers, np.maximum(reach, 2.0), ink, self._sky, depth, view.scale)
            return
        canvas.discs(centers, radii, ink, depth, 0.0 if view.flat else SHADING)

    def _values(self, frame: SourceFrame) -> FloatArray:
        """The quantity that the color shows, (N,)."""
        values: FloatArray = frame.fields[CHANNEL[self._style.color]][self._where]
        match self._style.color:
            case "speed":
                return norms(values)
            case "density":
                compressions: FloatArray = values / self._rest - 1.0
                return compressions
        return values
