"""Trajectories for the tools of the field: `export` is the recipe, and each format is a file.

To add a format: a file here and a line in FORMATS.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Unpack

from physcore.checks import flag, shown
from physcore.errors import SceneError
from physcore.numerics.choices import Options
from physcore.output.base import ExportJob, TrajectoryWriter
from physcore.output.extended_xyz import ExtendedXyzWriter
from physcore.output.h5md import H5mdWriter
from physcore.output.vtk import VtkWriter
from physcore.scene.scene import Scene
from physcore.simulation.recording import Recording
from physcore.simulation.sources import sources
from physcore.spelling import spelled
from physcore.storage.formats import writable

FORMATS: tuple[type[TrajectoryWriter], ...] = (ExtendedXyzWriter, VtkWriter, H5mdWriter)
"""Every format that a trajectory can be exported to."""

__all__ = ["FORMATS", "export"]


@spelled
def export(
    recording: Recording | Scene,
    path: str | os.PathLike[str],
    *,
    duration: float | None = None,
    fps: float | None = None,
    progress: bool | None = None,
    **numerics: Unpack[Options],
) -> None:
    """Write a recording, or a scene while it is simulated, to a file that other tools read.

        pc.export(recording, "cloth.xyz")

    The end of the name says which format:

        .xyz, .extxyz   extended XYZ: text, for OVITO, ASE and many others
        .pvd            for ParaView, files in a folder beside it: for each frame a .vtp of particles and springs with
                        their strain, and a .vti of each system on a grid, whose fields no other format has
        .h5md           H5MD 1.1, for MDAnalysis, OVITO and VMD, with the energies; needs `pip install 'physcore[hdf5]'`

    Everything is in SI units, as always in physcore: meters, seconds, kilograms. Readers made for atoms, such as ASE,
    take lengths for Å and do not convert them. What is 2D is written with z = 0. Positions are those of the recording,
    within the periodic domain, with all their digits. Only one frame of a scene is in memory at a time. The file
    appears under its name when it is whole; until then, and on any failure, what was there stays.

    Args:
        recording: what to write.
        path: where to.
        duration: how long to simulate a scene [s].
        fps: frames per second of simulated time; None: 30.
        progress: whether to show a progress bar; None: on a terminal, when it takes longer than a second.
        numerics: for a scene: integrator, dt, precision, threads, … as in Simulation.

    Raises:
        SceneError: an argument is not valid, or the recording has no energies, or nothing that the format
            holds.
        FileError: the file cannot be written.
        PhyscoreError: what the format needs is not installed.
        SimulationDiverged: the scene blew up.
    """
    writer, target = writable(path, FORMATS), Path(path)
    bar = None if progress is None else flag(progress, "progress")
    (source,) = sources([recording], duration, fps, numerics)
    if not source.audited:
        raise SceneError(
            f"recording: must be a Scene or what simulate(…) gives, with its energies, got {shown(recording)}"
        )
    job = ExportJob(source, bar)
    if not job.has_bodies and not job.grids:
        raise SceneError(
            "recording: trajectories hold particles and fields on grids, and there are neither; positions of tracers "
            "are recording[tracers].positions, which numpy.save writes"
        )
    if not job.has_bodies and not writer.holds_fields:
        able = " or ".join(suffix for each in FORMATS if each.holds_fields for suffix in each.suffixes)
        raise SceneError(f"path: {target.suffix} holds particles, and there are only fields on grids; write {able}")
    writer.write(job, target)
