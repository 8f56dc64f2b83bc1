"""Springs, colored by how far they are stretched or compressed, or as one likes; rods by their tension."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, cast

import numpy as np

from physcore._core import Canvas
from physcore.checks import BoolArray, FloatArray, IntArray, flag, is_word
from physcore.errors import SceneError
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.chosen import Chosen, ColorChoice, PerBody, PerParticle
from physcore.film.colors.colormaps import ColormapName, diverging, look_up, sequential
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import SHADING, BodyStyle, InkArray, Painter, Part, Scale, inks, places
from physcore.film.styles.coloring import Coloring, checked
from physcore.film.styles.torn import has_tears, intact
from physcore.film.styles.typical import Typical
from physcore.scene.bodies import Body, SpringNetwork
from physcore.scene.channels import first_spring
from physcore.simulation.sources import Source, SourceFrame

WIDTHS = (1.0, 3.4)
"""The thinnest and the thickest line that is chosen by itself [pixels]."""
NEVER = 1e-9
"""Strains below this are rounding, and stay neutral [1]."""
BRACE = 1.2
"""Springs longer than the typical shortest one by this factor are braces [1]."""
TENSIONS = "tensions"
"""The field of springs that rods are colored by."""
FEW = 64
"""Up to so many particles with a radius are drawn by themselves."""
LONG = 24.0
"""The length of the parts that a spring in space is drawn in, each with a depth of its own [pixels]."""
FAINT = 0.5
"""Opacity of a brace, and its width as a fraction of the others'."""
PIN = 2.4
"""Radius of a particle that is held in place [pixels]."""


@dataclass(frozen=True)
class Strain(BodyStyle):
    """Each spring is a line: blue when compressed, red when stretched, neutral in between.

    The scale is symmetric, the same for the whole film, and goes with the root of the strain, so that small strains
    show beside large ones. Rods, which are never stretched, show their tension instead, if it was recorded. A spring
    that lies along two others is not drawn: bending springs would hide what they reinforce. Braces,
    which are longer than their neighbors, are drawn fainter. Broken springs are not drawn.

    Args:
        range: the strain (length / rest length - 1) at which colors end [1], of rods the tension [N]; None: what is
            typical of the film.
        width: of the lines [pixels]; None: as fits their length.
        nodes: whether particles with a radius are drawn as discs of that size, in 3D as lit balls; None: where not
            more than a few have one, such as the bobs of pendulums.
        color: "strain", or colors of one's own for springs and nodes, as in Points: one, such as "tomato", one for each
            body or particle, or values or a function of which each is a place on a ramp. A spring has the mean color of
            its ends.
        colormap: the ramp of values, as in Points.
        on: as in Style; it must have springs.

    Raises:
        SceneError: a value is out of range.
    """

    range: float | None = None
    width: float | None = None
    nodes: bool | None = None
    color: Literal["strain"] | ColorChoice | PerBody | PerParticle = "strain"
    colormap: ColormapName = "viridis"

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set_positive("range", "width")
        self._set(color=checked(self.color, "Strain.color", ("strain",)))
        sequential(self.colormap, (0.0, 1.0), "Strain.colormap")
        if self.nodes is not None:
            self._set(nodes=flag(self.nodes, "Strain.nodes"))

    def can_draw(self, body: Body) -> bool:
        """Whether it has springs."""
        return isinstance(body, SpringNetwork) and len(body.pairs) > 0

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """A painter with the color scale of one film."""
        for part in parts:
            if not self.can_draw(part.body):
                raise SceneError(f"Strain.on: {part.body!r} has no springs; use Points(on=…) for it")
        return StrainPainter(self, source, parts, theme)


