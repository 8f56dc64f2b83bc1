"""Base class of trajectory formats, and the job given to a writer: frames in three dimensions, one at a time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np

from physcore.arithmetic import cos, sin
from physcore.checks import FloatArray, IntArray
from physcore.errors import SceneError
from physcore.progress import Progress
from physcore.scene.bodies import Body
from physcore.scene.grid import Grid
from physcore.scene.periodic import Periodic
from physcore.simulation.energy import Energy
from physcore.simulation.sources import Source, SourceFrame
from physcore.storage.formats import Format
from physcore.units.constants import boltzmann_constant
from physcore.units.styles import Style
from physcore.units.systems import UnitSystem

FIELDS = {"densities": ("density", "kg/m³"), "pressures": ("pressure", "Pa")}
"""Names of channels in the singular, for the values of a single particle, and their units."""
OTHER = "X"
"""Species of particles that are no atoms; readers take it for an atom of no element."""


@dataclass(frozen=True, eq=False)
class Sample:
    """All particles and rigid bodies at one time, in the order of the scene's bodies."""

    index: int
    """Index of the frame, from 0."""
    time: float
    """Time [s]."""
    positions: FloatArray
    """Positions [m], shape (N, 3)."""
    velocities: FloatArray | None
    """Velocities [m/s], shape (N, 3); None if they were not recorded."""
    fields: Mapping[str, FloatArray]
    """Densities [kg/m³] and pressures [Pa], each of shape (N,), as far as there are any."""
    turns: Mapping[str, FloatArray]
    """Orientations, unit quaternions (w, x, y, z) of shape (N, 4), and angular velocities [rad/s] of shape (N, 3), if
    there are rigid bodies; those of particles are (1, 0, 0, 0) and 0.
    """
    energy: Energies
    """Energy budget of the last step at or before this time."""
    systems: Mapping[str, Mapping[str, FloatArray]]
    """Fields of each system on a grid, by the system's path and their names, as far as they were recorded."""


@dataclass(frozen=True, eq=False)
class Energies:
    """Energy budget in the units of a file."""

    budget: Energy
    """Energy budget in the units of the scene."""
    factor: float
    """Factor to the unit of energy of the file."""
    time: float
    """Time of the budget [s]."""
    temperature: float | None
    """Kinetic temperature [K] in files for programs for atoms, otherwise None."""

    def __getitem__(self, name: str) -> float:
        """A part of the budget by its name, such as "kinetic"."""
        return self.factor * float(getattr(self.budget, name))


@dataclass(frozen=True, eq=False)
class Springs:
    """Springs of all bodies."""

    pairs: IntArray
    """The two particles of each spring, shape (M, 2)."""
    rest_length: FloatArray
    """Rest lengths [m], shape (M,)."""
    domain: Periodic | None

    def strain(self, positions: FloatArray) -> FloatArray:
        """The strains (M,): length over rest length, minus 1; NaN if the rest length is zero."""
        first, second = self.pairs.T
        separation = positions[second] - positions[first]
        if self.domain is not None:  # In a periodic domain, between nearest images.
            axes = self.domain.dimension
            separation[:, :axes] = self.domain.nearest(separation[:, :axes])
        rest = np.where(self.rest_length > 0.0, self.rest_length, np.nan)
        strain: FloatArray = np.linalg.norm(separation, axis=1) / rest - 1.0
        return strain


