"""Wave functions on grids: hue by phase, brightness by density."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal, cast, get_args

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray, word
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.colormaps import STEPS
from physcore.film.colors.themes import Theme
from physcore.film.page.tape import Tape, opaque
from physcore.film.resampling import cubic
from physcore.film.shapes.box import corners
from physcore.film.styles.base import Painter, Scale, SystemPart, SystemStyle
from physcore.film.styles.grid_field import LEVELS, GridPainter, coarser
from physcore.scene.system import System
from physcore.simulation.sources import Source, SourceFrame

SOFT = 0.55
"""Exponent of the density in the brightness, so that weak waves are visible beside strong ones."""
FAINT = 0.22
"""Opacity of the highest potential."""
Palette = Literal["hues", "blue-yellow"]
PALETTES: tuple[Palette, ...] = get_args(Palette)


@dataclass(frozen=True)
class Phase(SystemStyle):
    """Wave function in 2D: the hue shows its phase, from −π to π, and the brightness its density.

    Zero density has the color of the background. A potential is drawn faintly, brighter where it is higher. The scale
    of the density is the same for the whole film.

        pc.film(recording, "packet.gif", style=pc.styles.Phase(palette="blue-yellow"))

    Args:
        palette: "hues": all hues at a constant lightness. "blue-yellow": from dark over blue, light and yellow back to
            dark. The color-blind can distinguish these colors, but the lightness depends on the phase too.
        range: the density at full brightness; None: a typical largest value of the film.
        on: the wave function or wave functions drawn in this style; None: all in 2D.

    Source: B. Ottosson, "A perceptual color space for image processing", 2020, for the circles in Oklab.

    Raises:
        SceneError: a value is not valid, or the wave function was not recorded.
    """

    palette: Palette = "hues"
    range: float | None = None

    dimensions: ClassVar[tuple[int, ...]] = (2,)

    def __post_init__(self) -> None:
        super().__post_init__()
        word(self.palette, "Phase.palette", PALETTES)
        self._set_positive("range")

    def can_draw(self, item: System) -> bool:
        """Whether an item is a wave function in 2D."""
        return "wave_function" in item.units and item.dimension in self.dimensions

    def painter(self, source: Source, part: SystemPart, theme: Theme) -> Painter:
        """The painter with the scale of one film."""
        if not self.can_draw(part.system):
            raise SceneError(f"Phase.on: {part.system!r} is no wave function in 2D; use Field() in 3D, Line() in 1D")
        return PhasePainter(self, source, part, theme)


class PhasePainter(GridPainter):
    """Painter of a wave function, with the closed edges of its grid."""

    def __init__(self, style: Phase, source: Source, part: SystemPart, theme: Theme) -> None:
        super().__init__(style, "wave_function", source, part, theme, "Phase")
        self._style, self._table = style, circle(style.palette)
        self.top = style.range or 0.0
        self._potential = self._system.landscape

    @property
    def signed(self) -> bool:
        """False: the density is not negative."""
        return False

    @property
    def scale(self) -> Scale | None:
        """The color scale of the phase."""
        return Scale("phase", "rad", (-math.pi, math.pi), self._table)

    @property
    def settled(self) -> bool:
        """Whether the range was given."""
        return self._style.range is not None

    @property
    def landmarks(self) -> FloatArray:
        """The corners of the grid."""
        return corners(np.array(self._grid.origin), np.array(self._grid.upper))

    def values(self, frame: SourceFrame) -> FloatArray:
        """The density |ψ|²."""
        density: FloatArray = np.square(frame.fields[self._field]).sum(axis=-1)
        return density

    def observe(self, frame: SourceFrame) -> None:
        """Update the end of the scale by a frame."""
        if not self.settled:
            self.observe_range(frame)

    def inset(self, pixels: float) -> float:
        """Half the width of the edges."""
        del pixels
        return 1.0

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Draw all pixels whose centers are on the grid, and the closed edges."""
        del pixels
        (left, bottom), (right, top) = view.project(np.array([self._grid.origin, self._grid.upper]))[0].astype(float)
        width, height = (2.0 * view.middle[axis] + 1.0 for axis in (0, 1))
        x = np.arange(max(math.ceil(left - 0.5), 0), min(math.ceil(right - 0.5), math.ceil(width)))
        y = np.arange(max(math.ceil(top - 0.5), 0), min(math.ceil(bottom - 0.5), math.ceil(height) + 64))
        if len(x) == 0 or len(y) == 0:
            return
        cells = 1.0 / (view.scale * self._grid.spacing)
        along = [(x + 0.5 - left) * cells - 0.5, (bottom - y - 0.5) * cells - 0.5]
        weights = [
            cubic(count, places, closed=closed)
            for count, places, closed in zip(self._grid.cells, along, self._grid.periodic, strict=True)
        ]
        canvas.picture(self._picture(frame.fields[self._field], weights), int(x[0]), int(y[0]))
        self._paint_edges(canvas, view)

    def record(self, tape: Tape, frame: SourceFrame, view: View, pixels: float) -> None:
        """Put the real and the imaginary part on a tape."""
        del pixels
        top, parts = math.sqrt(self.top or 1.0), frame.fields[self._field]
        levels = [
            np.round((0.5 + 0.5 * np.clip(coarser(parts[..., index]) / top, -1.0, 1.0)) * (LEVELS - 1)).astype(np.uint8)
            for index in (0, 1)
        ]
        potential = None if self._potential is None else np.clip(coarser(self._potential), 0.0, 1.0)
        tape.phase(
            levels, corners(np.array(self._grid.origin), np.array(self._grid.upper))[[0, 2, 3, 1]],
            table=opaque(np.round(self._table).astype(np.uint8)), colors=len(self._table), soft=SOFT, faint=FAINT,
            walls=None if potential is None else np.round(255.0 * potential).astype(np.uint8).T,
            wall=[*self._theme.text],
        )  # fmt: skip
        self._paint_edges(cast("Canvas", tape), view)

    def _picture(self, parts: FloatArray, weights: list[FloatArray]) -> np.ndarray:
        """The pixels (H, W, 3), from the real and the imaginary part and the interpolation weights along each axis."""
        to_x, to_y = weights
        real, imaginary = (to_y @ (to_x @ parts[..., index]).T for index in (0, 1))
        share = np.clip((real**2 + imaginary**2) / (self.top or 1.0), 0.0, 1.0) ** SOFT
        hue = np.floor((np.arctan2(imaginary, real) / (2.0 * math.pi) + 0.5) * STEPS).astype(int) % STEPS
        ground = np.broadcast_to(np.array(self._theme.background, dtype=float), (*share.shape, 3))
        if self._potential is not None:
            faint = FAINT * np.clip(to_y @ (to_x @ self._potential).T, 0.0, 1.0)[..., np.newaxis]
            ground = (1.0 - faint) * ground + faint * np.array(self._theme.text, dtype=float)
        share = share[..., np.newaxis]
        return np.ascontiguousarray(np.round((1.0 - share) * ground + share * self._table[hue]).astype(np.uint8))


