"""H5MD 1.1: HDF5 files for molecular data. Source: https://www.nongnu.org/h5md/h5md.html."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, ClassVar

import numpy as np

from physcore.checks import FloatArray
from physcore.output.base import ExportJob, Sample, TrajectoryWriter
from physcore.scene.periodic import Periodic
from physcore.simulation.provenance import version
from physcore.storage.files import replacing
from physcore.units.symbols import powers_of
from physcore.units.systems import UnitSystem

if TYPE_CHECKING:
    import h5py

UNITS = {
    **{"time": "s", "position": "m", "velocity": "m/s", "density": "kg/m³", "pressure": "Pa"},
    **{"mass": "kg", "radius": "m", "charge": "C", "energy": "J", "angular_velocity": "rad/s"},
}
"""Units by quantity, stored in `parameters/units`."""
KNOWN = {("Å", "ps"): "Angstrom", ("Å", "fs"): "Angstrom", ("nm", "ps"): "nm", ("nm", "ns"): "nm", ("pm", "ps"): "pm"}
"""Units of length and time whose files MDAnalysis opens, with its name of the first.

Only these are stored at each element, as in H5MD's units module. It opens no file with others, such as meters.
"""
ENERGIES = ("kinetic", "potential", "internal", "total", "dissipated", "work")
"""Parts of the energy budget; each is an observable."""


class H5mdWriter(TrajectoryWriter):
    """Writer of H5MD.

    `particles/all` has the positions and velocities over time, and the densities and pressures of fluids. It also has
    mass, radius, charge, and `species`, the index of the body. Rigid bodies are particles at their centers of mass; all
    particles then have an `orientation`, a unit quaternion (w, x, y, z), and an `angular_velocity`. `observables` has
    the energies [J] at the times of their steps. `step` counts frames. Lengths of the box along axes that are not
    periodic are 1, without meaning. Units are in `parameters/units`, and those of atoms at each element too: MDAnalysis
    opens a file with units="metal" as it is, and needs `convert_units=False` for one in meters.
    """

    suffixes: ClassVar = (".h5md",)

    @classmethod
    def missing(cls) -> str | None:
        """The instruction to install h5py, if it is missing; otherwise None."""
        from importlib.util import find_spec

        return None if find_spec("h5py") else "H5MD needs h5py: pip install 'physcore[hdf5]'; a .xyz needs nothing"

    def write(self, job: ExportJob, target: Path) -> None:
        """Write all frames."""
        import h5py

        with replacing(target) as temporary:
            disk = _Disk(temporary)
            with h5py.File(disk, "w", libver="v110") as file:
                _describe(file, job)
                series = _Series(file, job.count, _edges(job.domain), _element_units(job.units))
                for sample in job.samples():
                    series.put(sample)
                    disk.check()
            disk.check()


class _Disk:
    """File object that records its errors instead of raising them.

    HDF5 would print some errors and lose others, such as those at the end of the file. The writer calls `check`.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._failure: OSError | None = None
        self.read, self.seek, self.tell = file.read, file.seek, file.tell

    def check(self) -> None:
        """Raise the first recorded error, if any."""
        if self._failure is not None:
            raise self._failure

    def write(self, content: bytes) -> int:
        """Write the content; record an error."""
        self._try(self._file.write, content)
        return len(content)

    def truncate(self, size: int | None = None) -> int:
        """Truncate or extend the file; record an error."""
        self._try(self._file.truncate, size)
        return size or 0

    def flush(self) -> None:
        """Flush the buffers to the system; record an error."""
        self._try(self._file.flush)

    def _try(self, action: Callable[..., object], *arguments: object) -> None:
        try:
            action(*arguments)
        except OSError as error:
            self._failure = self._failure or error


