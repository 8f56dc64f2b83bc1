"""Export of trajectories to common file formats: the function `export`, and one module per format.

To add a format: a module here and a line in FORMATS.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Unpack

from physcore.checks import flag, shown
from physcore.entrance import entrance
from physcore.errors import SceneError
from physcore.numerics.choices import Options
from physcore.output.base import ExportJob, TrajectoryWriter
from physcore.output.extended_xyz import ExtendedXyzWriter
from physcore.output.gltf import GltfWriter
from physcore.output.h5md import H5mdWriter
from physcore.output.usd import UsdWriter
from physcore.output.vtk import VtkWriter
from physcore.scene.scene import Scene
from physcore.simulation.recording import Recording
from physcore.simulation.sources import sources
from physcore.storage.formats import writable
from physcore.units.styles import ATOMS, style_of
from physcore.units.systems import UnitSystem

FORMATS: tuple[type[TrajectoryWriter], ...] = (ExtendedXyzWriter, VtkWriter, H5mdWriter, GltfWriter, UsdWriter)
"""All formats of exported trajectories."""

__all__ = ["FORMATS", "export"]


@entrance
def export(
    recording: Recording | Scene,
    path: str | os.PathLike[str],
    *,
    duration: float | None = None,
    fps: float | None = None,
    units: UnitSystem | str | None = None,
    progress: bool | None = None,
    **numerics: Unpack[Options],
) -> None:
    """Write a recording, or a scene while it is simulated, to a file for other programs.

        pc.export(recording, "cloth.xyz")

    The suffix of the file selects the format:

        .xyz, .extxyz   extended XYZ: text, for OVITO, ASE and many others
        .pvd            for ParaView, files in a folder beside it: for each frame a .vtp of particles and springs with
                        their strain, and a .vti of each system on a grid, whose fields no other format has
        .h5md           H5MD 1.1, for MDAnalysis, OVITO and VMD, with the energies; needs `pip install 'physcore[hdf5]'`
        .glb            glTF 2.0, for Blender and others: moving surfaces of cloths and soft bodies, and liquids and
                        rigid bodies in 3D; lengths are meters unless `units` are given. Liquids need
                        `pip install 'physcore[files]'`
        .usda           Universal Scene Description, for Blender, Houdini and others: the same, as text

    Rigid bodies are points at their centers of mass, with their orientations; in glTF and USD they are solids. All
    values are in SI units, or in those of the scene, which files then name. Programs for atoms, such as ASE, interpret
    lengths as Å without conversion: units="metal" converts to Å, ps, u, e and eV, names the masses as they do, and adds
    the temperature. 2D scenes are written with z = 0. Positions are those of the recording, within the periodic domain,
    with all their digits. With a scene, only one frame is in memory at a time. The file appears under its name when it
    is complete. Until then, and after any failure, an existing file stays unchanged.

    Args:
        recording: the recording or scene.
        path: the file to write.
        duration: the simulated duration of a scene [s].
        fps: frames per second of simulated time; None: 30.
        units: units of the file: a `pc.units.system(…)`, or a name: "metal", "real" (Å, fs, u, e, kcal/mol), "gromacs"
            (nm, ps, u, e, kJ/mol) or "si"; None: those of the scene.
        progress: whether to show a progress bar; None: on a terminal, after one second.
        numerics: options for a scene: integrator, dt, precision, threads, … as in Simulation.

    Raises:
        SceneError: an argument is not valid, the recording has no energies, or it has nothing that the format can
            store.
        FileError: the file cannot be written.
        PhyscoreError: a package that the format needs is not installed.
        SimulationDiverged: the simulation of the scene diverged.
    """
    writer, target = writable(path, FORMATS), Path(path)
    bar = None if progress is None else flag(progress, "progress")
    (source,) = sources([recording], duration, fps, numerics)
    if not source.audited:
        raise SceneError(
            f"recording: must be a Scene or what simulate(…) gives, with its energies, got {shown(recording)}"
        )
    given = writer.prescribed if units is None and not source.scene.units.is_dimensionless else units
    style = None if given is None else style_of(given, "units")
    if style is not None and style.units.is_dimensionless != source.scene.units.is_dimensionless:
        raise SceneError(f"units: must be left out: the scene is in units of {source.scene.units}, got {shown(units)}")
    job = ExportJob(source, bar, style, isinstance(units, str) and units in ATOMS)
    if style is not None and writer.holds_fields and job.grids:
        raise SceneError("units: fields on grids are written in the units of the scene; leave units= out")
    if not writer.holds_particles and not job.surfaces:
        raise SceneError(
            f"path: {target.suffix} holds surfaces, and no body has faces: cloths, soft bodies, and "
            "liquids and rigid bodies in 3D have; particles go into .xyz, .pvd or .h5md"
        )
    if not job.has_bodies and not job.grids:
        raise SceneError(
            "recording: trajectories hold particles and fields on grids, and there are neither; positions of tracers "
            "are recording[tracers].positions, which numpy.save writes"
        )
    if not job.has_bodies and not writer.holds_fields:
        able = " or ".join(suffix for each in FORMATS if each.holds_fields for suffix in each.suffixes)
        raise SceneError(f"path: {target.suffix} holds particles, and there are only fields on grids; write {able}")
    writer.write(job, target)