def circle(palette: Palette) -> FloatArray:
    """The colors of phases from −π to π, shape (STEPS, 3), on a circle in Oklab."""
    angle = 2.0 * np.pi * (np.arange(STEPS) + 0.5) / STEPS - np.pi
    flat = np.zeros_like(angle)
    if palette == "hues":
        lab = np.stack([flat + 0.74, 0.125 * np.cos(angle), 0.125 * np.sin(angle)])
    else:
        lab = np.stack([0.66 + 0.24 * np.cos(angle), flat - 0.01, 0.13 * np.sin(angle)])
    to_cones = np.array([[1.0, 0.3963377774, 0.2158037573], [1.0, -0.1055613458, -0.0638541728],
                         [1.0, -0.0894841775, -1.2914855480]])  # fmt: skip
    to_rgb = np.array([[4.0767416621, -3.3077115913, 0.2309699292], [-1.2684380046, 2.6097574011, -0.3413193965],
                       [-0.0041960863, -0.7034186147, 1.7076147010]])  # fmt: skip
    linear = np.clip(to_rgb @ (to_cones @ lab) ** 3, 0.0, 1.0)
    colors: FloatArray = 255.0 * np.where(linear > 0.0031308, 1.055 * linear ** (1 / 2.4) - 0.055, 12.92 * linear).T
    return colors
