"""Painting of rigid bodies in 2D: filled shapes with a rim and a mark."""

from __future__ import annotations

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray, IntArray
from physcore.film.camera.view import PixelArray, View
from physcore.film.colors.themes import Theme
from physcore.film.shapes.parts import planar_rotations
from physcore.film.shapes.planar import Core, Face, cores_of, face_of, reach_of
from physcore.film.styles.base import inks
from physcore.scene.solids import Shape

RIM = (0.14, 0.8, 2.0)
"""Width of a rim relative to the reach of the shape; its least and largest width [pixels]."""
SMALL = 5.0
"""Reach below which a mark is a line, and a third of it below which there is none [pixels]."""
FILL, MARK, EDGE = 0.2, 0.34, 0.42
"""Shares of the background in the fill, of white in a mark, and of the color of text in a rim."""


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
            centers = _placed(core.vertices, positions, rotations).reshape(-1, 2)
            around = core.radius * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
            points.append((centers[:, np.newaxis] + around).reshape(-1, 2) if core.radius else centers)
        return np.concatenate(points)

    def paint(self, canvas: Canvas, view: View, positions: FloatArray, turns: FloatArray, colors: FloatArray) -> None:
        """Queue the bodies at positions (N, 2) with angles (N,), in colors (N, 3)."""
        theme, reach = self._theme, self.reach * view.scale
        share, least, most = RIM
        width = min(max(share * reach, least), most)
        fill = mixed_with(colors, theme.background, FILL)
        rim, mark = mixed_with(colors, theme.text, EDGE), mixed_with(fill, (255, 255, 255), MARK)
        rotations = planar_rotations(turns)
        if len(self.cores) == 1 and len(self.cores[0].vertices) < 3:
            self._paint_round(canvas, view, self.cores[0], (positions, rotations), (fill, rim), width)
        face = self._face(view.scale)
        places = view.project(_placed(face.points, positions, rotations).reshape(-1, 2))[0]
        starts = len(face.points) * np.arange(len(positions))
        if len(self.cores) > 1 or len(self.cores[0].vertices) > 2:
            _triangles(canvas, places, starts, face.triangles, fill, theme)
        if self._marks and reach > SMALL:
            _triangles(canvas, places, starts, face.painted, mark, theme)
        elif self._marks and reach > SMALL / 3.0:
            self._paint_spokes(canvas, view, positions, rotations, mark)
        if len(self.cores) > 1 or len(self.cores[0].vertices) > 2:
            ends = places[(starts[:, np.newaxis, np.newaxis] + face.rim)].reshape(-1, 4)
            ink = np.repeat(inks(rim, theme, None), len(face.rim), axis=0)
            canvas.lines(np.ascontiguousarray(ends), np.full(len(ends), width, dtype=np.float32), ink)

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
        centers = view.project(_placed(core.vertices, *places).reshape(-1, 2))[0]
        radius, (fill, rim) = core.radius * view.scale, colors
        for color, size in ((rim, radius + 0.5 * width), (fill, radius - 0.5 * width)):
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
    """Points (K, D) of a shape in the world, for bodies at positions (N, D) with rotations (N, D, D): (N, K, D)."""
    result: FloatArray = points @ rotations.transpose(0, 2, 1) + positions[:, np.newaxis]
    return result


def _triangles(
    canvas: Canvas, places: PixelArray, starts: IntArray, triangles: IntArray, colors: FloatArray, theme: Theme
) -> None:
    """Queue the triangles (T, 3) of each body, in its color."""
    corners = places[starts[:, np.newaxis, np.newaxis] + triangles].reshape(-1, 6)
    ink = np.repeat(np.tile(inks(colors, theme, None), 3), len(triangles), axis=0)
    canvas.triangles(np.ascontiguousarray(corners), np.ascontiguousarray(ink))