class StrainPainter(Painter):
    """Draws lines, and what is pinned."""

    def __init__(self, style: Strain, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._style, self._domain, self._theme = style, style, source.scene.periodic, theme
        self._table = diverging(theme.compressed, theme.relaxed, theme.stretched)
        pairs, rest, chain, brace, fixed, springs, rods, nodes, radii = [], [], [], [], [], [], [], [], []
        for part in parts:
            body = part.body
            assert isinstance(body, SpringNetwork)  # the style has made sure of it
            shown = ~covered(body.pairs, body.rest_length)
            pairs.append(body.pairs[shown] + part.where.start)
            rods.append(body.rods[shown])
            springs.append(np.flatnonzero(shown) + first_spring(source.scene, body))
            rest.append(body.rest_length[shown])
            brace.append(body.rest_length[shown] > BRACE * _spacing(body.pairs[shown], body.rest_length[shown]))
            chain.append(np.full(shown.sum(), shown.sum() < 1.5 * len(body)))
            fixed.append(np.flatnonzero(body.fixed) + part.where.start)
            sized = body.radius > 0.0
            seen = np.flatnonzero(sized & (sized.sum() <= FEW if style.nodes is None else style.nodes))
            nodes.append(seen + part.where.start)
            radii.append(body.radius[seen])
        # The longest are painted first, so that in a cloth the weave lies above its diagonals.
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
            ramp = sequential(style.colormap, theme.part, "Strain.colormap")
            chosen = cast("Chosen", style.color)
            self._coloring = Coloring(chosen, ramp, "Strain.color", source, parts, theme)
            self.low, self.top = self._coloring.low, self._coloring.top
            self.fixed = self._coloring.fixed

    @property
    def settled(self) -> bool:
        """Whether the end of the color scale was given."""
        return self._style.range is not None if self._coloring is None else self._coloring.settled

    @property
    def scale(self) -> Scale | None:
        """The scale of colors."""
        if self._coloring is not None:
            return self._coloring.scale(self.low, self.top)
        scale = strain_scale(self.top, self._table)
        return scale if self._rods is None else replace(scale, quantity="tension", unit="N")

    def observe(self, frame: SourceFrame) -> None:
        """Find the end of the color scale."""
        if self._coloring is not None:
            self._coloring.observe(frame)
            self.low, self.top = self._coloring.low, self._coloring.top
        elif self._style.range is None:
            self.top = max(NEVER, self._typical.add(np.abs(self._values(frame)[self._whole(frame)])))

    def inset(self, pixels: float) -> float:
        """A line's half width, or a pin."""
        del pixels
        return max(WIDTHS[1], self._style.width or 0.0) / 2 + PIN

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Add lines, and pins above them."""
        points, depth, _ = view.project(frame.positions)
        first, second = self._pairs.T
        ends, between = points[second], None if depth is None else (depth[first] + depth[second]) / 2
        if self._domain is not None:  # A spring that crosses a face sticks out of it.
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
            canvas.lines(*divided(lines, widths[whole], ink[whole], depth[first][whole], steps))
        self._paint_nodes(canvas, frame, view, own)
        pins = np.tile(np.array([*self._theme.text, 255], dtype=np.uint8), (len(self._fixed), 1))
        radius = np.minimum(PIN, 0.6 + 0.7 * float(np.median(widths)))
        radii = np.full(len(self._fixed), radius, dtype=np.float32)
        canvas.discs(points[self._fixed], radii, pins, None if depth is None else depth[self._fixed])

    def _paint_nodes(self, canvas: Canvas, frame: SourceFrame, view: View, own: FloatArray | None) -> None:
        """Add particles that have a radius."""
        points, depth, magnification = view.project(frame.positions[self._nodes])
        sizes = (self._radii * magnification).astype(np.float32)
        plain = np.tile(np.array(self._theme.text, dtype=float), (len(sizes), 1))
        colors = inks(
            plain if own is None else own[self._nodes], self._theme, None if depth is None else view.farness(depth)
        )
        # A node lies over the springs that end in it.
        nearer = None if depth is None else depth - (self._radii).astype(np.float32)
        canvas.discs(points, sizes, colors, nearer, 0.0 if view.flat else SHADING)

    def _own_colors(self, frame: SourceFrame) -> FloatArray | None:
        """The colors of all particles of the scene (N, 3), where they were chosen."""
        if self._coloring is None:
            return None
        colors = np.zeros((self._count, 3))
        colors[self._where] = self._coloring.colors(frame, self.low, self.top)
        return colors

    def _whole(self, frame: SourceFrame) -> BoolArray | slice:
        """Which springs are drawn (M,)."""
        return slice(None) if self._springs is None else intact(frame, self._springs)

    def _values(self, frame: SourceFrame) -> FloatArray:
        """Strains, or tensions of rods, (M,)."""
        if self._rods is None:
            return self._strain(frame)
        tensions: FloatArray = frame.fields[TENSIONS][self._rods]
        return tensions

    def _strain(self, frame: SourceFrame) -> FloatArray:
        """Length over rest length less one, (M,). Where the rest length is 0, the mean length takes its place."""
        separation = self._separation(frame)
        length = np.sqrt(np.einsum("md,md->m", separation, separation))
        rest = self._rest
        if not (rest > 0.0).all():
            rest = np.where(rest > 0.0, rest, max(float(length.mean()), NEVER))
        strain: FloatArray = (length - self._rest) / rest
        return strain

    def _separation(self, frame: SourceFrame) -> FloatArray:
        """Separation of the two ends of each spring [m], (M, D), in a domain that of the nearest images."""
        first, second = self._pairs.T
        separation = frame.positions[second] - frame.positions[first]
        return separation if self._domain is None else self._domain.nearest(separation)

    def _widths(self, view: View) -> np.ndarray:
        """Widths (M,) [pixels]: a rope is thicker than the threads of a cloth."""
        if self._style.width is not None:
            return np.full(len(self._rest), self._style.width, dtype=np.float32)
        length = float(np.median(self._rest)) * view.scale
        widths = np.clip(np.where(self._chain, max(0.6 * length, 2.2), 0.17 * length), *WIDTHS)
        return np.where(self._brace, np.maximum(FAINT * widths, WIDTHS[0]), widths).astype(np.float32)


def rooted(strain: FloatArray) -> FloatArray:
    """Places of strains from -1 to 1 on a table of colors, 0–1: by their square root, so that small ones show."""
    fraction: FloatArray = 0.5 + 0.5 * np.sign(strain) * np.sqrt(np.abs(strain))
    return fraction


def strain_scale(top: float, table: FloatArray) -> Scale:
    """The scale of strains from -top to top whose colors are looked up by `rooted`."""
    return Scale("strain", "", (-top, top), look_up(table, rooted(np.linspace(-1.0, 1.0, len(table)))))


def _spacing(pairs: IntArray, rest_length: FloatArray) -> float:
    """The typical length of a particle's shortest spring [m]."""
    shortest = np.full(int(pairs.max(initial=-1)) + 1, np.inf)
    np.minimum.at(shortest, pairs.ravel(), np.repeat(rest_length, 2))
    return float(np.median(shortest[np.isfinite(shortest)])) if len(pairs) else 0.0


def covered(pairs: IntArray, rest_length: FloatArray) -> BoolArray:
    """Which springs (M,) lie, at rest, along two others that meet on the way."""
    longest = 1.001  # how much longer than the direct way the two may be
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
        # The step-th neighbor of each spring's first end: does a spring lead on from there to its second end?
        index = np.flatnonzero(degrees > step)
        there = starts[pairs[index, 0]] + step
        wanted = target[there] * count + pairs[index, 1]
        onward = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        detour = lengths[there] + lengths[onward]
        proper = (lengths[there] > 0.0) & (lengths[onward] > 0.0)
        result[index] |= proper & (keys[onward] == wanted) & (detour <= longest * rest_length[index])
    return result


def divided(
    lines: PixelArray, widths: PixelArray, ink: InkArray, depths: PixelArray, steps: PixelArray
) -> tuple[PixelArray, PixelArray, InkArray, PixelArray]:
    """Lines (M, 4) in space, cut into parts of which each is sorted by itself: ends, widths, inks and depths of ends.

    Args:
        lines, widths, ink: as the canvas takes them.
        depths: of the first ends (M,) [m].
        steps: from there to the second ends (M,) [m].
    """
    lengths = np.hypot(lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1])
    counts = np.clip(np.ceil(np.nan_to_num(lengths) / LONG), 1, 64).astype(np.intp)
    index = np.repeat(np.arange(len(lines)), counts)
    part = np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)
    low, high = ((part + each) / counts[index] for each in (0, 1))
    start, way = lines[index, :2], lines[index, 2:] - lines[index, :2]
    ends = np.concatenate([start + low[:, np.newaxis] * way, start + high[:, np.newaxis] * way], axis=1)
    places = depths[index, np.newaxis] + np.stack([low, high], axis=1) * steps[index, np.newaxis]
    return ends.astype(np.float32), widths[index], ink[index], places.astype(np.float32)
