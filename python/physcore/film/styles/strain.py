"""Springs colored by strain or by chosen colors; rods colored by tension."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, cast

import numpy as np

from physcore._core import Canvas
from physcore.checks import BoolArray, FloatArray, IntArray, flag, is_word
from physcore.errors import SceneError
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.chosen import Chosen, ColorChoice, PerBody, PerParticle
from physcore.film.colors.colormaps import WHOLE, ColormapName, diverging, look_up, ramp
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import SHADING, BodyStyle, InkArray, Painter, Part, Scale, inks, places
from physcore.film.styles.coloring import Coloring, checked
from physcore.film.styles.torn import has_tears, intact
from physcore.film.styles.typical import Typical
from physcore.scene.bodies import Body, SpringNetwork
from physcore.simulation.sources import Source, SourceFrame

WIDTHS = (1.0, 3.4)
"""Smallest and largest width of lines that is chosen automatically [pixels]."""
NEVER = 1e-9
"""Least end of the color scale: smaller strains are rounding errors [1]."""
BRACE = 1.2
"""Springs longer than the typical shortest one by this factor are braces [1]."""
TENSIONS = "tensions"
"""The field of the tensions of rods."""
FEW = 64
"""Number of particles with a radius up to which they are drawn by default."""
LONG = 24.0
"""Length of the parts of a spring in 3D; each part is sorted by its own depth [pixels]."""
FAINT = 0.5
"""Opacity of a brace; also its width relative to other springs."""
PIN = 2.4
"""Radius of the mark of a particle that is held in place [pixels]."""


@dataclass(frozen=True)
class Strain(BodyStyle):
    """Springs as lines: blue if compressed, red if stretched, neutral in between.

    The scale is symmetric and the same for the whole film. Colors follow the square root of the strain, so that small
    strains are visible beside large ones. Rods, which have no strain, show their tension if it was recorded. A spring
    that lies along two others is not drawn, because bending springs would hide the springs below them. Braces, which
    are longer than their neighbors, are drawn fainter. Broken springs are not drawn.

    Args:
        range: the strain (length / rest length - 1) at the ends of the scale [1], for rods the tension [N]; None: a
            typical value of the film.
        width: width of the lines [pixels]; None: a width that suits their length.
        nodes: whether particles with a radius are drawn as discs of that size, in 3D as lit balls. None: if at most 64
            have one, as the bobs of pendulums do.
        color: "strain"; or chosen colors for springs and nodes, as in Points: one such as "tomato", one for each body
            or particle, or values or a function for a color scale. A spring has the mean color of its ends.
        colormap: the map of the color scale of values, as in Points; None: a part of "viridis".
        on: as in Style; each body must have springs.

    Raises:
        SceneError: a value is out of range.
    """

    range: float | None = None
    width: float | None = None
    nodes: bool | None = None
    color: Literal["strain"] | ColorChoice | PerBody | PerParticle = "strain"
    colormap: ColormapName | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set_positive("range", "width")
        self._set(color=checked(self.color, "Strain.color", ("strain",)))
        ramp(self.colormap, "viridis", WHOLE, "Strain.colormap")
        if self.nodes is not None:
            self._set(nodes=flag(self.nodes, "Strain.nodes"))

    def can_draw(self, body: Body) -> bool:
        """Whether a body has springs."""
        return body.elements.get("springs", 0) > 0

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter with the color scale of one film."""
        for part in parts:
            if not self.can_draw(part.body):
                raise SceneError(f"Strain.on: {part.body!r} has no springs; use Points(on=…) for it")
        return StrainPainter(self, source, parts, theme)


