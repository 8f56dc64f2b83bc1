"""Reading of what users bring: the function `read`, and one module per kind of file.

To add a kind: a module here and a line in READERS.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from physcore.checks import file_path, shown, text
from physcore.entrance import entrance
from physcore.errors import SceneError
from physcore.files.mesh import Mesh
from physcore.files.meshes import MeshReader, from_mesh
from physcore.files.molecules import MoleculeReader
from physcore.files.picture import Picture, PictureReader
from physcore.files.reader import Options, Reader
from physcore.files.signal import Signal, WavReader
from physcore.files.table import ArrayReader, Table, TableReader
from physcore.scene.atoms import Atoms
from physcore.spelling import did_you_mean
from physcore.units.styles import unit_system
from physcore.units.systems import SI, UnitSystem

READERS: tuple[type[Reader], ...] = (MeshReader, MoleculeReader, TableReader, ArrayReader, PictureReader, WavReader)
"""All readers."""

__all__ = ["READERS", "Atoms", "Mesh", "Picture", "Signal", "Table", "from_mesh", "read"]


@entrance
def read(
    path: str | os.PathLike[str],
    as_: str | None = None,
    *,
    unit: object = None,
    units: UnitSystem | str = SI,
    up: str | None = None,
    frame: int = 0,
    masses: Mapping[str, float] | None = None,
) -> Any:
    """Read a mesh, a molecule, a table, a picture or a sound, each by a package that is made for it.

        bunny = pc.read("bunny.stl", unit="mm")  # a Mesh
        scene = pc.Scene(bunny.rigid_body(density=700.0), pc.Gravity(), pc.Floor(-0.2))

    The suffix of the file selects what is returned:

        .obj .stl .ply .off .glb .gltf      Mesh, by trimesh
        .xyz .extxyz .gro .pdb              Atoms, by ASE
        .data .lmp .lammps                  Atoms, from a data file of LAMMPS
        .dump .lammpstrj                    Atoms, from a dump of LAMMPS as text
        .csv .tsv .txt .dat                 Table: columns by their names
        .npy .npz                           an array, or a dict of arrays
        .png .jpg .tif .bmp …               Picture: brightness, for masks, outlines and ground
        .wav                                Signal: values over time, by scipy

    Meshes, molecules and sounds need `pip install 'physcore[files]'`. The result is in SI units, or in `units`. Files
    whose format has no unit must be given one: `unit`. Those of glTF are meters, those of GROMACS nm and ps, those of
    PDB Å; files of LAMMPS and physcore may name theirs.

    Args:
        path: the file.
        as_: suffix of the format, such as ".data", if the name of the file ends in another one.
        unit: unit of the numbers in the file. Of meshes a length: "mm", 0.0254 (meters), or another unit of
            `pc.units`. Of atoms "metal", "real", "gromacs", "si" or a `pc.units.system(…)`; of LAMMPS any of its styles
            but "lj", whose numbers remain without units.
        units: units of the result, for `Scene(units=…)`: a `pc.units.system(…)`, or a name such as "metal".
        up: the axis of a mesh that points up in the file, "y" or "z", and is z in the result; None: y of glTF, z of
            others.
        frame: index of a frame of atoms; negative indices count from the end.
        masses: masses of atoms by species, in `units`; others are those of the file, or of the elements.

    Raises:
        SceneError: the suffix is unknown, a unit is missing or not valid, or an option has no meaning for the file.
        FileError: there is no such file, or it is damaged.
        PhyscoreError: a package is not installed.
    """
    named = file_path(path)
    suffix = (named.suffix if as_ is None else text(as_, "read.as_")).lower()
    reader = next((each for each in READERS if suffix in each.suffixes), None)
    if reader is None:
        known = [each for kind in READERS for each in kind.suffixes]
        argument = "path: must end in" if as_ is None else "as_: must be"
        got = str(named) if as_ is None else as_
        raise SceneError(
            f"read.{argument} one of {' '.join(known)}, got {shown(got)}{did_you_mean(suffix, known)}; "
            'as_=".data" reads a file with another ending'
        )
    return reader().open(named, suffix, Options(unit, unit_system(units, "read.units"), up, frame, masses))