def _describe(file: h5py.File, job: ExportJob) -> None:
    """Write all constants."""
    head = file.create_group("h5md")
    head.attrs["version"] = np.array([1, 1], dtype=np.int32)
    head.create_group("author").attrs["name"] = "physcore"
    creator = head.create_group("creator")
    creator.attrs["name"], creator.attrs["version"] = "physcore", version()
    file.create_group("parameters/units").attrs.update(_units(job))
    if _element_units(job.units):
        head.create_group("modules/units").attrs["version"] = np.array([1, 0], dtype=np.int32)
    group = file.create_group("particles/all")
    edges, box = _edges(job.domain), group.create_group("box")
    box.attrs["dimension"] = np.int32(3)
    box.attrs["boundary"] = ["periodic" if np.isfinite(length) else "none" for length in edges]
    for name, values in job.constants.items():
        group.create_dataset(name, data=values)
    group.create_dataset("species", data=job.body)
    file.create_group("observables")


def _units(job: ExportJob) -> dict[str, str]:
    """The units by quantity in H5MD's notation, in which m s-1 is m/s; without those of numbers."""
    symbols = {quantity: job.units.symbol(unit) for quantity, unit in UNITS.items()} | {"energy": job.energy_unit}
    powers = {quantity: powers_of(symbol) for quantity, symbol in symbols.items()}
    return {
        quantity: " ".join(f"{symbol}{'' if power == 1 else power}" for symbol, power in factors.items())
        for quantity, factors in powers.items()
        if factors
    }


def _element_units(units: UnitSystem) -> dict[str, str]:
    """The units that are stored at elements, by the last part of their names; none where MDAnalysis knows none."""
    length, time = KNOWN.get((units.length.symbol, units.time.symbol)), units.time.symbol
    return {"time": time, "position": length, "velocity": f"{length} {time}-1", "edges": length} if length else {}


def _edges(domain: Periodic | None) -> FloatArray:
    """The period along each axis [m], shape (3,); inf along an axis that is not periodic."""
    lengths = np.full(3, np.inf)
    if domain is not None:
        lengths[: domain.dimension] = domain.lengths
    return lengths


class _Series:
    """Time-dependent elements. Their data sets are created with the first frame, and filled frame by frame."""

    def __init__(self, file: h5py.File, count: int, edges: FloatArray, units: dict[str, str]) -> None:
        self._file, self._count, self._units = file, count, units
        # The edges are constant, but MDAnalysis reads only time-dependent ones.
        self._edges = np.where(np.isfinite(edges), edges, 1.0) if np.isfinite(edges).any() else None
        self._values: dict[str, Any] = {}

    def put(self, sample: Sample) -> None:
        """Add a frame."""
        arrays = {
            "position": sample.positions,
            "velocity": sample.velocities,
            **sample.fields,
            **sample.turns,
            "box/edges": self._edges,
        }
        for name, array in arrays.items():
            if array is not None:
                self._store(f"particles/all/{name}", sample.index, sample.time, array)
        for name in ENERGIES:
            self._store(f"observables/{name}_energy", sample.index, sample.energy.time, np.float64(sample.energy[name]))
        if sample.energy.temperature is not None:
            self._store(
                "observables/temperature", sample.index, sample.energy.time, np.float64(sample.energy.temperature)
            )

    def _store(self, path: str, index: int, time: float, value: Any) -> None:
        if path not in self._values:
            self._begin(path, np.shape(value))
        self._values[path][index] = value
        self._file[path]["time"][index] = time

    def _begin(self, path: str, shape: tuple[int, ...]) -> None:
        """Create an element. All elements that are sampled together share the data sets of step and time."""
        group, parent = self._file.create_group(path), path.partition("/")[0]
        self._values[path] = group.create_dataset("value", (self._count, *shape), dtype="<f8")
        unit = self._units.get(path.rpartition("/")[2])
        if unit is not None:
            self._values[path].attrs["unit"] = unit
        first = next(name for name in self._values if name.startswith(parent))
        if first == path:
            group.create_dataset("step", data=np.arange(self._count))
            times = group.create_dataset("time", (self._count,), dtype="<f8")
            if self._units:
                times.attrs["unit"] = self._units["time"]
        else:
            group["step"], group["time"] = self._file[first]["step"], self._file[first]["time"]
