"""Fields on 2D grids as lit surfaces in 3D."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from physcore._core import Canvas, Sky
from physcore.checks import BoolArray, FloatArray, IntArray, number
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.colormaps import STEPS, WHOLE, ColormapName, look_up, sequential
from physcore.film.colors.light import LAMP, sky_above
from physcore.film.colors.themes import Theme, mixed
from physcore.film.page.tape import Tape
from physcore.film.resampling import cubic
from physcore.film.shapes.box import corners
from physcore.film.styles.base import Painter, Scale, SystemPart, SystemStyle, inks
from physcore.film.styles.grid_field import LOUDEST, NEVER, GridPainter
from physcore.film.styles.typical import Typical
from physcore.scene.system import System
from physcore.simulation.sources import Source, SourceFrame

RISE = 0.05
"""Default height at the end of the scale, as a fraction of the grid's longer side."""
MESH = 180
"""Largest number of squares of the mesh along a side, for squares of one or two pixels in pictures of common size."""
ROOT = 0.4
"""Depth of the block below the lowest value, in units of the height at the end of the scale."""
AMBIENT = 0.42
"""Ambient light, as a fraction of the full light."""
GLOSS = 0.5
"""Brightness of the specular reflection of the lamp; 1 is white."""
SHARPNESS = 40.0
"""Exponent of the specular reflection. Source: J. F. Blinn, Computer Graphics 11 (2), 192 (1977)."""
STEEP = 0.5
"""Least end of the scale, as a fraction of the largest value of the film."""
DEEP, SHALLOW = (6.0, 52.0, 84.0), (70.0, 190.0, 200.0)
"""Colors of water in a trough and in a crest."""
SHADE = 0.45
"""Brightness of the sides of the block."""


@dataclass(frozen=True)
class Relief(SystemStyle):
    """Field on a 2D grid as a lit surface in 3D. Bodies of the scene are raised to the surface.

        pc.film(recording, "waves.gif", style=pc.styles.Relief())

    The scale is the same for the whole film; most of its frames are within. Boundaries of the 2D scene are not drawn.

    Args:
        quantity: the name of the field; None: the first field of the system.
        height: height of the surface at the end of the scale [m]; None: 5 % of the grid's longer side.
        colormap: "viridis", "inferno", …, or a map of Matplotlib; None: colors of water, from deep to shallow.
        range: the value at the end of the scale; None: the largest value of most frames.
        gloss: strength of the lamp's reflection, 0 to 1.
        sky: strength of the sky's reflection, 0 to 1; None: 1 with the colors of water, 0 with a colormap.
        on: the system or systems drawn in this style; None: all with fields on a grid in 2D.

    Raises:
        SceneError: a value is not valid, or the quantity was not recorded.
    """

    quantity: str | None = None
    height: float | None = None
    colormap: ColormapName | None = None
    range: float | None = None
    gloss: float = GLOSS
    sky: float | None = None

    dimensions: ClassVar[tuple[int, ...]] = (2,)
    raises: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set_positive("height", "range")
        if self.colormap is not None:
            sequential(self.colormap, (0.0, 1.0), "Relief.colormap")
        self._set(gloss=number(self.gloss, "Relief.gloss", least=0.0, most=1.0))
        if self.sky is not None:
            self._set(sky=number(self.sky, "Relief.sky", least=0.0, most=1.0))

    def can_draw(self, item: System) -> bool:
        """Whether an item is on a 2D grid."""
        return "cells" in item.elements and item.dimension in self.dimensions

    def painter(self, source: Source, part: SystemPart, theme: Theme) -> Painter:
        """The painter with the scale of one film."""
        if not self.can_draw(part.system):
            raise SceneError(
                f"Relief.on: {part.system!r} has no field on a grid in 2D; use Field() in 3D, Line() in 1D"
            )
        return ReliefPainter(self, source, part, theme)


