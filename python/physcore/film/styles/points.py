"""Particles as discs or balls."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np
from numpy.typing import ArrayLike

from physcore._core import Canvas, norms, tint
from physcore.checks import FloatArray, array, flag, is_word, number, regular, shown
from physcore.errors import SceneError
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.chosen import Chosen, ColorChoice, PerBody, PerParticle
from physcore.film.colors.colormaps import WHOLE, ColormapName, ramp
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import (
    BRIGHT,
    SHADING,
    BodyStyle,
    InkArray,
    Painter,
    Part,
    Scale,
    inks,
    places,
)
from physcore.film.styles.coloring import Coloring, checked, require_known
from physcore.film.styles.past import Past
from physcore.film.styles.typical import Typical
from physcore.simulation.sources import Source, SourceFrame

ColorBy = Literal["speed", "energy", "body"]
COLOR_BY = ("speed", "energy", "body")
MEASURED = ("speed", "energy")

UNITS = {"speed": "m/s", "energy": "J"}
SPACING = 0.3
"""Radius of a disc, as a fraction of the mean spacing of particles that fill the panel evenly."""
LARGEST = 8.0
"""Largest diameter by mass, relative to a particle of median mass."""
RADII = (0.5, 5.5)
"""Smallest and largest radius that is chosen automatically [pixels]."""
TRAIL = 0.7
"""Opacity of the newest part of a trail."""
HALO = 4.0
"""Radius of a halo, relative to its disc."""
GLOW = 0.55
"""Brightness of the brightest halo at its center, relative to its disc."""
FEW = 16
"""Number of particles up to which trails are drawn by default."""


@dataclass(frozen=True)
class Points(BodyStyle):
    """Particles as discs, in 3D as lit balls.

        pc.film(recording, "balls.gif", style=pc.styles.Points("tomato"))
        pc.film(recording, "balls.gif", style=pc.styles.Points({"earth": "#2a6fdb", "moon": "silver"}, size="mass"))
        pc.film(recording, "balls.gif", style=pc.styles.Points(lambda time, positions, velocities: positions[:, 1]))

    Args:
        color: "speed" [m/s], kinetic "energy" [J] or "body"; None: speed if it was recorded, otherwise body. The scales
            of speed and energy begin at zero. Or chosen colors: a name of CSS, such as "tomato", or "#10c0ff"; a
                mapping
            from bodies or their names to such colors (other bodies keep their default colors); a list of colors or an
            array (N, 3) for the drawn particles; values (N,) for the color scale; or a function of the time [s], the
            positions and the velocities (N, D) of these particles that gives such values or colors in each frame.
        colormap: the map of the color scale: "plasma", "viridis", "inferno", "magma", "water", "ember" or one of
            Matplotlib, from end to end. None: the part of "plasma" that contrasts with the background.
        size: diameter [pixels], one or for each particle (N,). "mass": areas, in 3D volumes, are proportional to the
            masses. "radius": the radius of the particle, which must have one. None: the radius of the particle if it
                has
            one, otherwise a size that suits the number of particles.
        trail: duration of the trail behind each particle [s]; None: an eighth of the film for at most 16 particles,
            otherwise no trails.
        glow: brightness of the halo around particles at the top of the color scale, 0 to 1. Particles without a scale
            all have the full halo. On a light background, a halo is a shadow of the same color.
        blur: fraction of the interval between two frames for which the shutter is open, 0 to 1. Discs are stretched
            along their velocities. Film cameras have 0.5.
        top: the value at the end of the color scale [m/s or J], above zero; None: a typical value of the film.
        shading: whether balls in 3D are lit and fade with distance. If False, the colors are exact.
        on: as in Style.

    Raises:
        SceneError: a value is out of range or of a wrong shape, or velocities are needed and were not recorded.
    """

    color: ColorBy | ColorChoice | PerBody | PerParticle | None = None
    colormap: ColormapName | None = None
    size: float | Literal["mass", "radius"] | ArrayLike | PerParticle | None = None
    trail: float | None = None
    glow: float = 0.0
    blur: float = 0.0
    top: float | None = None
    shading: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.color is not None:
            self._set(color=checked(self.color, "Points.color", COLOR_BY))
        ramp(self.colormap, "plasma", WHOLE, "Points.colormap")
        self._set(
            trail=None if self.trail is None else number(self.trail, "Points.trail", least=0.0),
            glow=number(self.glow, "Points.glow", least=0.0, most=1.0),
            blur=number(self.blur, "Points.blur", least=0.0, most=1.0),
        )
        self._set(size=_size(self.size), shading=flag(self.shading, "Points.shading"))
        self._set_positive("top")

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter with the color scale of one film."""
        color = ("speed" if source.has("velocities") else "body") if self.color is None else self.color
        if self.blur > 0.0 and not source.has("velocities"):
            raise SceneError("Points.blur: needs velocities, which were not recorded; record them, or leave it out")
        if color in ("speed", "energy") and not source.has("velocities"):
            raise SceneError(f"Points.color: {color!r} needs velocities, which were not recorded; use 'body'")
        require_known(color, parts, "Points.color")
        require_known(self.size, parts, "Points.size")
        if is_word(self.size, "radius") and not any((part.body.radius > 0.0).any() for part in parts):
            raise SceneError("Points.size: 'radius' needs particles with a radius; give Particles radius=…")
        return PointsPainter(self, cast("ColorBy | Chosen", color), source, parts, theme)


