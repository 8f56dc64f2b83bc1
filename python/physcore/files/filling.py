"""Tetrahedra that fill a closed mesh."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Protocol

import numpy as np

from physcore.arithmetic import dots
from physcore.checks import BoolArray, FloatArray, IntArray
from physcore.errors import PhyscoreError
from physcore.scene.shapes import block

CLEAR = 0.4
"""Least distance of the points of the lattice from vertices, in spacings."""
SLIVER = 1e-9
"""Least volume of a tetrahedron, in units of the cube of the root of its mean squared edge; above rounding errors."""


class Closed(Protocol):
    """Closed mesh."""

    @property
    def vertices(self) -> FloatArray:
        """Vertices [m], shape (K, 3)."""

    def contains(self, points: FloatArray) -> BoolArray:
        """Whether each point (N, 3) is within."""


def tetrahedra(mesh: Closed, spacing: float, path: str) -> tuple[FloatArray, IntArray]:
    """Points (N, 3) [m], the first of which are the vertices, and the corners (C, 4) of tetrahedra within a mesh.

    The other points are those of a body-centered cubic lattice, whose Delaunay tetrahedra are all of one form.

    Raises:
        PhyscoreError: scipy is not installed.
    """
    if not find_spec("scipy"):
        raise PhyscoreError(f"{path}: needs scipy: pip install 'physcore[files]'")
    from scipy.spatial import Delaunay, cKDTree

    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    corners = block(low, np.maximum(high, low + spacing) + spacing, spacing)
    lattice = np.concatenate([corners, corners + 0.5 * spacing])
    lattice = lattice[mesh.contains(lattice)]
    if len(lattice):
        lattice = lattice[cKDTree(mesh.vertices).query(lattice)[0] > CLEAR * spacing]
    points = np.concatenate([mesh.vertices, lattice])
    found = np.array(Delaunay(points).simplices, dtype=np.int64)
    found = found[mesh.contains(points[found].mean(axis=1))]
    sides = points[found[:, 1:]] - points[found[:, :1]]
    volumes = np.abs(dots(sides[:, 0], np.cross(sides[:, 1], sides[:, 2]))) / 6.0
    square = np.square(sides).sum(axis=2).mean(axis=1)
    size = square * np.sqrt(square)
    return points, found[volumes > SLIVER * size]
