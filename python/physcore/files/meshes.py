"""Reading of meshes by trimesh, and conversion of meshes of other packages."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from physcore.checks import FloatArray, IntArray, array, regular, shown, word
from physcore.entrance import entrance
from physcore.errors import FileError, SceneError, SceneWarning, warn
from physcore.files.mesh import Mesh
from physcore.files.reader import Options, Reader, length_unit, reading, scale

UP = ("y", "z")
"""Axes that may point up in a file."""


class MeshReader(Reader):
    """Reader of meshes."""

    kind: ClassVar = "meshes"
    package: ClassVar = "trimesh"
    options: ClassVar = ("unit", "units", "up")
    suffixes: ClassVar = (".obj", ".stl", ".ply", ".off", ".glb", ".gltf")

    def read(self, path: Path, suffix: str, options: Options) -> Mesh:
        """All meshes of a file as one."""
        import trimesh

        with reading(path, "trimesh"):
            scene = trimesh.load_scene(path, file_type=suffix[1:], process=False)
            clouds = [each for each in scene.geometry.values() if not hasattr(each, "faces")]
            whole = scene.to_mesh() if scene.geometry else None
        if whole is None or not len(whole.faces):
            found = "it has points without faces; pc.Particles takes points" if clouds else "it is empty or damaged"
            raise FileError(f"{path}: has no triangles: {found}")
        is_gltf = suffix in (".glb", ".gltf")
        given = options.unit
        if given is None:
            given = "m" if is_gltf else getattr(whole, "units", None)
        if given is None:
            size = " × ".join(f"{extent:.4g}" for extent in np.ptp(whole.vertices, axis=0))
            raise SceneError(
                f'read.unit: {path} does not say in which unit its {size} are; write unit="mm", for example'
            )
        up = word("y" if is_gltf else "z", "read.up", UP) if options.up is None else word(options.up, "read.up", UP)
        factor = length_unit(given, "read.unit") * scale(options.units, "m")
        return _mesh(np.asarray(whole.vertices), np.asarray(whole.faces), factor, up, path.stem, str(path))


@entrance
def from_mesh(mesh: Any, *, unit: object = None, up: str = "z", name: str | None = None) -> Mesh:
    """A Mesh from one of trimesh, meshio or another package.

        import trimesh
        ball = pc.from_mesh(trimesh.creation.icosphere(radius=20.0), unit="mm")

    Vertices at one place are joined, as in `read`. Quadrilaterals of meshio become two triangles each; its other cells
    are left out.

    Args:
        mesh: an object with `vertices` and `faces`, as of trimesh, or with `points` and `cells_dict`, as of meshio.
        unit: unit of its lengths, as in `read`; None: that of the object if it has one, otherwise the meter, in which
            physcore takes all numbers.
        up: axis of the mesh that points up, "y" or "z".
        name: name of the mesh.

    Raises:
        SceneError: the object has no triangles, or a value is not valid.
    """
    points, faces = getattr(mesh, "vertices", None), getattr(mesh, "faces", None)
    if points is None or faces is None:
        points, faces = getattr(mesh, "points", None), _cells(mesh)
    if points is None or faces is None:
        raise SceneError(f"from_mesh.mesh: must have vertices and faces, or points and cells_dict, got {shown(mesh)}")
    given = getattr(mesh, "units", None) if unit is None else unit
    factor = 1.0 if given is None else length_unit(given, "from_mesh.unit")
    places, corners = array(points, "from_mesh.mesh: its vertices"), regular(faces, "from_mesh.mesh: its faces")
    if places.ndim == 2 and places.shape[1] == 2:
        places = np.pad(places, ((0, 0), (0, 1)))
    axis = word(up, "from_mesh.up", UP)
    return _mesh(places, corners, factor, axis, name, "from_mesh.mesh")


def _cells(mesh: Any) -> IntArray | None:
    """The triangles (T, 3) of a mesh of meshio."""
    cells = getattr(mesh, "cells_dict", None)
    if not isinstance(cells, dict):
        return None
    found = [cells["triangle"]] if "triangle" in cells else []
    if "quad" in cells:
        found += [cells["quad"][:, [0, 1, 2]], cells["quad"][:, [0, 2, 3]]]
    return np.concatenate(found) if found else np.empty((0, 3), dtype=np.int64)


def _mesh(vertices: FloatArray, faces: IntArray, factor: float, up: str, name: str | None, path: str) -> Mesh:
    """A mesh with z upward, whose vertices at one place are joined; with a warning if it is inside out.

    Raises:
        SceneError: there are no triangles, or a value is not valid.
    """
    corners = np.asarray(faces)
    if corners.dtype.kind not in "iu" or corners.ndim != 2 or corners.shape[1] != 3 or vertices.shape[1:] != (3,):
        raise SceneError(f"{path}: must have vertices (K, 3) and triangles (T, 3) of their indices")
    if corners.size and not 0 <= corners.min() <= corners.max() < len(vertices):
        raise SceneError(f"{path}: has a face with vertex {corners.max()}, and {len(vertices)} vertices")
    points = factor * np.asarray(vertices, dtype=np.float64)
    if up == "y":
        points = points[:, [0, 2, 1]] * (1.0, -1.0, 1.0)
    _, first, inverse = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)  # −0 is 0
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    triangles = rank[inverse.ravel()][corners]
    whole = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    if not whole.any():
        raise SceneError(f"{path}: has no triangle with three different corners")
    mesh = Mesh(points[first[order]], triangles[whole], name)
    if mesh.is_closed and mesh.volume < 0.0:
        warn(
            f"{path}: is inside out: its faces are clockwise as seen from outside, and are now turned over",
            SceneWarning,
        )
        return Mesh(mesh.vertices, mesh.faces[:, ::-1], name)
    if mesh.fault is not None and "faces meet" in mesh.fault:
        warn(f"{path}: {mesh.fault}; it can be a cloth, but no solid", SceneWarning)
    return mesh
