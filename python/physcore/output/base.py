"""Base class of trajectory formats, and the job given to a writer: frames in three dimensions, one at a time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np

from physcore.checks import FloatArray, IntArray
from physcore.progress import Progress
from physcore.scene.bodies import Body
from physcore.scene.grid import Grid
from physcore.scene.periodic import Periodic
from physcore.simulation.energy import Energy
from physcore.simulation.sources import Source
from physcore.storage.formats import Format
from physcore.units.systems import UnitSystem

FIELDS = {"densities": "density", "pressures": "pressure"}
"""Names of channels in the singular, for the values of a single particle."""


@dataclass(frozen=True, eq=False)
class Sample:
    """All particles at one time."""

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
        """The number N of particles."""
        return self._source.scene.particles

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
        indices = [self._source.scene.index(body) for body in self._bodies]
        return np.repeat(indices, [len(body) for body in self._bodies]).astype(np.int64)

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
                velocities = _in_space(frame.fields["velocities"]) if "velocities" in frame.fields else None
                fields = {name: frame.fields[field] for field, name in FIELDS.items() if field in frame.fields}
                systems = {path: _own(frame.fields, f"{path}.") for path in self.grids}
                assert frame.energy is not None  # `export` has checked this
                yield Sample(index, frame.time, _in_space(frame.positions), velocities, fields, frame.energy, systems)
                bar.update(index + 1)

    @property
    def _bodies(self) -> tuple[Body, ...]:
        return self._source.scene.particle_bodies

    def _gather(self, name: str) -> FloatArray:
        return self._source.scene.gather(name)


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
