"""Rims of cloths with a thickness."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from physcore._core import Canvas
from physcore.checks import FloatArray, IntArray
from physcore.film.camera.view import View
from physcore.film.shapes.creases import sums
from physcore.scene.bodies import Body
from physcore.scene.scene import Scene

ENDS = (0, 1, 1, 0)
"""The end of a side to which each corner of its band belongs, in cyclic order."""


def thickness_of(body: Body, scene: Scene) -> float:
    """The thickness of a body in its SelfContact [m]; 0 without one."""
    return max((each.thickness_of(body) for each in scene.constraints), default=0.0)


def paint_rim(
    canvas: Canvas, positions: FloatArray, faces: IntArray, thickness: FloatArray, ink: NDArray[np.uint8], view: View
) -> None:
    """Queue a band along the boundary edges of a surface, as wide as the thickness [m], in the inks (N, 4) of the
    particles.
    """
    ends = _boundary(faces)
    if len(ends) == 0:
        return
    corners = positions[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = sums(faces.ravel(), np.repeat(across, 3, axis=0), len(positions))
    half = normals * (0.5 * thickness / np.maximum(np.linalg.norm(normals, axis=1), 1e-300))[:, np.newaxis]
    above, below = (view.project(positions + sign * half) for sign in (1.0, -1.0))
    first, second = ends.T
    places = [above[0][first], above[0][second], below[0][second], below[0][first]]
    assert above[1] is not None  # views in 3D have depths
    assert below[1] is not None
    depths = np.stack([above[1][first], above[1][second], below[1][second], below[1][first]], axis=1)
    for triangle in ((0, 1, 2), (0, 2, 3)):
        own = [ENDS[corner] for corner in triangle]
        canvas.triangles(
            np.ascontiguousarray(np.concatenate([places[corner] for corner in triangle], axis=1)),
            np.ascontiguousarray(ink[ends[:, own]].reshape(-1, 12)),
            np.ascontiguousarray(depths[:, triangle]),
            None,
            np.zeros((len(ends), 6), dtype=np.float32),
        )


def _boundary(faces: IntArray) -> IntArray:
    """The boundary edges (M, 2), which belong to one face only."""
    ends = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    sides, count = np.unique(ends, axis=0, return_counts=True)
    alone: IntArray = sides[count == 1]
    return alone
