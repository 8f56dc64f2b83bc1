"""Painting of rigid bodies in 2D: filled shapes with a rim and a mark."""

from __future__ import annotations

from typing import cast

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray, IntArray
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.colormaps import varied
from physcore.film.colors.themes import Theme
from physcore.film.page.tape import Tape
from physcore.film.shapes.planar import Core, Face, cores_of, face_of, reach_of
from physcore.film.styles.base import inks
from physcore.scene.rotations import planar_rotations
from physcore.scene.solids import Shape

RIM = (0.14, 0.8, 2.0)
"""Width of a rim relative to the reach of the shape; its least and largest width [pixels]."""
SMALL = 5.0
"""Reach below which a mark is a line, and half of it below which there is no mark and no rim [pixels]."""
FILL, MARK, EDGE = 0.22, 1.1, 0.42
"""Share of the background in a fill; lightness of a mark, as of `varied`; share of the color of text in a rim."""


class PlanarSolids:
    """Rigid bodies of one shape in 2D, all of whose vertices are placed at once."""

    def __init__(self, shape: Shape, theme: Theme, *, marks: bool) -> None:
        self.cores, self._theme, self._marks = cores_of(shape), theme, marks
        self.reach = reach_of(self.cores)
        self._faces: tuple[float, Face] | None = None

    def extremes(self, positions: FloatArray, turns: FloatArray) -> FloatArray:
        """Points (K, 2) whose bounding box is that of the bodies."""
        rotations = planar_rotations(turns)
        points = []
        for core in self.cores:
            centers = _placed(core.vertices, positions, rotations)
            around = core.radius * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
            points.append((centers[:, np.newaxis] + around).reshape(-1, 2) if core.radius else centers)
        return np.concatenate(points)

    def paint(
        self,
        canvas: Canvas,
        view: View,
        positions: FloatArray,
        turns: FloatArray,
        colors: FloatArray,
        *,
        plain: bool = False,
    ) -> None:
        """Queue the bodies at positions (N, 2) with angles (N,), in colors (N, 3); plain ones look like boundaries."""
        theme, reach = self._theme, self.reach * view.scale
        share, least, most = RIM
        width = min(max(share * reach, least), most)
        fill = colors if plain else mixed_with(colors, theme.background, FILL)
        rim = (
            np.tile(np.array(theme.edge, dtype=float), (len(colors), 1))
            if plain
            else mixed_with(colors, theme.text, EDGE)
        )
        places, round_ = (positions, planar_rotations(turns)), len(self.cores) == 1 and len(self.cores[0].vertices) < 3
        marked = self._marks and not plain and reach > SMALL / 2.0
        mark = varied(fill, np.full(len(fill), MARK)) if marked else fill
        if round_:
            self._paint_round(canvas, view, self.cores[0], places, (fill, rim), width)
        if (marked and reach > SMALL) or not round_:
            face = self._face(view.scale)
            points = view.project(_placed(face.points, *places))[0]
            starts = len(face.points) * np.arange(len(positions))
            if not round_:
                _triangles(canvas, points, starts, face.triangles, fill, theme)
            if marked and reach > SMALL:
                _triangles(canvas, points, starts, face.painted, mark, theme)
            if not round_ and reach > SMALL / 2.0:
                ends = points[starts[:, np.newaxis, np.newaxis] + face.rim].reshape(-1, 4)
                ink = np.repeat(inks(rim, theme, None), len(face.rim), axis=0)
                canvas.lines(np.ascontiguousarray(ends), np.full(len(ends), width, dtype=np.float32), ink)
        if marked and reach <= SMALL:
            self._paint_spokes(canvas, view, *places, mark)

    def record(
        self, tape: Tape, view: View, positions: FloatArray, turns: FloatArray, colors: FloatArray, *, plain: bool
    ) -> None:
        """Put the bodies on a tape, as they are painted."""
        self.paint(cast("Canvas", tape), view, positions, turns, colors, plain=plain)

    def _face(self, scale: float) -> Face:
        """The face at a scale [pixels/m], which is kept for the next frame."""
        if self._faces is None or self._faces[0] != scale:
            self._faces = scale, face_of(self.cores, scale)
        return self._faces[1]

    def _paint_round(
        self,
        canvas: Canvas,
        view: View,
        core: Core,
        places: tuple[FloatArray, FloatArray],
        colors: tuple[FloatArray, FloatArray],
        width: float,
    ) -> None:
        """Queue discs or capsules: the rim as a larger one below the fill."""
        centers = view.project(_placed(core.vertices, *places))[0]
        radius, (fill, rim) = core.radius * view.scale, colors
        sides = ((rim, radius + 0.5 * width), (fill, radius - 0.5 * width))
        for color, size in sides if radius > SMALL / 2.0 else ((colors[0], radius),):
            ink, sizes = inks(color, self._theme, None), np.full(len(color), size, dtype=np.float32)
            if len(core.vertices) == 1:
                canvas.discs(centers, sizes, ink)
            else:
                canvas.lines(centers.reshape(-1, 4), 2.0 * sizes, ink)

    def _paint_spokes(
        self, canvas: Canvas, view: View, positions: FloatArray, rotations: FloatArray, colors: FloatArray
    ) -> None:
        """Queue lines from the centers to the rims."""
        tips = positions + 0.85 * self.reach * rotations[:, :, 0]
        ends = np.concatenate([view.project(positions)[0], view.project(tips)[0]], axis=1)
        canvas.lines(ends, np.full(len(ends), 1.0, dtype=np.float32), inks(colors, self._theme, None))


def mixed_with(colors: FloatArray, other: tuple[int, int, int], share: float) -> FloatArray:
    """Colors (N, 3) with a share of another one."""
    result: FloatArray = colors + share * (np.array(other, dtype=float) - colors)
    return result


def _placed(points: FloatArray, positions: FloatArray, rotations: FloatArray) -> FloatArray:
    """Points (K, 2) of a shape in the world, for bodies at positions (N, 2) with rotations (N, 2, 2): (N · K, 2)."""
    result = np.empty((len(positions), len(points), 2))
    for axis in (0, 1):
        # A product of many small matrices by NumPy is several times slower.
        np.multiply(rotations[:, axis, :1], points[:, 0], out=result[..., axis])
        result[..., axis] += rotations[:, axis, 1:] * points[:, 1]
        result[..., axis] += positions[:, axis, np.newaxis]
    return result.reshape(-1, 2)


def _triangles(
    canvas: Canvas, places: PixelArray, starts: IntArray, triangles: IntArray, colors: FloatArray, theme: Theme
) -> None:
    """Queue the triangles (T, 3) of each body, in its color."""
    corners = places[starts[:, np.newaxis, np.newaxis] + triangles].reshape(-1, 6)
    ink = np.repeat(np.tile(inks(colors, theme, None), 3), len(triangles), axis=0)
    canvas.triangles(np.ascontiguousarray(corners), np.ascontiguousarray(ink))
