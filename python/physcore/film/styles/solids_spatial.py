"""Painting of rigid bodies in 3D: lit meshes."""

from __future__ import annotations

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.film.colors.light import lit
from physcore.film.colors.themes import Theme
from physcore.film.page.tape import Tape
from physcore.film.shapes.spatial import Mesh, core_of, mesh_of, reach_of
from physcore.film.styles.base import SHADING, inks
from physcore.scene.rotations import spatial_rotations
from physcore.scene.solids import Ball, Shape

STEP = 1.25
"""Ratio of the scales at which a mesh is made anew."""
SMALL = 4.0
"""Radius below which a ball is drawn without a mark [pixels]."""
ROUND = 1.0 / 0.94
"""Size of a polyhedron of 26 directions around a unit ball."""


class SpatialSolids:
    """Rigid bodies of one shape in 3D, all of whose points are placed at once."""

    def __init__(self, shape: Shape, theme: Theme, *, marks: bool) -> None:
        self.cores, self._shape, self._theme, self._marks = list(core_of(shape)), shape, theme, marks
        self.reach = reach_of(self.cores)
        self._meshes: tuple[float, Mesh] | None = None

    def extremes(self, positions: FloatArray, turns: FloatArray) -> FloatArray:
        """Points (K, 3) whose bounding box along any axes is about that of the bodies."""
        rotations, found = spatial_rotations(turns), []
        for points, radius in self.cores:
            centers = (points @ rotations.transpose(0, 2, 1) + positions[:, np.newaxis]).reshape(-1, 3)
            found.append((centers[:, np.newaxis] + radius * AROUND).reshape(-1, 3) if radius else centers)
        return np.concatenate(found)

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
        """Queue the bodies at positions (N, 3) with orientations (N, 4), in colors (N, 3); plain ones have no marks."""
        if isinstance(self._shape, Ball) and self._shape.radius * view.scale < SMALL:
            centers, depth, scale = view.project(positions)
            assert depth is not None  # views in 3D have depths
            ink = inks(colors, self._theme, view.farness(depth))
            canvas.discs(centers, (scale * self._shape.radius).astype(np.float32), ink, depth, SHADING)
            return
        mesh, rotations = self._mesh(view.scale), spatial_rotations(turns).transpose(0, 2, 1)
        points = mesh.points @ rotations + positions[:, np.newaxis]
        pixels, depth, _ = view.project(points.reshape(-1, 3))
        assert depth is not None  # views in 3D have depths
        starts = len(mesh.points) * np.arange(len(positions))
        corners = (starts[:, np.newaxis, np.newaxis] + mesh.triangles).reshape(-1, 3)
        first, second, third = (pixels[corners[:, k]] for k in range(3))
        along, across = (second - first).T, (third - first).T
        # The y axis of pixels points down: faces that are counterclockwise in the picture have a negative area.
        corners = corners[along[0] * across[1] < along[1] * across[0]]
        index = corners.ravel()
        normals = (mesh.normals @ (rotations @ view.axes.T)).reshape(-1, 3)[index]
        normals[:, 2] = np.maximum(normals[:, 2], 0.0)
        body, point = np.divmod(index, len(mesh.points))
        tones = np.ones(len(point)) if plain else mesh.tones[point]
        tinted = np.clip(colors[body] * tones[:, np.newaxis], 0.0, 255.0)
        ink = inks(lit(tinted, normals), self._theme, view.farness(depth[index]))
        canvas.triangles(
            np.ascontiguousarray(pixels[corners].reshape(-1, 6)),
            ink.reshape(-1, 12),
            np.ascontiguousarray(depth[corners]),
        )

    def record(
        self, tape: Tape, view: View, positions: FloatArray, turns: FloatArray, colors: FloatArray, *, plain: bool
    ) -> None:
        """Put the bodies on a tape, as one mesh with their places; arguments as of `paint`."""
        mesh = self._mesh(view.scale)
        tones = np.ones_like(mesh.tones) if plain else mesh.tones
        tape.solids(mesh.points, mesh.normals, tones, mesh.triangles, positions, spatial_rotations(turns), colors)

    def _mesh(self, scale: float) -> Mesh:
        """The mesh for a scale [pixels/m], which is kept while the scale changes little."""
        if self._meshes is None or not 1.0 / STEP < scale / self._meshes[0] < STEP:
            self._meshes = scale, mesh_of(self._shape, scale, self._marks)
        return self._meshes[1]


def _directions() -> FloatArray:
    """The directions (26, 3) of the faces, edges and corners of a cube: the corners of a polyhedron around a ball."""
    every = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)])
    result: FloatArray = ROUND * every / np.sqrt((every**2).sum(axis=1))[:, np.newaxis]
    return result


AROUND = _directions()
"""Points around a unit ball."""
