"""Ground below a height field as a closed solid."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray, IntArray
from physcore.scene.polytopes import MeshShape, Polygon


def ground_polygon(nodes: FloatArray, base: float) -> Polygon:
    """The polygon between nodes (nx, 2) and a base below them."""
    ends = [(float(nodes[-1, 0]), base), (float(nodes[0, 0]), base)]
    return Polygon(np.concatenate([nodes, ends]))


def ground_mesh(nodes: FloatArray, base: float) -> MeshShape:
    """The solid between nodes (nx, ny, 3) and a base below them."""
    rows, columns = nodes.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    top = _triangles(index, nodes[..., 2])
    bottom = _triangles(index, np.zeros((rows, columns)))[:, ::-1] + index.size
    rim = np.concatenate([index[:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1]])  # counterclockwise
    following = np.roll(rim, -1)
    sides = np.concatenate(
        [
            np.column_stack([rim, rim + index.size, following + index.size]),
            np.column_stack([rim, following + index.size, following]),
        ]
    )
    points = nodes.reshape(-1, 3)
    feet = np.column_stack([points[:, :2], np.full(len(points), base)])
    return MeshShape(np.concatenate([points, feet]), np.concatenate([top, bottom, sides]))


def _triangles(index: IntArray, heights: FloatArray) -> IntArray:
    """Two triangles (T, 3) of each cell, counterclockwise from above, which meet along its higher diagonal."""
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    level = heights.ravel()
    along = level[a] + level[c] >= level[b] + level[d]
    one = np.where(along[:, np.newaxis], np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    other = np.where(along[:, np.newaxis], np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    return np.concatenate([one, other])
