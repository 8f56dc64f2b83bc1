"""Ropes as smooth tubes, plain or laid of strands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import cast

import numpy as np

from physcore._core import Canvas, spline_points
from physcore.checks import FloatArray, IntArray, count
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.chosen import Chosen, ColorChoice, PerBody, PerParticle
from physcore.film.colors.colormaps import WHOLE, ColormapName, ramp
from physcore.film.colors.light import lit
from physcore.film.colors.themes import Theme
from physcore.film.styles.base import BodyStyle, Painter, Part, Scale, inks, places
from physcore.film.styles.coloring import Coloring, checked
from physcore.film.styles.rim import thickness_of
from physcore.film.styles.strain import covered
from physcore.film.styles.torn import has_tears, intact
from physcore.scene.bodies import Body, SpringNetwork
from physcore.simulation.sources import Source, SourceFrame

PARTS = 5
"""Rings of a tube for each spring."""
SIDES, PER_STRAND = 14, 8
"""Corners of a ring of a plain tube; those of each strand."""
LAY = 3.5
"""Length in which a strand turns once, over the diameter of the rope; 3 to 4 for laid ropes."""
GROOVE, SHADE = 0.22, 0.45
"""Depth of the grooves between strands over the radius, and the share of light that they lack."""
SLENDER = 0.2
"""Radius of a rope without one, over the length of its springs."""


@dataclass(frozen=True)
class Tube(BodyStyle):
    """Ropes as smooth tubes through their particles (a cubic spline), lit like surfaces.

        rope = pc.rope(40, length=1.0, stiffness=500.0, mass=0.01, pinned="start")
        pc.film(recording, "rope.gif", style=pc.styles.Tube("#d9a441", radius=0.02, strands=3))

    Networks are drawn in which no particle has more than two springs, without those along two others. A broken spring
    ends a tube.

    Args:
        color: "body", or chosen colors as in Points: one such as "tomato", one for each body or particle, or values or
            a function for a color scale.
        radius: the radius [m]; None: half the thickness of the rope's SelfContact, else the radius of its particles,
            else a fifth of the length of its springs.
        strands: the number of strands that the rope is laid of, 2 to 12, or 0 for a plain tube.
        colormap: the map of the color scale of values, as in Points; None: a part of "viridis".
        on: as in Style; each body must be a rope.

    Raises:
        SceneError: a value is not valid.
    """

    color: ColorChoice | PerBody | PerParticle = "body"
    radius: float | None = None
    strands: int = 0
    colormap: ColormapName | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(color=checked(self.color, "Tube.color", ("body",)))
        self._set_positive("radius")
        strands = count(self.strands, "Tube.strands", most=12)
        if strands == 1:
            raise SceneError("Tube.strands: must be 0 for a plain tube, or 2 to 12, got 1")
        ramp(self.colormap, "viridis", WHOLE, "Tube.colormap")

    def can_draw(self, body: Body) -> bool:
        """Whether a body is a network of ropes."""
        network = body.network
        if network is None or len(network.pairs) == 0:
            return False
        pairs = network.pairs[~covered(network.pairs, network.rest_length)]
        return bool(np.bincount(pairs.ravel()).max() <= 2)

    def painter(self, source: Source, parts: list[Part], theme: Theme) -> Painter:
        """The painter with the color scale of one film."""
        for part in parts:
            if not self.can_draw(part.body):
                raise SceneError(f"Tube.on: {part.body!r} is no rope; use Strain(on=…) for it")
        return TubePainter(self, source, parts, theme)


@dataclass(frozen=True, eq=False)
class _Rope:
    """Particles in a row."""

    particles: IntArray
    """Indices in the scene; of a closed rope the first one is not repeated."""
    springs: IntArray
    """Indices of the springs from each particle to the next one; of a closed rope also of the last to the first."""
    closed: bool
    radius: float

    def whole(self, unbroken: np.ndarray) -> Iterator[tuple[IntArray, bool]]:
        """The parts between broken springs: particles, and whether they form a ring."""
        torn = np.flatnonzero(~unbroken)
        if len(torn) == 0:
            yield self.particles, self.closed
            return
        rows = self.particles
        if self.closed:  # open it behind the first broken spring
            rows, torn = np.roll(rows, -torn[0] - 1), (torn - torn[0] - 1) % len(rows)
        for piece in np.split(rows, np.sort(torn) + 1):
            if len(piece) > 1:
                yield piece, False


class TubePainter(Painter):
    """Painter of tubes."""

    def __init__(self, style: Tube, source: Source, parts: list[Part], theme: Theme) -> None:
        self.style, self._theme, self._strands = style, theme, style.strands
        self._where, self._count = places(parts), source.scene.particles
        table = ramp(style.colormap, "viridis", theme.part, "Tube.colormap")
        self._coloring = Coloring(cast("Chosen", style.color), table, "Tube.color", source, parts, theme)
        self.low, self.top, self.fixed = self._coloring.low, self._coloring.top, self._coloring.fixed
        self._torn = has_tears(source, parts)
        self._ropes = [
            rope
            for part in parts
            for rope in _ropes(cast("SpringNetwork", part.body), part.where.start, source, style.radius)
        ]
        self._starts: list[FloatArray | None] = [None] * len(self._ropes)

    @property
    def settled(self) -> bool:
        """Whether the ends of the color scale were given, or there is no scale."""
        return self._coloring.settled

    @property
    def scale(self) -> Scale | None:
        """The color scale."""
        return self._coloring.scale(self.low, self.top)

    @property
    def margin(self) -> float:
        """The largest radius [m]."""
        return max((rope.radius for rope in self._ropes), default=0.0)

    def begin(self) -> None:
        """Forget how the strands lay in the last frame."""
        self._starts = [None] * len(self._ropes)

    def observe(self, frame: SourceFrame) -> None:
        """Update the ends of the color scale by a frame."""
        self._coloring.observe(frame)
        self.low, self.top = self._coloring.low, self._coloring.top

    def inset(self, pixels: float) -> float:
        """A margin of 1.5 pixels."""
        del pixels
        return 1.5

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue the triangles of all tubes."""
        del pixels
        colors = np.zeros((self._count, 3))
        colors[self._where] = self._coloring.colors(frame, self.low, self.top)
        for index, rope in enumerate(self._ropes):
            unbroken = intact(frame, rope.springs) if self._torn else np.ones(len(rope.springs), dtype=np.bool_)
            for particles, closed in rope.whole(unbroken):
                self._paint_tube(canvas, frame.positions[particles], colors[particles], rope, index, view, closed)

    def _paint_tube(
        self,
        canvas: Canvas,
        points: FloatArray,
        colors: FloatArray,
        rope: _Rope,
        index: int,
        view: View,
        closed: bool,
    ) -> None:
        """Queue the triangles of one tube through some points."""
        solid = np.column_stack([points, np.zeros(len(points))]) if view.flat else points
        line = spline_points(np.ascontiguousarray(solid), closed, PARTS)
        if closed and not np.array_equal(line[0], line[-1]):
            line = np.concatenate([line, line[:1]])
        normals, binormals = _transported(line, self._starts[index])
        self._starts[index] = normals[0]
        rings, shades = self._rings(line, normals, binormals, rope.radius)
        outward = _outward(rings)
        if not closed:  # the ends are closed by a point each
            rings = np.concatenate([np.broadcast_to(line[0], rings[:1].shape), rings])
            rings = np.concatenate([rings, np.broadcast_to(line[-1], rings[:1].shape)])
            along = np.gradient(line, axis=0)[[0, -1]]
            along /= np.linalg.norm(along, axis=1, keepdims=True)
            ends = np.broadcast_to(along[:, np.newaxis], (2, *outward.shape[1:]))
            outward = np.concatenate([-ends[:1], outward, ends[1:]])
            shades = np.concatenate([shades[:1], shades, shades[-1:]])
        share = np.linspace(0.0, len(points) - (not closed), len(rings))
        every = np.concatenate([colors, colors[:1]]) if closed else colors
        each = np.stack([np.interp(share, np.arange(len(every)), every[:, channel]) for channel in range(3)], axis=1)
        self._queue(canvas, rings, outward, shades[..., np.newaxis] * each[:, np.newaxis], view)

    def _rings(
        self, line: FloatArray, normals: FloatArray, binormals: FloatArray, radius: float
    ) -> tuple[FloatArray, FloatArray]:
        """The corners (M, K, 3) of all rings, and the share of light (M, K) that grooves leave them."""
        corners = max(SIDES, PER_STRAND * self._strands)
        angle = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
        bulge = np.abs(np.cos(0.5 * self._strands * angle))  # 1 without strands
        shades = np.broadcast_to(1.0 - SHADE * (1.0 - bulge) ** 1.5, (len(line), corners))
        # Corners turn with the strands, so that grooves lie along edges of the mesh.
        arc = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
        turned = angle + (np.pi / (radius * LAY) if self._strands else 0.0) * arc[:, np.newaxis]
        reach = radius * (1.0 - GROOVE * (1.0 - bulge))
        cosine, sine = reach * np.cos(turned), reach * np.sin(turned)
        across = cosine[..., np.newaxis] * normals[:, np.newaxis] + sine[..., np.newaxis] * binormals[:, np.newaxis]
        return line[:, np.newaxis] + across, shades

    def _queue(self, canvas: Canvas, rings: FloatArray, outward: FloatArray, colors: FloatArray, view: View) -> None:
        """Queue the visible triangles between successive rings."""
        count, corners, _ = rings.shape
        flat = rings.reshape(-1, 3)
        pixels, depth, _ = view.project(flat[:, :2] if view.flat else flat)
        seen = outward.reshape(-1, 3) if view.flat else outward.reshape(-1, 3) @ view.axes.T
        ink = inks(lit(colors.reshape(-1, 3), seen), self._theme, None if depth is None else view.farness(depth))
        index = np.arange(count * corners).reshape(count, corners)
        one, two = index[:-1], index[1:]
        sides = [one, np.roll(one, -1, axis=1), two, np.roll(two, -1, axis=1)]
        first, second = np.stack([sides[0], sides[1], sides[2]], -1), np.stack([sides[1], sides[3], sides[2]], -1)
        faces = np.stack([first, second], axis=2).reshape(-1, 3)
        faces = faces[(seen[faces, 2] > 0.0).any(axis=1)]
        canvas.triangles(
            np.ascontiguousarray(pixels[faces].reshape(-1, 6)),
            np.ascontiguousarray(ink[faces].reshape(-1, 12)),
            None if depth is None else np.ascontiguousarray(depth[faces]),
            None,
            np.zeros((len(faces), 6), dtype=np.float32),
        )


