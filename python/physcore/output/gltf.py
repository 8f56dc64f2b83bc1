"""glTF 2.0 as one binary file (.glb): surfaces that move, for Blender and others.

Source: The Khronos Group, "glTF 2.0 Specification", https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from abc import ABC, abstractmethod
from pathlib import Path
from typing import IO, Any, ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from physcore.checks import FloatArray
from physcore.errors import FileError
from physcore.output.base import ExportJob, Sample
from physcore.output.surfaces import SurfaceWriter, liquid_surface, solid_surface
from physcore.scene.bodies import Body
from physcore.scene.fluid import Fluid
from physcore.scene.rigid import RigidBodies
from physcore.simulation.provenance import version
from physcore.storage.files import replacing

UPRIGHT = (-(0.5**0.5), 0.0, 0.0, 0.5**0.5)
"""Quaternion (x, y, z, w) of the root node: z of a scene in 3D is y, which is up in glTF."""
FLOAT, INTEGER = 5126, 5125
"""Component types of glTF: float32 and uint32."""
TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
"""Types of accessors by the number of components."""
MOST = 2**32 - 2**20
"""Largest size of a file [bytes]; lengths have 32 bits."""


class GltfWriter(SurfaceWriter):
    """Writer of glTF.

    A surface of springs is a mesh with a morph target for each frame after the first one, which Blender reads as shape
    keys. Between frames vertices move in straight lines. Rigid bodies are nodes that move and turn. A fluid has a mesh
    for each frame, since its triangles change; each is shown in its frame alone. Lengths are meters, times seconds.
    """

    suffixes: ClassVar = (".glb",)

    def write_surfaces(self, job: ExportJob, target: Path) -> None:
        """Write all frames: the arrays into a temporary file, and then the file, which begins with their list."""
        with replacing(target) as file, tempfile.TemporaryFile(dir=target.absolute().parent) as arrays:
            asset = _Asset(arrays, upright=job.dimension == 3)
            surfaces = [_surface(asset, name, body, rows, job.length) for name, (body, rows) in job.surfaces.items()]
            times = []
            for sample in job.samples():
                times.append(sample.time)
                for surface in surfaces:
                    surface.put(sample)
            clock = asset.array(np.array(times), bounded=True)
            for surface in surfaces:
                surface.finish(clock, np.array(times))
            _assemble(file, asset, target)


class _Asset:
    """The content of a file: its arrays and its JSON."""

    def __init__(self, arrays: IO[bytes], *, upright: bool) -> None:
        self._arrays = arrays
        self.size = 0
        root: dict[str, Any] = {"name": "physcore", "children": []}
        if upright:
            root["rotation"] = UPRIGHT
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"physcore {version()}"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [root],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
            "materials": [{"doubleSided": True}],
            "animations": [{"name": "recording", "channels": [], "samplers": []}],
        }

    def array(self, values: NDArray[Any], *, bounded: bool = False) -> int:
        """Append an array (N,) or (N, K); the index of its accessor."""
        kind = "<u4" if values.dtype.kind in "iu" else "<f4"
        single = np.ascontiguousarray(values, dtype=kind)
        accessor = {
            "bufferView": len(self.json["bufferViews"]),
            "componentType": INTEGER if kind == "<u4" else FLOAT,
            "count": len(single),
            "type": TYPES[1 if single.ndim == 1 else single.shape[1]],
        }
        if bounded:
            rows = single.reshape(len(single), -1)
            accessor |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": self.size, "byteLength": single.nbytes})
        self._arrays.write(single.tobytes())
        self.size += single.nbytes
        self.json["accessors"].append(accessor)
        return len(self.json["accessors"]) - 1

    def copy_to(self, file: IO[bytes]) -> None:
        """Copy all arrays to a file."""
        self._arrays.seek(0)
        shutil.copyfileobj(self._arrays, file)

    def mesh(
        self, name: str, points: FloatArray, faces: NDArray[Any], normals: FloatArray | None = None
    ) -> dict[str, Any]:
        """Append a mesh; its entry in the JSON."""
        attributes = {"POSITION": self.array(points, bounded=True)}
        if normals is not None:
            attributes["NORMAL"] = self.array(normals)
        primitive = {"attributes": attributes, "indices": self.array(faces.ravel()), "material": 0}
        self.json["meshes"].append({"name": name, "primitives": [primitive]})
        return cast("dict[str, Any]", self.json["meshes"][-1])

    def node(self, name: str) -> int:
        """Append a node with the last mesh; its index."""
        nodes = self.json["nodes"]
        nodes.append({"name": name, "mesh": len(self.json["meshes"]) - 1})
        nodes[0]["children"].append(len(nodes) - 1)
        return len(nodes) - 1

    def animate(self, node: int, path: str, clock: int, values: NDArray[Any], interpolation: str = "LINEAR") -> None:
        """Append an animation of a property of a node."""
        animation = self.json["animations"][0]
        animation["channels"].append({"sampler": len(animation["samplers"]), "target": {"node": node, "path": path}})
        animation["samplers"].append({"input": clock, "output": self.array(values), "interpolation": interpolation})


class _Surface(ABC):
    """A body in a file, with the factor from lengths of the scene to those of the file."""

    def __init__(self, asset: _Asset, name: str, body: Body, rows: slice, scale: float) -> None:
        self._asset, self._name, self._body, self._rows, self._scale = asset, name, body, rows, scale

    @abstractmethod
    def put(self, sample: Sample) -> None:
        """Add a frame."""

    @abstractmethod
    def finish(self, clock: int, times: FloatArray) -> None:
        """Write what moves; `clock` is the accessor of the times of the frames."""


class _Sheet(_Surface):
    """Faces of springs: a mesh with a morph target for each frame after the first one."""

    def __init__(self, asset: _Asset, name: str, body: Body, rows: slice, scale: float) -> None:
        super().__init__(asset, name, body, rows, scale)
        self._first: FloatArray | None = None
        self._targets: list[dict[str, int]] = []

    def put(self, sample: Sample) -> None:
        places = sample.positions[self._rows]
        if self._first is None:
            self._first = places
        else:
            self._targets.append({"POSITION": self._asset.array(places - self._first, bounded=True)})

    def finish(self, clock: int, times: FloatArray) -> None:
        assert self._first is not None  # there is a frame
        assert self._body.network is not None  # it has faces
        mesh = self._asset.mesh(self._name, self._first, self._body.network.faces)
        node = self._asset.node(self._name)
        if self._targets:
            mesh["primitives"][0]["targets"] = self._targets
            mesh["weights"] = [0.0] * len(self._targets)
            self._asset.animate(node, "weights", clock, np.eye(len(times))[:, 1:].ravel())


class _Solids(_Surface):
    """Rigid bodies: one mesh, and a node for each."""

    def __init__(self, asset: _Asset, name: str, body: Body, rows: slice, scale: float) -> None:
        super().__init__(asset, name, body, rows, scale)
        self._places: list[FloatArray] = []
        self._turns: list[FloatArray] = []

    def put(self, sample: Sample) -> None:
        self._places.append(sample.positions[self._rows])
        self._turns.append(sample.turns["orientation"][self._rows][:, [1, 2, 3, 0]])

    def finish(self, clock: int, times: FloatArray) -> None:
        body = cast("RigidBodies", self._body)
        self._asset.mesh(self._name, *solid_surface(body, self._scale))
        places, turns = np.stack(self._places), np.stack(self._turns)
        for index in range(len(body)):
            node = self._asset.node(self._name if len(body) == 1 else f"{self._name} {index}")
            self._asset.animate(node, "translation", clock, places[:, index])
            self._asset.animate(node, "rotation", clock, _continuous(turns[:, index]))


class _Liquid(_Surface):
    """A fluid: a node with a mesh of its own for each frame, of size 0 in all others."""

    def __init__(self, asset: _Asset, name: str, body: Body, rows: slice, scale: float) -> None:
        super().__init__(asset, name, body, rows, scale)
        self._nodes: list[int | None] = []

    def put(self, sample: Sample) -> None:
        body = cast("Fluid", self._body)
        surface = liquid_surface(sample.positions[self._rows], self._scale * body.spacing)
        node = None
        if len(surface.faces):
            name = f"{self._name} {sample.index}"
            self._asset.mesh(name, *surface)
            node = self._asset.node(name)
        self._nodes.append(node)

    def finish(self, clock: int, times: FloatArray) -> None:
        if len(times) == 1:
            return
        for index, node in enumerate(self._nodes):
            if node is not None:
                changes = sorted({0, index, index + 1} & set(range(len(times))))
                sizes = np.array([[float(frame == index)] * 3 for frame in changes])
                self._asset.animate(
                    node, "scale", self._asset.array(times[changes], bounded=True), sizes, interpolation="STEP"
                )


def _surface(asset: _Asset, name: str, body: Body, rows: slice, scale: float) -> _Surface:
    """The writer of a body."""
    kind = _Liquid if body.is_fluid else _Solids if body.is_rigid else _Sheet
    return kind(asset, name, body, rows, scale)


def _continuous(quaternions: FloatArray) -> FloatArray:
    """Quaternions (F, 4) with the signs for which each is nearest to the one before."""
    turned = np.einsum("fk,fk->f", quaternions[1:], quaternions[:-1]) < 0.0
    signs = np.concatenate([[1.0], np.where(turned, -1.0, 1.0).cumprod()])
    return np.asarray(quaternions * signs[:, np.newaxis])


def _assemble(file: IO[bytes], asset: _Asset, target: Path) -> None:
    """Write a file from its JSON and its arrays.

    Raises:
        FileError: the file would be too large for the format.
    """
    if not asset.json["animations"][0]["channels"]:
        del asset.json["animations"]
    asset.json["buffers"] = [{"byteLength": asset.size}]
    text = json.dumps(asset.json, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    whole = 28 + len(text) + asset.size
    if whole > MOST:
        raise FileError(f"{target}: would have {whole / 2**30:.1f} GiB, and glTF holds 4; take fewer frames (fps=…)")
    file.write(b"glTF" + _words(2, whole))
    file.write(_words(len(text)) + b"JSON" + text)
    file.write(_words(asset.size) + b"BIN\0")
    asset.copy_to(file)


def _words(*numbers: int) -> bytes:
    """Numbers of 32 bits."""
    return b"".join(number.to_bytes(4, "little") for number in numbers)
