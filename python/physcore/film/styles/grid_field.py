"""Fields on grids as color maps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from physcore._core import Canvas, Texture, coverage, heatmap
from physcore.checks import FloatArray, number, shown, text
from physcore.errors import SceneError
from physcore.film.camera.view import View
from physcore.film.colors.colormaps import FINE, STEPS, ColormapName, ramp, sequential, spread, two_sided
from physcore.film.colors.themes import Theme, mixed
from physcore.film.looks.base import lines
from physcore.film.looks.box import draw_edges
from physcore.film.page.tape import Tape, opaque
from physcore.film.shapes.box import corners
from physcore.film.styles.base import Painter, Scale, SystemPart, SystemStyle
from physcore.film.styles.typical import TYPICAL, Range, Typical
from physcore.scene.grid import GridSystem
from physcore.scene.system import System
from physcore.simulation.sources import Source, SourceFrame

LOUDEST = 0.2
"""Fraction of frames that may exceed the end of the scale, as with a pulse at the start; frames without motion do not
count.
"""
LOUD = 0.35
"""Least end of the scale, as a fraction of the typical value in the frame with the largest."""
SOFT = 0.75
"""Exponent of values in the color scale, so that weak waves are visible beside strong ones."""
NEVER = 1e-300
"""End of the scale if all values are zero."""
SHOWN = slice(FINE // STEPS // 2, None, FINE // STEPS)
"""The colors of a color bar."""
SLICES = 24
"""Number of pieces along each side of a slice in 3D; each piece is nearly free of perspective distortion."""
DETAIL = 3
"""Pixels of a slice per cell and side; the picture has at most LARGEST along a side."""
LARGEST = 1024
LEVELS = 255
"""Number of values of a field on a page, an odd one: zero is in the middle of a scale with both signs."""
MOST = 320
"""Largest number of cells along a side of a field on a page."""


@dataclass(frozen=True)
class Field(SystemStyle):
    """Field on a grid as a color map. Colors start from the theme's background at zero.

    Values are interpolated cubically between cell centers, or averaged if a pixel contains several cells. The color
    scale is the same for the whole film and ends at a typical value of its frames. Walls are drawn as solids. In 3D, a
    slice through the middle of the grid is shown, normal to y.

        pc.film(recording, "waves.gif", style=pc.styles.Field(contours=6))

    Args:
        quantity: the name of the field; None: the first field of the system.
        colormap: "viridis", "inferno", …, or a map of Matplotlib, such as "RdBu_r". None: for signed quantities, cold
            and warm colors that start from the background; for others "magma".
        range: the value at the end of the scale, or both ends. A single value gives a scale that is symmetric about
            zero
            for signed quantities and begins at zero for others. None: a typical value of the film.
        contours: number of intervals between contour lines on each side of zero; None: no lines.
        relief: strength of shading as of a surface lit from the upper left, 0 to 1.
        on: the system or systems drawn in this style; None: all with fields on a grid in 2D or 3D.

    Raises:
        SceneError: a value is not valid, or the quantity was not recorded.
    """

    quantity: str | None = None
    colormap: ColormapName | None = None
    range: float | tuple[float, float] | None = None
    contours: int | None = None
    relief: float = 0.0

    dimensions: ClassVar[tuple[int, ...]] = (2, 3)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.quantity is not None:
            text(self.quantity, "Field.quantity")
        if self.colormap is not None:
            sequential(self.colormap, (0.0, 1.0), "Field.colormap")
        if isinstance(self.range, (tuple, list)):
            ends = [number(each, "Field.range") for each in self.range]
            if len(ends) != 2 or not ends[0] < ends[1]:
                raise SceneError(f"Field.range: must be two numbers, the smaller one first, got {shown(self.range)}")
            self._set(range=tuple(ends))
        else:
            self._set_positive("range")
        if self.contours is not None:
            self._set(contours=int(number(self.contours, "Field.contours", least=1.0, most=100.0)))
        self._set(relief=number(self.relief, "Field.relief", least=0.0, most=1.0))

    def can_draw(self, item: System) -> bool:
        """Whether an item is on a grid in 2D or 3D."""
        return "cells" in item.elements and item.dimension in self.dimensions

    def painter(self, source: Source, part: SystemPart, theme: Theme) -> Painter:
        """The painter with the color scale of one film."""
        if not self.can_draw(part.system):
            raise SceneError(f"Field.on: {part.system!r} has no field on a grid in 2D or 3D; use Line() in 1D")
        return FieldPainter(self, source, part, theme)


class GridPainter(Painter):
    """Base class of painters of fields on grids: the quantity, and its range over the film."""

    def __init__(
        self, style: SystemStyle, quantity: str | None, source: Source, part: SystemPart, theme: Theme, path: str
    ) -> None:
        system = cast("GridSystem", part.system)  # the style has checked this
        self.style, self._system, self._grid, self._theme = style, system, system.grid, theme
        units = system.units
        self.quantity = next(iter(units)) if quantity is None else quantity
        if self.quantity not in units:
            raise SceneError(f"{path}.quantity: must be one of {', '.join(units)}, got {self.quantity!r}")
        self.unit, self._field = system.unit(self.quantity), f"{part.path}.{self.quantity}"
        self._suffix = source.scene.units.suffix(self.unit)
        if not source.has(self._field):
            raise SceneError(f"{path}.quantity: {self._field} was not recorded; record it: channels=({self._field!r},)")
        self._typical = self.typical()

    def typical(self) -> Typical:
        """The estimator for the end of the scale."""
        return Typical(TYPICAL, LOUDEST, LOUD)

    @property
    def signed(self) -> bool:
        """Whether the quantity has both signs."""
        return self._system.signed or self.quantity != next(iter(self._system.units))

    def values(self, frame: SourceFrame) -> FloatArray:
        """The values of a frame, in the shape of the grid."""
        return frame.fields[self._field]

    def observe_range(self, frame: SourceFrame) -> None:
        """Update the end of the scale by a frame, unless all values are zero."""
        values = self.values(frame)
        if values.any():
            self.top = self._typical.add(np.abs(values).ravel())

    def _paint_edges(self, canvas: Canvas, view: View) -> None:
        """Queue the sides of the grid that are shut."""
        ends = np.array([self._grid.origin, self._grid.upper])
        (left, bottom), (right, top) = view.project(ends)[0].astype(float).tolist()
        box = np.array([[left, bottom, left, top], [right, bottom, right, top], [left, bottom, right, bottom],
                        [left, top, right, top]], dtype=np.float32)  # fmt: skip
        shut = box[np.array(self._system.shut)].reshape(-1, 2, 2)
        if len(shut):
            lines(canvas, shut, self._theme.edge, 1.0)


class FieldPainter(GridPainter):
    """Painter of a field as a color map, with its walls and edges."""

    def __init__(self, style: Field, source: Source, part: SystemPart, theme: Theme) -> None:
        super().__init__(style, style.quantity, source, part, theme, "Field")
        self._style = style
        given = style.range
        self._range = Range() if self._system.ranged and given is None else None
        self._given = ((-given if self.signed else 0.0), given) if isinstance(given, float) else given
        self.top = self._given[1] if self._given is not None else NEVER
        self._two_sided = self.signed
        self._table, self._colors = self._tables()
        solid = self._system.solid
        self._walls = None if solid is None else np.ascontiguousarray(solid, dtype=np.float64)

        self._covered: tuple[object, NDArray[np.uint8]] | None = None
        """The share of each pixel covered by walls, cached for the view of the last frame."""

    def _tables(self) -> tuple[FloatArray, NDArray[np.uint8]]:
        """The colors of the scale, exact and rounded."""
        if self._style.colormap is None and self.signed:
            table = two_sided(self._theme.background)
        else:
            table = ramp(self._style.colormap, "magma", self._theme.part, "Field.colormap")
        linear = self._given is not None or (self._range is not None and not self.signed)
        table = spread(table, 1.0 if linear else SOFT, middle=self.signed)
        return table, np.ascontiguousarray(np.round(table).astype(np.uint8))

    @property
    def signed(self) -> bool:
        """Whether the scale has zero within."""
        if self._range is not None:
            return self._range.signed
        if self._system.ranged and isinstance(self._style.range, tuple):
            low, high = self._style.range
            return low < 0.0 < high
        return super().signed

    @property
    def ends(self) -> tuple[float, float]:
        """The values at both ends of the color scale."""
        if self._range is not None:
            return self._range.ends
        return self._given or ((-self.top if self.signed else 0.0), self.top)

    @property
    def scale(self) -> Scale | None:
        """The color scale; None if all values are zero."""
        return None if self.top == NEVER else Scale(self.quantity, self.unit, self.ends, self._table[SHOWN])

    @property
    def settled(self) -> bool:
        """Whether the ends of the scale were given."""
        return self._given is not None

    @property
    def landmarks(self) -> FloatArray:
        """The corners of the grid."""
        return corners(np.array(self._grid.origin), np.array(self._grid.upper))

    def observe(self, frame: SourceFrame) -> None:
        """Update the ends of the scale by a frame."""
        if self._range is not None:
            self._range.add(self.values(frame).ravel())
            self.top = self._range.ends[1]
            if self.signed != self._two_sided:
                self._two_sided = self.signed
                self._table, self._colors = self._tables()
        elif self._given is None:
            self.observe_range(frame)

    def inset(self, pixels: float) -> float:
        """Half the width of the edges."""
        del pixels
        return 1.0

    def paint(self, canvas: Canvas, frame: SourceFrame, view: View, pixels: float) -> None:
        """Draw the picture immediately, behind all queued objects; in 3D, queue a slice."""
        del pixels
        if view.flat:
            self._paint_plane(canvas, self.values(frame), view)
        else:
            self._paint_slice(canvas, self.values(frame), view)

    def record(self, tape: Tape, frame: SourceFrame, view: View, pixels: float) -> None:
        """Put the values on a tape: all of them in 2D, the slice in 3D."""
        del pixels
        values, walls, style = self.values(frame), self._walls, self._style
        low, high = np.array(self._grid.origin), np.array(self._grid.upper)
        outline, canvas = corners(low, high)[[0, 2, 3, 1]], cast("Canvas", tape)
        if not view.flat:
            middle = values.shape[1] // 2
            values, walls = values[:, middle], None if walls is None else walls[:, middle]
            outline = corners(low, high)[[0, 4, 5, 1]] * (1.0, 0.0, 1.0) + 0.5 * (low + high) * (0.0, 1.0, 0.0)
        first, last = self.ends
        shares = np.nan_to_num((coarser(values) - first) / (last - first), nan=0.5)
        levels = np.linspace(0.0, len(self._colors) - 1.0, LEVELS).round().astype(int)
        tape.grid(
            np.round(np.clip(shares, 0.0, 1.0) * (LEVELS - 1)).astype(np.uint8), outline,
            table=opaque(self._colors[levels]), contours=(style.contours or 0) * (2 if self.signed else 1),
            ink=[*self._theme.text], relief=style.relief, zero=-first / (last - first),
            walls=None if walls is None else np.round(255.0 * coarser(walls)).astype(np.uint8).T,
            wall=[*mixed(self._theme.solid, self._theme.background, 0.35)],
        )  # fmt: skip
        if not view.flat:
            draw_edges(canvas, low, high, view, self._theme, front=False, thin=True)
        else:
            self._paint_edges(canvas, view)

    def _picture(
        self,
        values: FloatArray,
        walls: FloatArray | None,
        size: tuple[int, int],
        corner: tuple[float, float],
        step: float,
    ) -> np.ndarray:
        """The pixels (H, W, 3) of values (nx, ny)."""
        style, theme = self._style, self._theme
        low, high = self.ends
        isolines = None
        if style.contours is not None:
            isolines = ((high - low) / (2.0 if self.signed else 1.0) / style.contours, (*theme.text, 150))
        masked = None
        if walls is not None:
            if self._covered is None or self._covered[0] != (size, corner, step):
                self._covered = (size, corner, step), coverage(walls, size, corner, step)
            masked = self._covered[1], mixed(theme.solid, theme.background, 0.35)
        return heatmap(
            np.ascontiguousarray(values), size, corner, step, self._colors, (low, high), masked, isolines, style.relief
        )

    def _paint_plane(self, canvas: Canvas, values: FloatArray, view: View) -> None:
        """Draw the visible part of the grid: all pixels whose centers are on it."""
        ends = np.array([self._grid.origin, self._grid.upper])
        (left, bottom), (right, top) = view.project(ends)[0].astype(float).tolist()
        # Bounds of the canvas, from the middle of the panel: it begins at pixel 0.
        width, height = (2.0 * view.middle[axis] + 1.0 for axis in (0, 1))
        first, last = max(math.ceil(left - 0.5), 0), min(math.ceil(right - 0.5), math.ceil(width))
        upper, lower = max(math.ceil(top - 0.5), 0), min(math.ceil(bottom - 0.5), math.ceil(height) + 64)
        if first >= last or upper >= lower:
            return
        cells = 1.0 / (view.scale * self._grid.spacing)
        corner = (first + 0.5 - left) * cells - 0.5, (bottom - upper - 0.5) * cells - 0.5
        size = last - first, lower - upper
        canvas.picture(self._picture(values, self._walls, size, corner, cells), first, upper)
        self._paint_edges(canvas, view)

    def _paint_slice(self, canvas: Canvas, values: FloatArray, view: View) -> None:
        """Queue the values in the middle of y, as a picture on a rectangle in 3D."""
        grid = self._grid
        middle = grid.cells[1] // 2
        values, walls = values[:, middle], None if self._walls is None else np.ascontiguousarray(self._walls[:, middle])
        step = max(1.0 / DETAIL, max(values.shape) / LARGEST)
        size = max(1, round(values.shape[0] / step)), max(1, round(values.shape[1] / step))
        corner = 0.5 * step - 0.5, values.shape[1] - 0.5 - 0.5 * step
        picture = self._picture(values, walls, size, corner, step)
        low, high = np.array(grid.origin), np.array(grid.upper)
        marks = np.linspace(0.0, 1.0, SLICES + 1)
        u, v = np.meshgrid(marks, marks, indexing="ij")
        places = np.stack([u, np.full_like(u, 0.5), v], axis=-1) * (high - low) + low
        points, depth, _ = view.project(places.reshape(-1, 3))
        corner_of = np.arange(u.size).reshape(u.shape)
        a, b, c, d = corner_of[:-1, :-1], corner_of[1:, :-1], corner_of[1:, 1:], corner_of[:-1, 1:]
        faces = np.concatenate([np.stack(each, -1).reshape(-1, 3) for each in ((a, b, c), (a, c, d))])
        draw_edges(canvas, low, high, view, self._theme, front=False, thin=True)
        canvas.triangles(
            points[faces].reshape(-1, 6),
            np.full((len(faces), 12), 255, dtype=np.uint8),
            None if depth is None else depth[faces].mean(axis=1, keepdims=True),
            Texture(picture),
            np.stack([u, v], -1).reshape(-1, 2)[faces].reshape(-1, 6).astype(np.float32),
        )
        draw_edges(canvas, low, high, view, self._theme, front=True, thin=True)


def coarser(values: FloatArray) -> FloatArray:
    """The values (nx, ny) of a grid; means of blocks if there are more than MOST along a side."""
    size = -(-max(values.shape) // MOST)
    if size == 1:
        return values
    padded = np.pad(values, [(0, -count % size) for count in values.shape], mode="edge")
    blocks = padded.reshape(padded.shape[0] // size, size, padded.shape[1] // size, size)
    means: FloatArray = blocks.mean(axis=(1, 3))
    return means