def _ropes(body: SpringNetwork, start: int, source: Source, radius: float | None) -> Iterator[_Rope]:
    """The ropes of a network."""
    shown = np.flatnonzero(~covered(body.pairs, body.rest_length))
    thick = 0.5 * thickness_of(body, source.scene) or float(body.radius.max(initial=0.0))
    own = radius or thick or SLENDER * float(np.median(body.rest_length[shown]))
    neighbors: dict[int, list[tuple[int, int]]] = {}
    for spring in shown.tolist():
        one, other = body.pairs[spring].tolist()
        neighbors.setdefault(one, []).append((other, spring))
        neighbors.setdefault(other, []).append((one, spring))
    first = source.scene.first_spring(body)
    used: set[int] = set()
    # Open ropes begin at their ends; what is left then are rings.
    for begin in sorted(neighbors, key=lambda particle: (len(neighbors[particle]), particle)):
        row, springs = [begin], list[int]()
        while step := next(((to, by) for to, by in neighbors[row[-1]] if by not in used), None):
            used.add(step[1])
            row.append(step[0])
            springs.append(step[1])
        if springs:
            closed = row[-1] == begin
            yield _Rope(start + np.array(row[:-1] if closed else row), first + np.array(springs), closed, own)


def _transported(line: FloatArray, start: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Unit normals and binormals (M, 3) along a line that do not turn about it, from a direction near `start`.

    Source: W. Wang et al., "Computation of rotation minimizing frames", ACM Trans. Graph. 27, 2 (2008): the double
    reflection method.
    """
    along = np.gradient(line, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    begin = np.eye(3)[np.argmin(np.abs(along[0]))] if start is None else start
    normals = np.empty_like(line)
    begin = begin - (begin @ along[0]) * along[0]
    normals[0] = begin / max(float(np.linalg.norm(begin)), 1e-300)
    steps = np.diff(line, axis=0)
    squares = np.maximum(np.einsum("md,md->m", steps, steps), 1e-300)
    mirrored = along[:-1] - (2.0 / squares * np.einsum("md,md->m", steps, along[:-1]))[:, np.newaxis] * steps
    second = along[1:] - mirrored
    lengths = np.maximum(np.einsum("md,md->m", second, second), 1e-300)
    for index, (step, square, turn, length) in enumerate(zip(steps, squares, second, lengths, strict=True)):
        reflected = normals[index] - (2.0 / square) * (step @ normals[index]) * step
        normals[index + 1] = reflected - (2.0 / length) * (turn @ reflected) * turn
    return normals, np.cross(along, normals)


def _outward(rings: FloatArray) -> FloatArray:
    """Unit normals (M, K, 3) of a surface of rings, away from their middle."""
    around = np.roll(rings, -1, axis=1) - np.roll(rings, 1, axis=1)
    along = np.gradient(rings, axis=0)
    normals = np.cross(around, along)
    length = np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-300)
    away = rings - rings.mean(axis=1, keepdims=True)
    sign = np.where(np.einsum("mkd,mkd->mk", normals, away) < 0.0, -1.0, 1.0)
    outward: FloatArray = sign[..., np.newaxis] * normals / length
    return outward
