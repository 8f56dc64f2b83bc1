"""Extended XYZ: text with one block of lines per frame, in named columns.

Source: https://github.com/libAtoms/extxyz, the specification; further keys as in OVITO and ASE.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import ClassVar

import numpy as np

from physcore.output.base import OTHER, ExportJob, Sample, TrajectoryWriter
from physcore.scene.periodic import Periodic
from physcore.storage.files import replacing
from physcore.units.constants import atomic_mass, electron_volt
from physcore.units.styles import STYLES

NAMES = {"mass": "masses"}
"""Names of columns for programs for atoms."""


class ExtendedXyzWriter(TrajectoryWriter):
    """Writer of extended XYZ.

    The columns are species (X of particles that are no atoms), position [m], velocity [m/s], mass [kg], and radius [m]
    and charge [C] if there are any. They are followed by density [kg/m³] and pressure [Pa] of fluids, and the index of
    the body. Rigid bodies are particles at their centers of mass; all particles then have an orientation, a unit
    quaternion in the order of OVITO (x, y, z, w), and an angular velocity [rad/s]. The comment line has the time [s],
    the energies [J], and in "Units" the units, which are others if the scene has others. Numbers have all their digits.

    For programs for atoms the masses are in a column "masses", and the comment has the temperature [K]. In units of
    "metal" there are also the momenta, in units of ASE [√(u·eV)].
    """

    suffixes: ClassVar = (".xyz", ".extxyz")

    def write(self, job: ExportJob, target: Path) -> None:
        """Write all frames."""
        cell = _cell(job.domain)
        own = f' Units="{job.units.named}"'
        with replacing(target) as file:
            for sample in job.samples():
                columns, names = _columns(job, sample)
                energy = {name: sample.energy[name] for name in ("kinetic", "potential", "internal", "total")}
                values = {"Time": sample.time, **energy}
                if sample.energy.temperature is not None:
                    values["Temperature"] = sample.energy.temperature
                head = f"{cell}{own} Properties={names} " + " ".join(
                    f"{name}={value!r}" for name, value in values.items()
                )
                species = job.species or (OTHER,) * job.particles
                rows = (
                    f"{name} {' '.join(map(repr, row))}"
                    for name, row in zip(species, zip(*columns, strict=True), strict=True)
                )
                file.write("\n".join([str(job.particles), head, *rows, ""]).encode())


def _columns(job: ExportJob, sample: Sample) -> tuple[list[list[float]], str]:
    """The columns after the species, and the names of all columns."""
    vectors = {"pos": sample.positions}
    if sample.velocities is not None:
        vectors["velo"] = sample.velocities
    turns = {
        name: values[:, [1, 2, 3, 0]] if name == "orientation" else values for name, values in sample.turns.items()
    }
    vectors |= turns
    numbers = {NAMES.get(name, name) if job.for_atoms else name: values for name, values in job.constants.items()}
    numbers |= sample.fields
    if job.for_atoms and job.units == STYLES["metal"].units and sample.velocities is not None:
        vectors["momenta"] = _to_ase(job) * sample.velocities * job.constants["mass"][:, np.newaxis]
    names = [f"{name}:R:{values.shape[1]}" for name, values in vectors.items()] + [f"{name}:R:1" for name in numbers]
    values = [column.tolist() for array in vectors.values() for column in array.T]
    values += [array.tolist() for array in numbers.values()]
    return [*values, job.body.tolist()], ":".join(["species:S:1", *names, "body:I:1"])


def _to_ase(job: ExportJob) -> float:
    """The factor from velocities of a file to those of ASE [√(eV/u)]."""
    return 1.0 / job.units.convert((electron_volt / atomic_mass) ** 0.5, "m/s")


def _cell(domain: Periodic | None) -> str:
    """The periodic axes and the domain; the length along an axis that is not periodic is 1, without meaning."""
    if domain is None:
        return 'pbc="F F F"'
    lower, lengths = np.zeros(3), np.full(3, math.inf)
    lower[: domain.dimension], lengths[: domain.dimension] = domain.lower, domain.lengths
    periodic = np.isfinite(lengths)
    edges = np.diag(np.where(periodic, lengths, 1.0)).ravel().tolist()
    origin = np.where(periodic, lower, 0.0).tolist()
    flags = " ".join("T" if each else "F" for each in periodic)
    return f'Lattice="{" ".join(map(repr, edges))}" Origin="{" ".join(map(repr, origin))}" pbc="{flags}"'
