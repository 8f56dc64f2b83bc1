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
from physcore.units.systems import UnitSystem

FIELDS = {"densities": "density", "pressures": "pressure"}
"""Names of channels in the singular, for the values of a single particle."""


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
    energy: Energy
    """Energy budget of the last step at or before this time."""
    systems: Mapping[str, Mapping[str, FloatArray]]
    """Fields of each system on a grid, by the system's path and their names, as far as they were recorded."""


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

    def __init__(self, source: Source, progress: bool | None) -> None:
        self._source = source
        self._progress = progress

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
        return self._source.scene.periodic

    @property
    def units(self) -> UnitSystem:
        """The units of all numbers."""
        return self._source.scene.units

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
        every = {name: self._gather(name) for name in ("mass", "radius", "charge")}
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
                rest.append(body.network.rest_length)
        return Springs(np.concatenate(pairs), np.concatenate(rest), self.domain)

    def samples(self) -> Iterator[Sample]:
        """All frames from the start, counted on the progress bar."""
        with Progress(self.count, "exporting", self._progress) as bar:
            for index, frame in enumerate(self._source.frames()):
                velocities = _in_space(self._whole(frame, "velocities")) if self.moving else None
                fields = {name: self._whole(frame, field) for field, name in FIELDS.items() if field in frame.fields}
                systems = {path: _own(frame.fields, f"{path}.") for path in self.grids}
                assert frame.energy is not None  # `export` has checked this
                places, turns = _in_space(self._whole(frame, "positions")), dict(self._turns(frame))
                yield Sample(index, frame.time, places, velocities, fields, turns, frame.energy, systems)
                bar.update(index + 1)

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
            rates[rows, 3 - given.shape[1] :] = given
            yield "angular_velocity", rates


class TrajectoryWriter(Format, ABC):
    """Base class of trajectory formats."""

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