class ExportJob:
    """Job of a writer: the constants of a trajectory, and its frames."""

    def __init__(self, source: Source, progress: bool | None, style: Style | None = None, atoms: bool = False) -> None:
        self._source = source
        self._progress = progress
        self._style = style
        self.for_atoms = atoms
        """Whether the file has the units, and names its values as, programs for atoms expect."""

    @property
    def count(self) -> int:
        """The number of frames."""
        return self._source.count

    @property
    def particles(self) -> int:
        """The number N of particles and rigid bodies."""
        return sum(map(len, self._bodies))

    @property
    def has_bodies(self) -> bool:
        """Whether there are bodies, which may be without particles."""
        return bool(self._bodies)

    @property
    def domain(self) -> Periodic | None:
        """The periodic domain."""
        domain, factor = self._source.scene.periodic, self.length
        if domain is None or factor == 1.0:
            return domain
        return Periodic([factor * end for end in domain.lower], [factor * end for end in domain.upper])

    @property
    def units(self) -> UnitSystem:
        """The units of all numbers but energies."""
        return self._source.scene.units if self._style is None else self._style.units

    @property
    def energy_unit(self) -> str:
        """The symbol of the unit of energy."""
        return self.units.symbol("J") if self._style is None else self._style.energy_symbol

    @cached_property
    def species(self) -> tuple[str, ...] | None:
        """The species of all particles, where there are atoms; X of others."""
        named = [getattr(body, "species", None) for body in self._bodies]
        if not any(named):
            return None
        each = zip(named, self._bodies, strict=True)
        return tuple(name for names, body in each for name in names or (OTHER,) * len(body))

    @cached_property
    def surfaces(self) -> dict[str, tuple[Body, slice]]:
        """The bodies that have a surface in space, by name or index, with their rows."""
        starts = np.cumsum([0, *(len(body) for body in self._bodies)]).tolist()
        rows = [slice(start, start + len(body)) for body, start in zip(self._bodies, starts, strict=False)]
        return {
            body.name or f"body {index}": (body, row)
            for index, (body, row) in enumerate(zip(self._bodies, rows, strict=True))
            if (body.network is not None and len(body.network.faces))
            or ((body.is_rigid or body.is_fluid) and body.dimension == 3)
        }

    @property
    def length(self) -> float:
        """The factor from lengths of the scene to those of the file."""
        return self._factor("m")

    @property
    def rate(self) -> float:
        """Frames per unit of time of the file."""
        return self._source.fps / self._factor("s")

    @property
    def dimension(self) -> int:
        """The dimension of the scene."""
        return self._source.scene.dimension

    @cached_property
    def grids(self) -> dict[str, Grid]:
        """The grids of systems, by path."""
        scene = self._source.scene
        return {str(scene.system(each)): each.grid for each in scene.grids}

    @property
    def moving(self) -> bool:
        """Whether frames have velocities."""
        return self._source.has("velocities")

    @cached_property
    def constants(self) -> dict[str, FloatArray]:
        """Constants of the particles by name, each of shape (N,): mass [kg], and radius [m] and charge [C] if any."""
        units = {"mass": "kg", "radius": "m", "charge": "C"}
        every = {name: self._scaled(self._gather(name), unit) for name, unit in units.items()}
        return {name: values for name, values in every.items() if name == "mass" or values.any()}

    @cached_property
    def body(self) -> IntArray:
        """The index of the body of each particle, shape (N,)."""
        return np.repeat(np.arange(len(self._bodies)), [len(body) for body in self._bodies])

    @cached_property
    def springs(self) -> Springs:
        """The springs of all bodies."""
        starts = np.cumsum([0, *(len(body) for body in self._bodies)])
        pairs, rest = [np.empty((0, 2), dtype=np.int64)], [np.empty(0)]
        for body, start in zip(self._bodies, starts, strict=False):
            if body.network is not None:
                pairs.append(body.network.pairs + start)
                rest.append(self._scaled(body.network.rest_length, "m"))
        return Springs(np.concatenate(pairs), np.concatenate(rest), self.domain)

    def samples(self) -> Iterator[Sample]:
        """All frames from the start, counted on the progress bar."""
        with Progress(self.count, "exporting", self._progress) as bar:
            for index, frame in enumerate(self._source.frames()):
                velocities = self._vectors(frame, "velocities", "m/s") if self.moving else None
                fields = {
                    name: self._scaled(self._whole(frame, field), unit)
                    for field, (name, unit) in FIELDS.items()
                    if field in frame.fields
                }
                systems = {path: _own(frame.fields, f"{path}.") for path in self.grids}
                assert frame.energy is not None  # `export` has checked this
                places, turns = self._vectors(frame, "positions", "m"), dict(self._turns(frame))
                time, energies = self._factor("s") * frame.time, self._energies(frame.energy)
                yield Sample(index, time, places, velocities, fields, turns, energies, systems)
                bar.update(index + 1)

    def _factor(self, unit: str) -> float:
        """The factor from a unit of the scene to that of the file."""
        scene = self._source.scene.units
        return 1.0 if self.units == scene else self.units.convert(1.0, unit) / scene.convert(1.0, unit)

    def _scaled(self, values: FloatArray, unit: str) -> FloatArray:
        """Values of the scene in units of the file."""
        factor = self._factor(unit)
        return values if factor == 1.0 else factor * values

    def _vectors(self, frame: SourceFrame, name: str, unit: str) -> FloatArray:
        """Vectors (N, 3) of all rows, in units of the file."""
        return self._scaled(_in_space(self._whole(frame, name)), unit)

    def _energies(self, energy: Energy) -> Energies:
        """The energy budget in units of the file, with the temperature T = 2 K/(g k_B) for g degrees of freedom."""
        scene, factor, temperature = self._source.scene, 1.0, None
        if self._style is not None and not scene.units.is_dimensionless:
            factor = 1.0 / (scene.units.convert(1.0, "J") * self._style.energy)
        if self.for_atoms:
            axes = scene.dimension
            turns = axes * (axes - 1) // 2
            each = [(axes + turns * body.is_rigid) * int(np.count_nonzero(~body.fixed)) for body in self._bodies]
            freedoms = sum(each)
            kinetic = float(energy.kinetic) / scene.units.convert(1.0, "J")
            temperature = 2.0 * kinetic / (max(freedoms, 1) * boltzmann_constant)
        return Energies(energy, factor, self._factor("s") * energy.time, temperature)

    @property
    def _bodies(self) -> tuple[Body, ...]:
        return self._source.scene.bodies

    def _gather(self, name: str) -> FloatArray:
        return np.concatenate([getattr(body, name) for body in self._bodies])

    def _whole(self, frame: SourceFrame, name: str) -> FloatArray:
        """A field of particles with rows for rigid bodies too; NaN where these have no such field.

        Raises:
            SceneError: the field was recorded of particles alone.
        """
        scene, values = self._source.scene, frame.fields[name]
        if not scene.has_rigid_bodies:
            return values
        whole = np.full((self.particles, *values.shape[1:]), np.nan)
        whole[scene.are_particles] = values
        own = f"rigid_{name}"
        if own in scene.fields:
            if own not in frame.fields:
                raise SceneError(f"channels: {own} were not recorded; ask for them with channels=({name!r}, …)")
            whole[~scene.are_particles] = frame.fields[own]
        return whole

    def _turns(self, frame: SourceFrame) -> Iterator[tuple[str, FloatArray]]:
        """The orientations and angular velocities of all rows, if there are rigid bodies."""
        fields, rows = frame.fields, ~self._source.scene.are_particles
        if "angles" in fields or "orientations" in fields:
            quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (self.particles, 1))
            if "angles" in fields:
                half = 0.5 * fields["angles"]
                quaternions[rows, 0], quaternions[rows, 3] = cos(half), sin(half)
            else:
                quaternions[rows] = fields["orientations"]
            yield "orientation", quaternions
        if "angular_velocities" in fields:
            rates = np.zeros((self.particles, 3))
            # In 2D the rotation is about z.
            given = fields["angular_velocities"].reshape(np.count_nonzero(rows), -1)
            rates[rows, 3 - given.shape[1] :] = given / self._factor("s")
            yield "angular_velocity", rates


class TrajectoryWriter(Format, ABC):
    """Base class of trajectory formats."""

    holds_particles: ClassVar[bool] = True
    """Whether the format stores particles, and not surfaces alone."""
    prescribed: ClassVar[UnitSystem | None] = None
    """The units that the format prescribes, or None."""
    holds_fields: ClassVar[bool] = False
    """Whether the format stores fields on grids, in addition to particles."""

    @abstractmethod
    def write(self, job: ExportJob, target: Path) -> None:
        """Write all frames. The file appears under its name when it is complete; until then an existing file stays.

        Raises:
            FileError: the file cannot be written.
        """


def _own(fields: Mapping[str, FloatArray], prefix: str) -> dict[str, FloatArray]:
    """The fields whose names begin with a prefix, by the rest of their names."""
    return {name.removeprefix(prefix): values for name, values in fields.items() if name.startswith(prefix)}


def _in_space(vectors: FloatArray) -> FloatArray:
    """Vectors (N, D) padded with zeros to three dimensions."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))