class StrainPainter(Painter):
    """Painter of springs, nodes and held particles."""

    def __init__(self, style: Strain, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._style, self._domain, self._theme = style, style, source.scene.periodic, theme
        self._table = diverging(theme.compressed, theme.relaxed, theme.stretched)
        pairs, rest, chain, brace, fixed, springs, rods, nodes, radii = [], [], [], [], [], [], [], [], []
        for part in parts:
            body = cast("SpringNetwork", part.body)  # the style has checked this
            shown = ~covered(body.pairs, body.rest_length)
            pairs.append(body.pairs[shown] + part.where.start)
            rods.append(body.rods[shown])
            springs.append(np.flatnonzero(shown) + source.scene.first_spring(body))
            rest.append(body.rest_length[shown])
            brace.append(body.rest_length[shown] > BRACE * _spacing(body.pairs[shown], body.rest_length[shown]))
            chain.append(np.full(shown.sum(), shown.sum() < 1.5 * len(body)))
            fixed.append(np.flatnonzero(body.fixed) + part.where.start)
            sized = body.radius > 0.0
            seen = np.flatnonzero(sized & (sized.sum() <= FEW if style.nodes is None else style.nodes))
            nodes.append(seen + part.where.start)
            radii.append(body.radius[seen])
        # The longest springs are painted first, so that the weave of a cloth lies above its diagonals.
        order = np.argsort(-np.concatenate(rest), kind="stable")
        self._pairs: IntArray = np.concatenate(pairs)[order]
        self._rest: FloatArray = np.concatenate(rest)[order]
        self._brace: BoolArray = np.concatenate(brace)[order]
        self._chain: BoolArray = np.concatenate(chain)[order]
        self._fixed: IntArray = np.concatenate(fixed)
        self._nodes: IntArray = np.concatenate(nodes)
        self._radii: FloatArray = np.concatenate(radii)
        rigid = bool(len(order)) and bool(np.concatenate(rods).all()) and source.has(TENSIONS)
        self._springs: IntArray | None = np.concatenate(springs)[order] if has_tears(source, parts) else None
        self._rods: IntArray | None = np.concatenate(springs)[order] if rigid else None
        self.top, self._typical = style.range or NEVER, Typical()
        self._where, self._count = places(parts), source.scene.particles
        self._coloring: Coloring | None = None
        if not is_word(style.color, "strain"):
            table = ramp(style.colormap, "viridis", theme.part, "Strain.colormap")
            chosen = cast("Chosen", style.color)
            self._coloring = Coloring(chosen, table, "Strain.color", source, parts, theme)
            self.low, self.top = self._coloring.low, self._coloring.top
            self.fixed = self._coloring.fixed

    @property
    def settled(self) -> bool:
        """Whether the end of the color scale was given."""
        return self._style.range is not None if self._coloring is None else self._coloring.settled

    @property
    def scale(self) -> Scale | None:
        """The color scale."""
        if self._coloring is not None:
            return self._coloring.scale(self.low, self.top)
        scale = strain_scale(self.top, self._table)
        return scale if self._rods is None else replace(scale, quantity="tension", unit="N")

    def observe(self, frame: SourceFrame) -> None:
        """Update the end of the color scale by a frame."""
        if self._coloring is not None:
            self._coloring.observe(frame)
            self.low, self.top = self._coloring.low, self._coloring.top
        elif self._style.range is None:
            self.top = max(NEVER, self._typical.add(np.abs(self._values(frame)[self._whole(frame)])))

    def inset(self, pixels: float) -> float:
        """Half the width of a line, and a mark of a held particle."""
        del pixels
        return max(WIDTHS[1], self._style.width or 0.0) / 2 + PIN

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue the springs, with held particles above them."""
        points, depth, _ = view.project(frame.positions)
        first, second = self._pairs.T
        ends, between = points[second], None if depth is None else (depth[first] + depth[second]) / 2
        if self._domain is not None:  # A spring across a face of the domain extends beyond it.
            ends, there, _ = view.project(frame.positions[first] + self._separation(frame))
            between = None if depth is None or there is None else (depth[first] + there) / 2
        farness = None if between is None else view.farness(between)
        own = self._own_colors(frame)
        if own is None:
            colors = look_up(self._table, rooted(self._values(frame) / self.top))
        else:
            colors = (own[first] + own[second]) / 2
        ink = inks(colors, self._theme, farness)
        ink[self._brace, 3] = round(255 * FAINT)
        widths = self._widths(view)
        whole = self._whole(frame)
        lines = np.concatenate([points[first], ends], axis=1)[whole]
        if depth is None:
            canvas.lines(lines, widths[whole], ink[whole])
        else:
            steps = (2.0 * (between - depth[first]))[whole]
            canvas.lines(*divided(lines, widths[whole], ink[whole], depth[first][whole], steps, whole=view.turnable))
        self._paint_nodes(canvas, frame, view, own)
        pins = np.tile(np.array([*self._theme.text, 255], dtype=np.uint8), (len(self._fixed), 1))
        radius = np.minimum(PIN, 0.6 + 0.7 * float(np.median(widths)))
        radii = np.full(len(self._fixed), radius, dtype=np.float32)
        canvas.discs(points[self._fixed], radii, pins, None if depth is None else depth[self._fixed])

    def _paint_nodes(self, canvas: Canvas, frame: SourceFrame, view: View, own: FloatArray | None) -> None:
        """Queue the particles that have a radius."""
        points, depth, magnification = view.project(frame.positions[self._nodes])
        sizes = (self._radii * magnification).astype(np.float32)
        plain = np.tile(np.array(self._theme.text, dtype=float), (len(sizes), 1))
        colors = inks(
            plain if own is None else own[self._nodes], self._theme, None if depth is None else view.farness(depth)
        )
        # A node is drawn over the springs that end in it.
        nearer = None if depth is None else depth - (self._radii).astype(np.float32)
        canvas.discs(points, sizes, colors, nearer, 0.0 if view.flat else SHADING)

    def _own_colors(self, frame: SourceFrame) -> FloatArray | None:
        """The chosen colors (N, 3) of all particles of the scene; None if colors show the strain."""
        if self._coloring is None:
            return None
        colors = np.zeros((self._count, 3))
        colors[self._where] = self._coloring.colors(frame, self.low, self.top)
        return colors

    def _whole(self, frame: SourceFrame) -> BoolArray | slice:
        """The springs that are drawn, as a mask (M,) or a slice."""
        return slice(None) if self._springs is None else intact(frame, self._springs)

    def _values(self, frame: SourceFrame) -> FloatArray:
        """The strains (M,), or the tensions of rods (M,)."""
        if self._rods is None:
            return self._strain(frame)
        tensions: FloatArray = frame.fields[TENSIONS][self._rods]
        return tensions

    def _strain(self, frame: SourceFrame) -> FloatArray:
        """The strains (M,): length over rest length, minus 1. If the rest length is 0, the mean length is the
        denominator.
        """
        separation = self._separation(frame)
        length = np.sqrt(np.einsum("md,md->m", separation, separation))
        rest = self._rest
        if not (rest > 0.0).all():
            rest = np.where(rest > 0.0, rest, max(float(length.mean()), NEVER))
        strain: FloatArray = (length - self._rest) / rest
        return strain

    def _separation(self, frame: SourceFrame) -> FloatArray:
        """The vector between the ends of each spring [m], (M, D); in a periodic domain, between nearest images."""
        first, second = self._pairs.T
        separation = frame.positions[second] - frame.positions[first]
        return separation if self._domain is None else self._domain.nearest(separation)

    def _widths(self, view: View) -> np.ndarray:
        """The widths (M,) [pixels]. A rope is thicker than the threads of a cloth."""
        if self._style.width is not None:
            return np.full(len(self._rest), self._style.width, dtype=np.float32)
        length = float(np.median(self._rest)) * view.scale
        widths = np.clip(np.where(self._chain, max(0.6 * length, 2.2), 0.17 * length), *WIDTHS)
        return np.where(self._brace, np.maximum(FAINT * widths, WIDTHS[0]), widths).astype(np.float32)


def rooted(strain: FloatArray) -> FloatArray:
    """Positions 0–1 on a color table of relative strains from -1 to 1. The square root makes small strains visible."""
    fraction: FloatArray = 0.5 + 0.5 * np.sign(strain) * np.sqrt(np.abs(strain))
    return fraction


def strain_scale(top: float, table: FloatArray) -> Scale:
    """The color scale of strains from -top to top, for colors looked up by `rooted`."""
    return Scale("strain", "", (-top, top), look_up(table, rooted(np.linspace(-1.0, 1.0, len(table)))))


def _spacing(pairs: IntArray, rest_length: FloatArray) -> float:
    """The median over all particles of the length of their shortest spring [m]."""
    shortest = np.full(int(pairs.max(initial=-1)) + 1, np.inf)
    np.minimum.at(shortest, pairs.ravel(), np.repeat(rest_length, 2))
    return float(np.median(shortest[np.isfinite(shortest)])) if len(pairs) else 0.0


def covered(pairs: IntArray, rest_length: FloatArray) -> BoolArray:
    """Mask (M,) of the springs that lie, at rest, along two others that connect the same particles."""
    longest = 1.001  # largest ratio of the two lengths together to the direct length
    both = np.concatenate([pairs, pairs[:, ::-1]])
    count = int(both.max(initial=-1)) + 1
    keys = both[:, 0] * count + both[:, 1]
    order = np.argsort(keys, kind="stable")
    keys, source, target = keys[order], both[order, 0], both[order, 1]
    lengths = np.concatenate([rest_length, rest_length])[order]
    starts = np.searchsorted(source, np.arange(count + 1))
    result = np.zeros(len(pairs), dtype=bool)
    if len(pairs) == 0:
        return result
    degrees = np.diff(starts)[pairs[:, 0]]
    for step in range(int(degrees.max())):
        # For the step-th neighbor of each spring's first end: find a spring from there to its second end.
        index = np.flatnonzero(degrees > step)
        there = starts[pairs[index, 0]] + step
        wanted = target[there] * count + pairs[index, 1]
        onward = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        detour = lengths[there] + lengths[onward]
        proper = (lengths[there] > 0.0) & (lengths[onward] > 0.0)
        result[index] |= proper & (keys[onward] == wanted) & (detour <= longest * rest_length[index])
    return result


def divided(
    lines: PixelArray,
    widths: PixelArray,
    ink: InkArray,
    depths: PixelArray,
    steps: PixelArray,
    *,
    whole: bool = False,
) -> tuple[PixelArray, PixelArray, InkArray, PixelArray]:
    """Cut lines (M, 4) in 3D into parts that are sorted by depth separately. Returns the ends, widths, inks and depths.

    Args:
        lines, widths, ink: as for `Canvas.lines`.
        depths: depths of the first ends (M,) [m].
        steps: differences of depth from the first to the second ends (M,) [m].
        whole: whether lines are not cut.
    """
    if whole:
        return lines, widths, ink, np.stack([depths, depths + steps], axis=1)
    lengths = np.hypot(lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1])
    counts = np.clip(np.ceil(np.nan_to_num(lengths) / LONG), 1, 64).astype(np.intp)
    index = np.repeat(np.arange(len(lines)), counts)
    part = np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)
    low, high = ((part + each) / counts[index] for each in (0, 1))
    start, way = lines[index, :2], lines[index, 2:] - lines[index, :2]
    ends = np.concatenate([start + low[:, np.newaxis] * way, start + high[:, np.newaxis] * way], axis=1)
    places = depths[index, np.newaxis] + np.stack([low, high], axis=1) * steps[index, np.newaxis]
    return ends.astype(np.float32), widths[index], ink[index], places.astype(np.float32)
