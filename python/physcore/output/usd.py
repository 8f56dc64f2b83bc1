"""Universal Scene Description as text (.usda): surfaces that move, for Blender, Houdini and others.

Source: Pixar, "Usda file format", https://openusd.org/release/spec_usda.html.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import IO, ClassVar, cast

import numpy as np

from physcore.checks import FloatArray, IntArray
from physcore.output.base import ExportJob, Sample
from physcore.output.surfaces import SurfaceWriter, liquid_surface, solid_surface
from physcore.scene.bodies import Body
from physcore.scene.fluid import Fluid
from physcore.scene.rigid import RigidBodies
from physcore.scene.rotations import spatial_rotations
from physcore.storage.files import replacing

ROOT = "physcore"
"""Name of the prim that contains all others."""


class UsdWriter(SurfaceWriter):
    """Writer of USD.

    Time codes are numbers of frames. Surfaces of springs and of liquids are meshes with points, and of liquids faces,
    for each. Rigid bodies are instances of one mesh that move and turn.
    """

    suffixes: ClassVar = (".usda",)

    def write_surfaces(self, job: ExportJob, target: Path) -> None:
        """Write all frames: the values of each attribute into a temporary file, and then all of these in turn."""
        with replacing(target) as file, ExitStack() as files:
            folder, names = target.absolute().parent, _identifiers(list(job.surfaces))
            prims = [
                _prim(job, name, label, body, rows, files, folder)
                for name, (label, (body, rows)) in zip(names, job.surfaces.items(), strict=True)
            ]
            for sample in job.samples():
                for prim in prims:
                    prim.put(sample)
            for text in _head(job):
                file.write(text.encode())
            for prim in prims:
                prim.finish(file)
            file.write(b"}\n")


class _Attribute:
    """The values of an attribute over time."""

    def __init__(self, kind: str, name: str, files: ExitStack, folder: Path) -> None:
        self._declared = f"{kind} {name}.timeSamples"
        values = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 - closed by `files`
        self._values: IO[bytes] = files.enter_context(values)

    def put(self, time: int, value: str) -> None:
        """Add the value at a time."""
        self._values.write(f"        {time}: {value},\n".encode())

    def copy_to(self, file: IO[bytes]) -> None:
        """Write the attribute."""
        file.write(f"        {self._declared} = {{\n".encode())
        self._values.seek(0)
        shutil.copyfileobj(self._values, file)
        file.write(b"        }\n")


class _Mesh:
    """A mesh in a file."""

    def __init__(self, name: str, label: str, rows: slice, files: ExitStack, folder: Path) -> None:
        self._name, self._label, self._rows = name, label, rows
        self._points = _Attribute("point3f[]", "points", files, folder)

    def put(self, sample: Sample) -> None:
        """Add a frame."""
        self._points.put(sample.index, _tuples(sample.positions[self._rows]))

    def finish(self, file: IO[bytes]) -> None:
        """Write the mesh."""
        file.write(
            f'    def Mesh "{self._name}" (\n        displayName = {_quoted(self._label)}\n    )\n    {{\n'.encode()
        )
        file.write(b'        uniform token subdivisionScheme = "none"\n        bool doubleSided = 1\n')
        self._points.copy_to(file)
        self._finish_faces(file)
        file.write(b"    }\n")

    def _finish_faces(self, file: IO[bytes]) -> None:
        """Write the faces."""
        raise NotImplementedError


class _Sheet(_Mesh):
    """A surface of springs, whose faces are the same in all frames."""

    def __init__(self, name: str, label: str, rows: slice, files: ExitStack, folder: Path, faces: IntArray) -> None:
        super().__init__(name, label, rows, files, folder)
        self._faces = faces

    def _finish_faces(self, file: IO[bytes]) -> None:
        counts, indices = _faces_of(self._faces)
        file.write(f"        int[] faceVertexCounts = {counts}\n        int[] faceVertexIndices = {indices}\n".encode())


class _Liquid(_Mesh):
    """The surface of a liquid."""

    def __init__(self, name: str, label: str, rows: slice, files: ExitStack, folder: Path, spacing: float) -> None:
        super().__init__(name, label, rows, files, folder)
        self._spacing = spacing
        self._counts = _Attribute("int[]", "faceVertexCounts", files, folder)
        self._indices = _Attribute("int[]", "faceVertexIndices", files, folder)

    def put(self, sample: Sample) -> None:
        """Add a frame."""
        surface = liquid_surface(sample.positions[self._rows], self._spacing)
        counts, indices = _faces_of(surface.faces)
        self._points.put(sample.index, _tuples(surface.points))
        self._counts.put(sample.index, counts)
        self._indices.put(sample.index, indices)

    def _finish_faces(self, file: IO[bytes]) -> None:
        self._counts.copy_to(file)
        self._indices.copy_to(file)


class _Solids:
    """Rigid bodies of one shape in a file."""

    def __init__(
        self, name: str, label: str, rows: slice, files: ExitStack, folder: Path, body: RigidBodies, scale: float
    ) -> None:
        self._name, self._label, self._rows, self._body, self._scale = name, label, rows, body, scale
        self._places = [_Attribute("matrix4d", "xformOp:transform", files, folder) for _ in range(len(body))]

    def put(self, sample: Sample) -> None:
        """Add a frame."""
        places, turns = sample.positions[self._rows], sample.turns["orientation"][self._rows]
        for attribute, place, matrix in zip(self._places, places, spatial_rotations(turns), strict=True):
            # Vectors are rows, which a matrix transforms from the right.
            whole = np.concatenate([np.pad(matrix.T, ((0, 0), (0, 1))), [[*place, 1.0]]])
            attribute.put(sample.index, f"({', '.join(map(_tuple, whole.tolist()))})")

    def finish(self, file: IO[bytes]) -> None:
        """Write the shape as a class, and the bodies that inherit it."""
        solid = solid_surface(self._body, self._scale)
        counts, indices = _faces_of(solid.faces)
        file.write(
            f'    class Xform "{self._name}_shape"\n    {{\n        def Mesh "mesh"\n        {{\n'
            '            uniform token subdivisionScheme = "none"\n'
            f"            point3f[] points = {_tuples(solid.points)}\n"
            f"            normal3f[] normals = {_tuples(solid.normals)} (\n"
            '                interpolation = "vertex"\n            )\n'
            f"            int[] faceVertexCounts = {counts}\n            int[] faceVertexIndices = {indices}\n"
            "        }\n    }\n".encode()
        )
        for index, attribute in enumerate(self._places):
            name, label = (self._name, self._label) if len(self._places) == 1 else (
                f"{self._name}_{index}", f"{self._label} {index}"
            )  # fmt: skip
            file.write(
                f'    def Xform "{name}" (\n        displayName = {_quoted(label)}\n'
                f"        inherits = </{ROOT}/{self._name}_shape>\n    )\n    {{\n".encode()
            )
            attribute.copy_to(file)
            file.write(b'        uniform token[] xformOpOrder = ["xformOp:transform"]\n    }\n')


def _prim(
    job: ExportJob, name: str, label: str, body: Body, rows: slice, files: ExitStack, folder: Path
) -> _Mesh | _Solids:
    """The prim of a body."""
    if body.is_rigid:
        return _Solids(name, label, rows, files, folder, cast("RigidBodies", body), job.length)
    if body.is_fluid:
        return _Liquid(name, label, rows, files, folder, job.length * cast("Fluid", body).spacing)
    assert body.network is not None  # other surfaces are rigid bodies or liquids
    return _Sheet(name, label, rows, files, folder, body.network.faces)


def _head(job: ExportJob) -> Iterator[str]:
    """The beginning of a file."""
    meter = 1.0 if job.units.is_dimensionless else job.units.convert(1.0, "m")
    yield f'#usda 1.0\n(\n    defaultPrim = "{ROOT}"\n    metersPerUnit = {1.0 / meter:.17g}\n'
    yield f'    upAxis = "{"Z" if job.dimension == 3 else "Y"}"\n    startTimeCode = 0\n'
    yield f"    endTimeCode = {job.count - 1}\n    timeCodesPerSecond = {job.rate:.17g}\n"
    yield f'    framesPerSecond = {job.rate:.17g}\n)\n\ndef Xform "{ROOT}"\n{{\n'


def _identifiers(labels: list[str]) -> list[str]:
    """Names of prims: letters, digits and underscores, each name once."""
    found: list[str] = []
    for label in labels:
        name = "".join(each if each.isascii() and each.isalnum() else "_" for each in label)
        name = f"_{name}" if not name or name[0].isdigit() else name
        taken = set(found)
        number = next(number for number in range(1, len(labels) + 1) if _numbered(name, number) not in taken)
        found.append(_numbered(name, number))
    return found


def _numbered(name: str, number: int) -> str:
    return name if number == 1 else f"{name}__{number}"


def _quoted(text: str) -> str:
    """A text as a string of a file."""
    plain = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{plain}"'


def _tuple(values: list[float]) -> str:
    return f"({', '.join(f'{value:.9g}' for value in values)})"


def _tuples(values: FloatArray) -> str:
    """Vectors (N, 3)."""
    return f"[{', '.join(map(_tuple, values.tolist()))}]"


def _faces_of(faces: IntArray) -> tuple[str, str]:
    """Numbers of corners of triangles (T, 3), and their indices."""
    return f"[{', '.join(['3'] * len(faces))}]", f"[{', '.join(map(str, faces.ravel().tolist()))}]"