class ReliefPainter(GridPainter):
    """Painter of a block with the field as its upper surface."""

    def __init__(self, style: Relief, source: Source, part: SystemPart, theme: Theme) -> None:
        super().__init__(style, style.quantity, source, part, theme, "Relief")
        self._style = style
        self.top = NEVER if style.range is None else style.range
        self._sizes: FloatArray = np.array(self._grid.upper) - self._grid.origin
        self._height = RISE * float(self._sizes.max()) if style.height is None else style.height
        if style.colormap is None:
            # Crests are thin, and let more light through.
            shares = np.linspace(0.0, 1.0, STEPS)[:, np.newaxis] ** 1.5
            self._table: FloatArray = (1.0 - shares) * np.array(DEEP) + shares * np.array(SHALLOW)
        else:
            self._table = sequential(style.colormap, WHOLE, "Relief.colormap")
        self._mirror = float(style.colormap is None) if style.sky is None else style.sky
        self._solid = np.array(mixed(theme.solid, theme.background, 0.2), dtype=float)

    def typical(self) -> Typical:
        """The estimator for the end of the scale, from the largest value of each frame."""
        return Typical(100.0, LOUDEST, STEEP)

    @property
    def scale(self) -> Scale | None:
        """The color scale; None if all values are zero."""
        low = -self.top if self.signed else 0.0
        return None if self.top == NEVER else Scale(self.quantity, self.unit, (low, self.top), self._table)

    @property
    def settled(self) -> bool:
        """Whether the end of the scale was given."""
        return self._style.range is not None

    @property
    def landmarks(self) -> FloatArray:
        """The corners of the block."""
        return corners(np.array([*self._grid.origin, self._floor]), np.array([*self._grid.upper, self._height]))

    @property
    def _floor(self) -> float:
        """The height of the block's lower face [m]."""
        return -(ROOT + self.signed) * self._height

    def observe(self, frame: SourceFrame) -> None:
        """Update the end of the scale by a frame."""
        if not self.settled:
            self.observe_range(frame)

    def inset(self, pixels: float) -> float:
        """A margin of 1.5 pixels."""
        del pixels
        return 1.5

    def raised(self, frame: SourceFrame) -> SourceFrame:
        """The frame with its particles raised to the surface."""
        if len(frame.positions) == 0:
            return frame
        heights = self._heights(frame)
        places = (frame.positions[:, :2] - self._grid.origin) / self._sizes * np.array(self._squares)
        low = np.clip(np.floor(places).astype(int), 0, np.array(self._squares) - 1)
        (u, v), (i, j) = np.clip(places - low, 0.0, 1.0).T, low.T
        below = (1.0 - u) * heights[i, j] + u * heights[i + 1, j]
        above = (1.0 - u) * heights[i, j + 1] + u * heights[i + 1, j + 1]
        positions = frame.positions + np.stack([0.0 * u, 0.0 * u, (1.0 - v) * below + v * above], axis=1)
        return replace(frame, fields={**frame.fields, "positions": positions})

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Queue the surface, then the sides of the block that face the camera."""
        del pixels
        heights = self._heights(frame)
        places = np.concatenate([self._plane, heights[..., np.newaxis]], axis=-1).reshape(-1, 3)
        normals, solid = self._normals(heights, view), self._is_solid.reshape(-1, 1)
        colors = self._colors(heights).reshape(-1, 3) * _light(normals, view)[:, np.newaxis]
        shown, sky = colors, self._sky(view)
        if sky is not None:
            seen = places @ view.axes.T - view.center
            shown = np.where(solid, colors, sky.reflected(colors, normals, seen, view.distance))
        shine = 255.0 * self._style.gloss * _shine(normals)[:, np.newaxis]
        self._add(canvas, view, places, np.where(solid, shown, shown + shine), self._faces)
        for side in self._sides:
            edge = places[side]
            outward = np.cross(edge[-1] - edge[0], (0.0, 0.0, 1.0))
            if outward @ view.axes[2] > 0.0:
                self._add(canvas, view, *self._side(edge, colors[side]))

    def record(self, tape: Tape, frame: SourceFrame, view: View, pixels: float) -> None:
        """Put the surface and all sides of the block on a tape; the page lights them."""
        del pixels
        heights = self._heights(frame)
        places = np.concatenate([self._plane, heights[..., np.newaxis]], axis=-1).reshape(-1, 3)
        colors = self._colors(heights).reshape(-1, 3)
        tape.surface(places, self._faces, colors, closed=False, back=None, sky=self._sky(view))
        for side in self._sides:
            points, shades, faces = self._side(places[side], colors[side])
            tape.surface(points, faces, shades, closed=True, back=None)

    def _colors(self, heights: FloatArray) -> FloatArray:
        """The colors at the nodes of the mesh, without light."""
        share = 0.5 + 0.5 * heights / self._height if self.signed else heights / self._height
        scale = look_up(self._table, np.clip(share, 0.0, 1.0))
        colors: FloatArray = np.where(self._is_solid[..., np.newaxis], self._solid, scale)
        return colors

    def _side(self, edge: FloatArray, colors: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
        """A side of the block, below an edge (N, 3) of the surface with colors (N, 3): points, colors, triangles."""
        count = len(edge)
        feet = edge.copy()
        feet[:, 2] = self._floor
        above = np.arange(count - 1)
        below = above + count
        faces = np.concatenate(
            [np.stack(each, -1) for each in ((above, above + 1, below), (above + 1, below + 1, below))]
        )
        background = np.array(self._theme.background, dtype=float)
        shades = np.concatenate([SHADE * colors + 0.1 * background, 0.35 * SHADE * colors + 0.6 * background])
        return np.concatenate([edge, feet]), shades, faces

    def _add(self, canvas: Canvas, view: View, places: FloatArray, colors: FloatArray, faces: IntArray) -> None:
        """Queue triangles between points (N, 3), with a color (N, 3) at each."""
        points, depth, _ = view.project(places)
        assert depth is not None  # views in 3D have depths
        ink = inks(np.clip(colors, 0.0, 255.0), self._theme, 0.5 * view.farness(depth))
        canvas.triangles(
            np.ascontiguousarray(points[faces].reshape(-1, 6)),
            np.ascontiguousarray(ink[faces].reshape(-1, 12)),
            np.ascontiguousarray(depth[faces]),
        )

    def _heights(self, frame: SourceFrame) -> FloatArray:
        """The heights at the nodes of the mesh [m]."""
        along, across = self._weights
        heights: FloatArray = (self._height / self.top) * (along @ self.values(frame) @ across.T)
        return np.where(self._is_solid, 0.0, heights)

    def _normals(self, heights: FloatArray, view: View) -> FloatArray:
        """The unit normals (N, 3) at the nodes of the mesh, along the axes of the camera."""
        steps = self._sizes / np.array(self._squares)
        slopes = np.gradient(heights, *steps.tolist())
        normals = np.stack([-slopes[0], -slopes[1], np.ones_like(heights)], axis=-1).reshape(-1, 3)
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        return np.ascontiguousarray(normals @ view.axes.T)

    def _sky(self, view: View) -> Sky | None:
        """The sky that the surface reflects; None: it reflects none."""
        return sky_above(view.axes, self._mirror) if self._mirror > 0.0 else None

    @cached_property
    def _squares(self) -> tuple[int, int]:
        """The number of squares of the mesh along x and y."""
        share = MESH / float(self._sizes.max())
        across, along = (max(2, round(size * share)) for size in self._sizes.tolist())
        return across, along

    @cached_property
    def _plane(self) -> FloatArray:
        """The nodes of the mesh in the plane [m], shape (m + 1, n + 1, 2)."""
        axes = [
            np.linspace(low, high, count + 1)
            for low, high, count in zip(self._grid.origin, self._grid.upper, self._squares, strict=True)
        ]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)

    @cached_property
    def _weights(self) -> tuple[FloatArray, FloatArray]:
        """The interpolation weights from cells to the nodes of the mesh, along x and y."""
        along, across = (
            cubic(cells, np.linspace(0.0, cells, squares + 1) - 0.5, width=cells / squares)
            for cells, squares in zip(self._grid.cells, self._squares, strict=True)
        )
        return along, across

    @cached_property
    def _is_solid(self) -> BoolArray:
        """Mask of the nodes of the mesh that are in walls."""
        if self._system.solid is None:
            return np.zeros([count + 1 for count in self._squares], dtype=bool)
        along, across = self._weights
        solid: BoolArray = along @ self._system.solid.astype(float) @ across.T > 0.5
        return solid

    @cached_property
    def _faces(self) -> IntArray:
        """The triangles of the mesh, as indices of nodes."""
        index = np.arange(self._is_solid.size).reshape(self._is_solid.shape)
        a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
        return np.concatenate([np.stack(each, -1).reshape(-1, 3) for each in ((a, b, c), (a, c, d))])

    @cached_property
    def _sides(self) -> list[IntArray]:
        """The nodes of the mesh along each edge, counterclockwise, so that the block is on the left."""
        index = np.arange(self._is_solid.size).reshape(self._is_solid.shape)
        return [index[:, 0], index[-1, :], index[::-1, -1], index[0, ::-1]]


def _light(normals: FloatArray, view: View) -> FloatArray:
    """The diffuse light (N,) on a surface with unit normals (N, 3). It is 1 on level ground, where colors are those of
    the scale.
    """
    level = max(float(view.axes[:, 2] @ LAMP), 0.1)
    light: FloatArray = AMBIENT + (1.0 - AMBIENT) * np.maximum(normals @ LAMP, 0.0) / level
    return light


def _shine(normals: FloatArray) -> FloatArray:
    """The specular reflection (N,) of the lamp on a surface with unit normals (N, 3)."""
    halfway = np.array(LAMP) + np.array([0.0, 0.0, 1.0])
    halfway /= np.linalg.norm(halfway)
    shine: FloatArray = np.maximum(normals @ halfway, 0.0) ** SHARPNESS
    return shine