class PointsPainter(Painter):
    """Painter of discs, trails and halos."""

    def __init__(self, style: Points, color: ColorBy | Chosen, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._style, self._color, self._theme = style, style, color, theme
        self._where = places(parts)
        self._mass = np.concatenate([part.body.mass for part in parts])
        self._radius = np.concatenate([part.body.radius for part in parts])
        self._sized = bool((self._radius > 0.0).any()) and style.size in (None, "radius")
        self._own = self._diameters(source.scene.dimension)
        self._table = ramp(style.colormap, "plasma", theme.part, "Points.colormap")
        self._fps = source.fps
        self._coloring = (
            None if color in MEASURED else Coloring(color, self._table, "Points.color", source, parts, theme)
        )
        self.fixed = None if self._coloring is None else self._coloring.fixed
        self.low, self.top = (0.0, 0.0) if self._coloring is None else (self._coloring.low, self._coloring.top)
        self.top, self._typical = style.top or self.top, Typical()
        frames = source.count / 8 if len(self._mass) <= FEW else 0.0
        if style.trail is not None:
            frames = min(style.trail * source.fps, source.count)
        self._past = Past(1.0 / source.fps, 1 + round(frames), source.scene.periodic)

    def _diameters(self, dimension: int) -> FloatArray | None:
        """Diameters (N,), absolute [pixels] or relative to the default diameter; None if all are equal."""
        if isinstance(self._style.size, PerParticle):
            return self._style.size.values
        if not is_word(self._style.size, "mass"):
            return None
        relative = self._mass / max(float(np.median(self._mass)), np.finfo(float).tiny)
        return np.minimum(relative ** (1.0 / max(dimension, 2)), LARGEST)

    @property
    def scale(self) -> Scale | None:
        """The color scale."""
        if self._coloring is not None:
            return self._coloring.scale(self.low, self.top)
        return Scale(str(self._color), UNITS[str(self._color)], (0.0, self.top), self._table)

    @property
    def settled(self) -> bool:
        """Whether the ends of the color scale were given, or there is no scale."""
        return self._style.top is not None if self._coloring is None else self._coloring.settled

    def begin(self) -> None:
        """Forget the trails."""
        self._past.begin()

    def observe(self, frame: SourceFrame) -> None:
        """Update the ends of the color scale by a frame."""
        if self.settled:
            return
        if self._coloring is None:
            self.top = self._typical.add(self._values(frame))
        else:
            self._coloring.observe(frame)
            self.low, self.top = self._coloring.low, self._style.top or self._coloring.top

    def inset(self, pixels: float) -> float:
        """The largest radius."""
        most = 1.0 if self._own is None else float(self._own.max(initial=0.0))
        if isinstance(self._style.size, PerParticle):
            return most / 2 + 1.0
        return most * self._chosen(pixels) + 1.0

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue trails, halos and discs, in this order."""
        positions = frame.positions[self._where]
        centers, depth, scale = view.project(positions)
        fraction = None if self.fixed is not None else self._values(frame)
        if fraction is not None and fraction.ndim == 1:
            fraction = (fraction - self.low) / ((self.top - self.low) or 1.0)
        ink = self._inks(fraction, depth if self._style.shading else None, view)
        radii = self._radii(scale, view, pixels)
        if self._past.frames != 1:
            self._past.add(
                frame.time, positions, frame.fields["velocities"][self._where] if "velocities" in frame.fields else None
            )
            self._paint_trails(canvas, view, self._inks(fraction, None, view), 0.7 * self._chosen(pixels))
        if self._style.glow > 0.0:
            self._paint_halos(canvas, centers, radii, ink, depth, fraction)
        if self._style.blur > 0.0:
            self._paint_streaks(canvas, frame, view, radii, ink)
            return
        shading = 0.0 if view.flat or not self._style.shading or radii.max(initial=0.0) < 2.0 else SHADING
        canvas.discs(centers, radii, ink, depth, shading)

    def _paint_trails(self, canvas: Canvas, view: View, ink: InkArray, width: float) -> None:
        """Queue trails, which fade with age."""
        pixels, depth = self._past.seen(view)
        widths = np.full(len(ink), width, dtype=np.float32)
        canvas.trails(pixels, widths, ink, (self._theme.background, TRAIL), self._past.gaps, depth)

    def _paint_halos(
        self,
        canvas: Canvas,
        centers: PixelArray,
        radii: PixelArray,
        ink: InkArray,
        depth: PixelArray | None,
        fraction: FloatArray | None,
    ) -> None:
        """Queue halos, with the brightness proportional to the square of the value on the scale, as energy is."""
        strength = np.ones(len(ink)) if fraction is None or fraction.ndim == 2 else np.clip(fraction, 0.0, 1.0) ** 2
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
        """Queue discs stretched along their velocities, with an opacity that leaves the total light constant."""
        half = 0.5 * self._style.blur / self._fps * frame.fields["velocities"][self._where]
        positions = frame.positions[self._where]
        (tails, before, _), (tips, after, _) = view.project(positions - half), view.project(positions + half)
        length = np.sqrt(np.einsum("nd,nd->n", tips - tails, tips - tails))
        faint = ink.copy()
        faint[:, 3] = np.round(255.0 * np.pi * radii / (np.pi * radii + 2.0 * length))
        depth = None if before is None or after is None else np.stack([before, after], axis=1)
        canvas.lines(np.concatenate([tails, tips], axis=1), 2.0 * radii, faint, depth)

    def _values(self, frame: SourceFrame) -> FloatArray:
        """The quantity (N,) of the color scale; or colors (N, 3), if the function returns these."""
        if self._coloring is not None:
            return self._coloring.values(frame)
        speeds = norms(frame.fields["velocities"][self._where])
        return speeds if self._color == "speed" else 0.5 * self._mass * speeds**2

    def _inks(self, fraction: FloatArray | None, depth: PixelArray | None, view: View) -> InkArray:
        """The inks (N, 4) of the particles, from constant colors or from fractions of the color scale."""
        colors = self.fixed if fraction is None else fraction if fraction.ndim == 2 else None
        if colors is not None:
            return inks(colors, self._theme, None if depth is None else view.farness(depth))
        assert fraction is not None
        return tint(fraction, (0.0, 1.0), self._table, self._theme.background, depth, view.fog)

    def _chosen(self, pixels: float) -> float:
        """The radius of particles without one [pixels]."""
        if isinstance(self._style.size, float):
            return self._style.size / 2
        least, most = RADII
        return float(np.clip(SPACING * math.sqrt(pixels / max(len(self._mass), 1)), least, most))

    def _radii(self, scale: PixelArray, view: View, pixels: float) -> PixelArray:
        perspective = scale / max(np.float32(view.scale), np.finfo(np.float32).tiny)
        if isinstance(self._style.size, PerParticle):
            return (perspective * self._style.size.values / 2).astype(np.float32)
        chosen = np.float32(self._chosen(pixels))
        if isinstance(self._style.size, float):
            return chosen * perspective
        if self._own is not None:
            return np.maximum(chosen * perspective * self._own, RADII[0]).astype(np.float32)
        if not self._sized:
            shown: PixelArray = np.maximum(chosen * perspective, np.float32(RADII[0]))
            return shown
        own = scale * self._radius.astype(np.float32)
        return np.where(self._radius > 0.0, np.maximum(own, RADII[0]), chosen * perspective).astype(np.float32)


def _size(value: object) -> float | str | PerParticle | None:
    """The validated form of a size."""
    if value is None or isinstance(value, PerParticle):
        return value
    if isinstance(value, str):
        if value in ("mass", "radius"):
            return value
        raise SceneError(f"Points.size: must be a number of pixels, 'mass' or 'radius', got {shown(value)}")
    if isinstance(value, (list, tuple, np.ndarray)) and regular(value, "Points.size").ndim == 1:
        sizes = array(value, "Points.size")
        if not (sizes > 0.0).all():
            raise SceneError(f"Points.size: must be above 0, got {sizes.min():g}")
        return PerParticle(sizes)
    return number(value, "Points.size", above=0.0)
