"""VTK: a list of frames (.pvd), each of them points and lines (.vtp) and images of fields (.vti), for ParaView.

Source: Kitware, "VTK File Formats", https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html.
"""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physcore.checks import text
from physcore.errors import FileError
from physcore.output.base import ExportJob, Sample, TrajectoryWriter
from physcore.scene.grid import Grid
from physcore.storage.files import held, replacing, sweep, temporary_name, unwritable
from physcore.units.systems import UnitSystem

FRAMES = "frames"
"""Temporary name of the folder of frames, until its content is known."""
TYPES = {np.dtype("float64"): "Float64", np.dtype("int64"): "Int64"}
"""Names of the data types in VTK."""


class VtkWriter(TrajectoryWriter):
    """Writer of VTK.

    Points have velocity [m/s], mass [kg], radius [m], charge [C], density [kg/m³], pressure [Pa] and the index of the
    body. Rigid bodies are points at their centers of mass; all points then have an orientation, a unit quaternion (w,
    x, y, z), and an angular velocity [rad/s]. Springs are lines with their strain. Each point is a cell too, so that it
    is visible. Systems on grids are images with the values of each field in the cells. If the scene has other units, a
    comment of the .pvd names them.

    The frames of film.pvd are in a subfolder of film/, which is named by a hash of its content. The .pvd is written
    after all frames, and the frames of an earlier .pvd are removed after that. The .pvd therefore always lists existing
    frames. Springs across a face of the periodic domain are drawn across the domain, but with the right strain.
    """

    suffixes: ClassVar = (".pvd",)
    holds_fields: ClassVar = True

    def write(self, job: ExportJob, target: Path) -> None:
        """Write all frames, and then the list of them."""
        import shutil

        frames_folder = target.with_suffix("")
        text(frames_folder.name, "path")  # The name must be valid in the list, which is XML.
        new = frames_folder / temporary_name(FRAMES)
        try:
            sweep(frames_folder, FRAMES)
            new.mkdir(parents=True)
            with held(new):
                parts, folder = _write_frames(job, new, frames_folder)
            old = _listed(target)
            with replacing(target) as file:
                file.write(_collection(f"{frames_folder.name}/{folder}", parts, job.units))
            if old not in (None, folder):
                shutil.rmtree(frames_folder / str(old), ignore_errors=True)
        except OSError as error:
            if isinstance(error, FileError) and str(target) in str(error):
                raise
            raise unwritable(target, error) from error
        finally:
            shutil.rmtree(new, ignore_errors=True)
            with suppress(OSError):  # The folder is kept if it is not empty.
                frames_folder.rmdir()


def _write_frames(job: ExportJob, new: Path, frames_folder: Path) -> tuple[list[tuple[float, int, str, str]], str]:
    """Write the frames into a new folder and rename it by a hash of its content.

    Returns one entry for each file, and the name of the folder. An entry has the time [s], the number of the part
    within the frame, the name of the part, and the name of the file.
    """
    import hashlib

    digest, written = hashlib.blake2b(digest_size=8), []
    for sample in job.samples():
        parts = [("particles", "vtp", _poly_data(job, sample))] if job.has_bodies else []
        parts += [(path, "vti", _image_data(grid, sample, path)) for path, grid in job.grids.items()]
        for number, (name, kind, content) in enumerate(parts):
            file_name = f"{sample.index:06}{f'-{number}' * bool(number)}.{kind}"
            digest.update(content)
            with replacing(new / file_name) as file:
                file.write(content)
            written.append((sample.time, number, name, file_name))
    folder = frames_folder / digest.hexdigest()
    if not folder.exists():  # An existing folder has the same content.
        new.rename(folder)
    return written, folder.name


def _listed(target: Path) -> str | None:
    """The folder of frames listed in an existing .pvd file, if physcore wrote it."""
    try:
        text = target.read_text("utf-8", errors="replace")
    except OSError:
        return None
    found = re.search(rf'file="{re.escape(target.stem)}/([0-9a-f]{{16}})/', text)
    return found[1] if found else None


def _collection(folder: str, parts: list[tuple[float, int, str, str]], units: UnitSystem) -> bytes:
    """The .pvd file: the list of frames, with a comment on units that are not of the SI."""
    from xml.sax.saxutils import escape, quoteattr

    rows = [
        f'    <DataSet timestep="{time!r}" part="{number}" name={quoteattr(name)} file={quoteattr(path)}/>'
        for time, number, name, path in ((*part[:3], f"{folder}/{part[3]}") for part in parts)
    ]
    head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">\n  <Collection>'
    own = [] if units.is_si else [f"    <!-- units: {escape(units.named).replace('--', '- -')} -->"]
    return "\n".join([head, *own, *rows, "  </Collection>", "</VTKFile>", ""]).encode()


