"""H5MD 1.1: HDF5 files for molecular data. Source: https://www.nongnu.org/h5md/h5md.html."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, ClassVar

import numpy as np

from physcore.output.base import Sample, Trajectory, TrajectoryWriter
from physcore.periodic import Periodic
from physcore.provenance import version
from physcore.storage import replacing

if TYPE_CHECKING:
    import h5py

UNITS = {"position": "m", "velocity": "m s-1", "density": "kg m-3", "pressure": "Pa"}
CONSTANT_UNITS = {"mass": "kg", "radius": "m", "charge": "C"}
ENERGIES = ("kinetic", "potential", "internal", "total", "dissipated", "work")
"""The parts of the budget, each an observable."""


class H5mdWriter(TrajectoryWriter):
    """`particles/all` has position and velocity, of fluids density and pressure, over time, and mass, radius, charge,
    and `species`, the index of the body; `observables` has the energies [J] at the times of their steps. `step`
    counts frames. Lengths of the box along axes that are not periodic mean nothing, and are 1.
    """

    suffixes: ClassVar = (".h5md",)

    @classmethod
    def missing(cls) -> str | None:
        """The library, if it is not there."""
        return None if find_spec("h5py") else "H5MD needs h5py: pip install 'physcore[hdf5]'; a .xyz needs nothing"

    def write(self, trajectory: Trajectory, target: Path) -> None:
        """Write all frames."""
        import h5py

        with replacing(target) as temporary:
            disk = _Disk(temporary)
            with h5py.File(disk, "w", libver="v110") as file:
                _describe(file, trajectory)
                series = _Series(file, trajectory.count)
                for sample in trajectory.samples():
                    series.put(sample)
                    disk.check()
            disk.check()


class _Disk:
    """A file that keeps its failures to itself: HDF5 would print some of them and lose others, as those at its end.

    Who writes asks for them.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._failure: OSError | None = None
        self.read, self.seek, self.tell = file.read, file.seek, file.tell

    def check(self) -> None:
        """Raise the first failure, if there was one."""
        if self._failure is not None:
            raise self._failure

    def write(self, content: bytes) -> int:
        """Write, or fail in silence."""
        self._try(self._file.write, content)
        return len(content)

    def truncate(self, size: int | None = None) -> int:
        """Cut or lengthen the file, or fail in silence."""
        self._try(self._file.truncate, size)
        return size or 0

    def flush(self) -> None:
        """Hand everything to the system, or fail in silence."""
        self._try(self._file.flush)

    def _try(self, action: Callable[..., object], *arguments: object) -> None:
        try:
            action(*arguments)
        except OSError as error:
            self._failure = self._failure or error


def _describe(file: h5py.File, trajectory: Trajectory) -> None:
    """All that does not change."""
    head = file.create_group("h5md")
    head.attrs["version"] = np.array([1, 1], dtype=np.int32)
    head.create_group("author").attrs["name"] = np.bytes_("physcore")
    creator = head.create_group("creator")
    creator.attrs["name"], creator.attrs["version"] = np.bytes_("physcore"), np.bytes_(version())
    units = head.create_group("modules/units")
    units.attrs["version"], units.attrs["system"] = np.array([1, 0], dtype=np.int32), np.bytes_("SI")
    group = file.create_group("particles/all")
    _box(group.create_group("box"), trajectory.domain)
    for name, values in trajectory.constants.items():
        group.create_dataset(name, data=values).attrs["unit"] = np.bytes_(CONSTANT_UNITS[name])
    group.create_dataset("species", data=trajectory.body)
    file.create_group("observables")


def _box(box: h5py.Group, domain: Periodic | None) -> None:
    """The periodic domain."""
    lengths = np.full(3, np.inf)
    if domain is not None:
        lengths[: domain.dimension] = domain.lengths
    periodic = np.isfinite(lengths)
    box.attrs["dimension"] = np.int32(3)
    box.attrs["boundary"] = np.where(periodic, b"periodic", b"none")
    if periodic.any():
        box.create_dataset("edges", data=np.where(periodic, lengths, 1.0)).attrs["unit"] = np.bytes_("m")


class _Series:
    """What changes with time; the place for all frames is laid out with the first of them, and filled one by one."""

    def __init__(self, file: h5py.File, count: int) -> None:
        self._file, self._count = file, count
        self._values: dict[str, Any] = {}

    def put(self, sample: Sample) -> None:
        """Add a frame."""
        arrays = {"position": sample.positions, "velocity": sample.velocities, **sample.fields}
        for name, array in arrays.items():
            if array is not None:
                self._store(f"particles/all/{name}", sample.index, sample.time, array, UNITS[name])
        for name in ENERGIES:
            path, energy = f"observables/{name}_energy", sample.energy
            self._store(path, sample.index, energy.time, np.float64(getattr(energy, name)), "J")

    def _store(self, path: str, index: int, time: float, value: Any, unit: str) -> None:
        if path not in self._values:
            self._begin(path, np.shape(value), unit)
        self._values[path][index] = value
        self._file[path]["time"][index] = time

    def _begin(self, path: str, shape: tuple[int, ...], unit: str) -> None:
        """Lay out an element: step and time are one data set for all that are taken together."""
        group, room = self._file.create_group(path), path.partition("/")[0]
        self._values[path] = group.create_dataset("value", (self._count, *shape), dtype="<f8")
        self._values[path].attrs["unit"] = np.bytes_(unit)
        first = next(name for name in self._values if name.startswith(room))
        if first == path:
            group.create_dataset("step", data=np.arange(self._count))
            group.create_dataset("time", (self._count,), dtype="<f8").attrs["unit"] = np.bytes_("s")
        else:
            group["step"], group["time"] = self._file[first]["step"], self._file[first]["time"]
