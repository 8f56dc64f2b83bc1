"""Particles as discs, colored by how they move or what they belong to."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Literal

import numpy as np

from physcore._core import Canvas, norms, tint
from physcore.checks import FloatArray, number, word
from physcore.errors import SceneError
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.colormaps import ColormapName, sequential
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import (
    BRIGHT,
    FOG,
    SHADING,
    BodyStyle,
    InkArray,
    Painter,
    Part,
    Scale,
    body_color,
    inks,
    places,
    straight,
    typical,
)
from physcore.simulation.sources import Source, SourceFrame

ColorBy = Literal["speed", "energy", "body"]

UNITS = {"speed": "m/s", "energy": "J"}
SPACING = 0.3
"""A disc's radius as a fraction of the mean distance that the particles would have if they filled the panel."""
RADII = (0.5, 5.5)
"""The smallest and the largest radius that is chosen by itself [pixels]."""
TRAIL = 0.7
"""How much of its color the freshest part of a trail has, beside the background's."""
HALO = 4.0
"""Radius of a halo over that of its disc."""
GLOW = 0.55
"""How bright the brightest halo is at its center, beside its disc."""
FEW = 16
"""Up to so many particles get a trail by themselves."""


@dataclass(frozen=True)
class Points(BodyStyle):
    """Each particle is a disc, and in 3D a lit ball.

    Args:
        color: by "speed" [m/s], kinetic "energy" [J] or "body"; None: speed if it was recorded, otherwise body. Scales
            begin at zero.
        colormap: "plasma", "viridis", "inferno", "magma", "water" or "ember".
        size: diameter [pixels]; None: as large as the particle if it has a radius, otherwise as fits their number.
        trail: for how long the path behind each particle is shown [s]; None: where there are only a few particles, an
            eighth of the film, otherwise not.
        glow: how brightly what is at the top of the color scale shines, 0 to 1; by body, everything shines. On a light
            ground it is a shadow of its color.
        blur: the part of the time between two frames for which the shutter is open, 0 to 1: discs are drawn out along
            their velocities. 0.5 is what film cameras have.
        top: the value at the end of the color scale [m/s or J], above zero; None: what is typical of the fastest frame.
        on: as in Style.

    Raises:
        SceneError: a value is out of range, or velocities are needed and were not recorded.
    """

    color: ColorBy | None = None
    colormap: ColormapName = "plasma"
    size: float | None = None
    trail: float | None = None
    glow: float = 0.0
    blur: float = 0.0
    top: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.color is not None:
            word(self.color, "Points.color", ("speed", "energy", "body"))
        sequential(self.colormap, (0.0, 1.0), "Points.colormap")
        self._set(
            trail=None if self.trail is None else number(self.trail, "Points.trail", least=0.0),
            glow=number(self.glow, "Points.glow", least=0.0, most=1.0),
            blur=number(self.blur, "Points.blur", least=0.0, most=1.0),
        )
        self._set_positive("size", "top")

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """A painter with the color scale of one film."""
        color = self.color or ("speed" if source.has("velocities") else "body")
        if self.blur > 0.0 and not source.has("velocities"):
            raise SceneError("Points.blur: needs velocities, which were not recorded; record them, or leave it out")
        if color != "body" and not source.has("velocities"):
            raise SceneError(f"Points.color: {color!r} needs velocities, which were not recorded; use 'body'")
        return PointsPainter(self, color, source, parts, theme)