class _Appended:
    """Binary arrays after the text of a file, each preceded by its length."""

    def __init__(self) -> None:
        self.blocks: list[bytes] = []
        self.size = 0

    def add(self, name: str, values: NDArray[np.float64] | NDArray[np.int64], components: int = 1) -> str:
        """Append an array, and return the XML element that refers to it."""
        kind = f'type="{TYPES[values.dtype]}" Name="{name}" NumberOfComponents="{components}"'
        element = f'<DataArray {kind} format="appended" offset="{self.size}"/>'
        content = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<")).tobytes()
        self.blocks += [len(content).to_bytes(8, "little"), content]
        self.size += 8 + len(content)
        return element


def _poly_data(job: ExportJob, sample: Sample) -> bytes:
    """The .vtp file of one frame."""
    count, springs, data = job.particles, job.springs, _Appended()
    points = {**job.constants, **sample.fields}
    on_points = [data.add(name, values) for name, values in points.items()] + [data.add("body", job.body)]
    if sample.velocities is not None:
        on_points.append(data.add("velocity", sample.velocities, 3))
    on_points += [data.add(name, values, values.shape[1]) for name, values in sample.turns.items()]
    strain = np.concatenate([np.full(count, np.nan), springs.strain(sample.positions)])
    lines = [
        f'<Piece NumberOfPoints="{count}" NumberOfVerts="{count}" NumberOfLines="{len(springs.pairs)}" '
        'NumberOfStrips="0" NumberOfPolys="0">',
        f"<Points>{data.add('position', sample.positions, 3)}</Points>",
        f"<PointData>{''.join(on_points)}</PointData>",
        f"<CellData>{data.add('strain', strain)}</CellData>",
        f"<Verts>{_cells(data, np.arange(count), 1)}</Verts>",
        f"<Lines>{_cells(data, springs.pairs.ravel(), 2)}</Lines>",
        "</Piece>",
    ]
    return _file("PolyData", "", sample, lines, data)


def _image_data(grid: Grid, sample: Sample, path: str) -> bytes:
    """The .vti file of one system: values in the cells, x fastest; a complex number has two components."""
    data, missing = _Appended(), 3 - grid.dimension
    extent = " ".join(f"0 {count}" for count in (*grid.cells, *[0] * missing))
    origin = " ".join(map(repr, (*grid.origin, *[0.0] * missing)))
    arrays = []
    for name, values in sample.systems[path].items():
        parts = (
            values.view(np.float64).reshape(*values.shape, -1) if np.iscomplexobj(values) else values[..., np.newaxis]
        )
        # Axes in reverse order, so that x is the fastest, followed by the components of a cell.
        ordered = np.moveaxis(parts, -1, 0).T
        arrays.append(data.add(name, ordered, ordered.shape[-1]))
    geometry = f'WholeExtent="{extent}" Origin="{origin}" Spacing="{grid.spacing!r} {grid.spacing!r} {grid.spacing!r}"'
    lines = [f'<Piece Extent="{extent}">', f"<CellData>{''.join(arrays)}</CellData>", "</Piece>"]
    return _file("ImageData", geometry, sample, lines, data)


def _file(kind: str, attributes: str, sample: Sample, lines: list[str], data: _Appended) -> bytes:
    """A VTK file: the lines of text, followed by the arrays."""
    head = [
        '<?xml version="1.0"?>',
        f'<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        f"<{kind} {attributes}>" if attributes else f"<{kind}>",
        f'<FieldData><DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{sample.time!r}',
        "</DataArray></FieldData>",
    ]
    tail = [f"</{kind}>", '<AppendedData encoding="raw">']
    text_part = "\n".join([*head, *lines, *tail]).encode()
    return b"".join([text_part, b"\n_", *data.blocks, b"\n</AppendedData></VTKFile>\n"])


def _cells(data: _Appended, connectivity: NDArray[np.int64], each: int) -> str:
    """Cells of `each` points each."""
    ends = np.arange(each, len(connectivity) + 1, each, dtype=np.int64)
    return data.add("connectivity", connectivity) + data.add("offsets", ends)