class PointsPainter(Painter):
    """Draws discs, the trails behind them and the light around them."""

    def __init__(self, style: Points, color: ColorBy, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._style, self._color, self._theme = style, style, color, theme
        self._where = places(parts)
        self._mass = np.concatenate([part.body.mass for part in parts])
        self._radius = np.concatenate([part.body.radius for part in parts])
        self._sized = bool((self._radius > 0.0).any())
        self._table = sequential(style.colormap, theme.part, "Points.colormap")
        self._fps = source.fps
        each = np.stack([body_color(source, part, theme) for part in parts])
        self._bodies = np.repeat(each, [len(part.body) for part in parts], axis=0)
        self._domain = source.scene.periodic
        self.top = style.top or 0.0
        frames = source.count / 8 if len(self._mass) <= FEW else 0.0
        if style.trail is not None:
            frames = min(style.trail * source.fps, source.count)
        self._past: deque[FloatArray] = deque(maxlen=1 + round(frames))

    @property
    def scale(self) -> Scale | None:
        """The scale of colors."""
        return None if self._color == "body" else Scale(self._color, UNITS[self._color], (0.0, self.top), self._table)

    @property
    def settled(self) -> bool:
        """Whether the end of the color scale was given, or there is none."""
        return self._color == "body" or self._style.top is not None

    def begin(self) -> None:
        """Forget the paths."""
        self._past.clear()

    def observe(self, frame: SourceFrame) -> None:
        """Find the top of the color scale."""
        if not self.settled:
            self.top = max(self.top, typical(self._values(frame)))

    def inset(self, pixels: float) -> float:
        """A radius."""
        return self._chosen(pixels) + 1.0

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Add trails, then halos, then discs."""
        positions = frame.positions[self._where]
        centers, depth, scale = view.project(positions)
        fraction = None if self._color == "body" else self._values(frame) / (self.top or 1.0)
        ink = self._inks(fraction, depth, view)
        radii = self._radii(scale, view, pixels)
        if self._past.maxlen != 1:
            self._past.append(positions)
            self._paint_trails(canvas, view, self._inks(fraction, None, view), 0.7 * self._chosen(pixels))
        if self._style.glow > 0.0:
            self._paint_halos(canvas, centers, radii, ink, depth, fraction)
        if self._style.blur > 0.0:
            self._paint_streaks(canvas, frame, view, radii, ink)
            return
        shading = 0.0 if view.flat or radii.max(initial=0.0) < 2.0 else SHADING
        canvas.discs(centers, radii, ink, depth, shading)

    def _paint_trails(self, canvas: Canvas, view: View, ink: InkArray, width: float) -> None:
        """Lines along the last positions that fade with age."""
        past = np.stack(self._past)
        frames, count, dimension = past.shape
        pixels, depth, _ = view.project(past.reshape(-1, dimension))
        gaps = None if self._domain is None else ~straight(self._domain, np.diff(past, axis=0))
        canvas.trails(
            pixels.reshape(frames, count, 2),
            np.full(count, width, dtype=np.float32),
            ink,
            (self._theme.background, TRAIL),
            gaps,
            None if depth is None else depth.reshape(frames, count),
        )

    def _paint_halos(
        self,
        canvas: Canvas,
        centers: PixelArray,
        radii: PixelArray,
        ink: InkArray,
        depth: PixelArray | None,
        fraction: FloatArray | None,
    ) -> None:
        """Light around what is at the top of the scale; it goes with the square of the value, as energy does."""
        strength = np.ones(len(ink)) if fraction is None else np.clip(fraction, 0.0, 1.0) ** 2
        light = ink.copy()
        light[:, 3] = np.round(255.0 * self._style.glow * GLOW * strength)
        shining = light[:, 3] > 0
        canvas.halos(
            centers[shining],
            HALO * radii[shining],
            light[shining],
            None if depth is None else depth[shining],
            sum(self._theme.background) > BRIGHT,
        )

    def _paint_streaks(self, canvas: Canvas, frame: SourceFrame, view: View, radii: PixelArray, ink: InkArray) -> None:
        """Discs drawn out along their velocities, with the opacity that leaves their light the same."""
        half = 0.5 * self._style.blur / self._fps * frame.fields["velocities"][self._where]
        positions = frame.positions[self._where]
        (tails, before, _), (tips, after, _) = view.project(positions - half), view.project(positions + half)
        length = np.sqrt(np.einsum("nd,nd->n", tips - tails, tips - tails))
        faint = ink.copy()
        faint[:, 3] = np.round(255.0 * np.pi * radii / (np.pi * radii + 2.0 * length))
        depth = None if before is None or after is None else 0.5 * (before + after)
        canvas.lines(np.concatenate([tails, tips], axis=1), 2.0 * radii, faint, depth)

    def _values(self, frame: SourceFrame) -> FloatArray:
        """The quantity that the color shows, (N,)."""
        velocities = frame.fields["velocities"][self._where]
        speeds = norms(velocities)
        return speeds if self._color == "speed" else 0.5 * self._mass * speeds**2

    def _inks(self, fraction: FloatArray | None, depth: PixelArray | None, view: View) -> InkArray:
        """The color of each particle (N, 4), of its body or by the fraction of the scale that it has reached."""
        if fraction is None:
            return inks(self._bodies, self._theme, None if depth is None else view.farness(depth))
        return tint(fraction, (0.0, 1.0), self._table, self._theme.background, depth, (view.reach, FOG))

    def _chosen(self, pixels: float) -> float:
        """The radius of a particle that has none [pixels]."""
        if self._style.size is not None:
            return self._style.size / 2
        least, most = RADII
        return float(np.clip(SPACING * math.sqrt(pixels / max(len(self._mass), 1)), least, most))

    def _radii(self, scale: PixelArray, view: View, pixels: float) -> PixelArray:
        chosen = np.float32(self._chosen(pixels))
        perspective = scale / np.float32(view.scale)
        if self._style.size is not None:
            return chosen * perspective
        if not self._sized:
            shown: PixelArray = np.maximum(chosen * perspective, np.float32(RADII[0]))
            return shown
        own = scale * self._radius.astype(np.float32)
        return np.where(self._radius > 0.0, np.maximum(own, RADII[0]), chosen * perspective).astype(np.float32)
