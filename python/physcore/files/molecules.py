"""Reading of atoms and molecules by ASE."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from physcore.checks import FloatArray, count, number, shown
from physcore.errors import FileError, SceneError, SceneWarning, warn
from physcore.files.reader import Options, Reader, reading
from physcore.scene.atoms import Atoms
from physcore.scene.periodic import Periodic
from physcore.units import constants
from physcore.units.styles import STYLES, unit_system
from physcore.units.systems import UnitSystem, dimensionless, system

FORMATS = {
    **{".xyz": "extxyz", ".extxyz": "extxyz", ".gro": "gromacs", ".pdb": "proteindatabank"},
    **{".data": "lammps-data", ".lmp": "lammps-data", ".lammps": "lammps-data"},
    **{".dump": "lammps-dump-text", ".lammpstrj": "lammps-dump-text"},
}
"""Formats of ASE by suffix."""
LAMMPS = ("metal", "real", "si", "cgs", "electron", "micro", "nano", "lj")
"""Units of LAMMPS that are converted, and "lj" which are none."""
HEAD = 4096
"""Characters of a file that may name its units."""
ANGSTROM = 1e-10
"""Unit of length of ASE [m]."""
VELOCITIES = ("velo", "vel", "velocity", "velocities")
"""Names of the columns of velocities in extended XYZ."""
TILT = 1e-9
"""Largest component of the edges of a cell along other axes, relative to the edges, for it to be rectangular."""


class MoleculeReader(Reader):
    """Reader of atoms and molecules."""

    kind: ClassVar = "files of atoms"
    package: ClassVar = "ase"
    options: ClassVar = ("unit", "units", "frame", "masses")
    suffixes: ClassVar = tuple(FORMATS)

    def read(self, path: Path, suffix: str, options: Options) -> Atoms:
        """One frame of a file."""
        kind = FORMATS[suffix]
        with reading(path, "ASE"), open(path, encoding="utf-8", errors="replace") as file:
            head = file.read(HEAD)
        if kind == "extxyz":
            found = _from_xyz(path, head, options)
        elif kind.startswith("lammps"):
            found = _from_lammps(path, kind, head, options)
        else:
            if options.unit is not None:
                raise SceneError(f"read.unit: {path} has units by its format; leave unit= out")
            found = _Read(path, _image(path, kind, options), STYLES["metal"].units, is_ase=True)
        return found.atoms(options)


class _Read:
    """An image of ASE, and what its numbers mean."""

    def __init__(self, path: Path, image: Any, units: UnitSystem, *, is_ase: bool, by_type: bool = False) -> None:
        self.path, self.image, self.units = path, image, units
        self.is_ase = is_ase
        """Whether the numbers are in units of ASE; otherwise they are as in the file."""
        results = image.calc.results if image.calc else {}
        arrays = {**image.arrays, **{name: results[name] for name in ("charges",) if name in results}}
        self.species = tuple(map(str, arrays["type"] if by_type else image.get_chemical_symbols()))
        """Elements, or types of LAMMPS where nothing tells the elements."""
        masses = next((arrays[name] for name in ("mass", "masses") if name in arrays), None)
        self.masses: FloatArray | None = None if masses is None else np.asarray(masses, dtype=np.float64)
        charges = next((arrays[name] for name in ("charge", "initial_charges", "charges") if name in arrays), None)
        self.charges = np.zeros(len(image)) if charges is None else np.asarray(charges, dtype=np.float64)
        self.velocities = self._velocities()

    def _velocities(self) -> FloatArray:
        """The velocities, in the units of length and time of the image."""
        import ase.units

        arrays = self.image.arrays
        named = next((arrays[name] for name in VELOCITIES if name in arrays), None)
        if named is not None:
            return np.asarray(named, dtype=np.float64)
        if "momenta" not in arrays:
            return np.zeros((len(self.image), 3))
        if not self.is_ase and self.units not in (STYLES["metal"].units, STYLES["real"].units, dimensionless):
            raise SceneError(f'{self.path}: has momenta in units of ASE, which go with unit="metal" alone')
        # Of ASE in Å/(its unit of time), of "metal" in Å/ps.
        per_time = ase.units.fs if self.units == STYLES["real"].units else 1e3 * ase.units.fs
        return np.asarray(self.image.get_velocities() * per_time, dtype=np.float64)

    def atoms(self, options: Options) -> Atoms:
        """The atoms, in the units that are asked for."""
        units = dimensionless if self.units.is_dimensionless else options.units
        if units is not options.units and not options.units.is_si:
            raise SceneError(f'read.units: {self.path} is without units, as all with unit="lj"; leave units= out')
        length, speed, mass, charge = (_factor(self.units, units, unit) for unit in ("m", "m/s", "kg", "C"))
        image = self.image
        masses = self._masses(options, mass)
        domain = _domain(image, self.path, length)
        positions = length * np.asarray(image.positions, dtype=np.float64)
        return Atoms(
            positions if domain is None else domain.wrap(positions),
            self.species,
            speed * self.velocities,
            masses,
            charge * self.charges,
            name=None,
            bonds=_bonds(image),
            domain=domain,
            units=units,
        )

    def _masses(self, options: Options, factor: float) -> FloatArray:
        """The masses: those given, those of the file, or those of the elements."""
        from ase.data import atomic_masses, atomic_numbers

        given = {} if options.masses is None else options.masses
        if not isinstance(given, Mapping):
            raise SceneError(f'read.masses: must be a mapping such as {{"Ar": 6.6e-26}}, got {shown(given)}')
        for species in given:
            if species not in self.species:
                raise SceneError(
                    f"read.masses: {species!r} is none of the species {tuple(dict.fromkeys(self.species))}"
                )
        result = np.zeros(len(self.species)) if self.masses is None else factor * self.masses
        in_u = 0.0 if self.units.is_dimensionless else options.units.convert(constants.atomic_mass, "kg")
        for species in dict.fromkeys(self.species):
            rows = np.array([each == species for each in self.species])
            if species in given:
                result[rows] = number(given[species], f"read.masses[{species!r}]", above=0.0)
            elif self.masses is None:
                element = atomic_numbers.get(species, 0)
                if not element or not in_u:
                    raise SceneError(
                        f"read.masses: {self.path} does not say what an atom {species!r} weighs; give "
                        f"masses={{{species!r}: …}} [{options.units.mass.symbol or '1'}]"
                    )
                result[rows] = in_u * atomic_masses[element]
        return result


def _from_xyz(path: Path, head: str, options: Options) -> _Read:
    """A frame of extended XYZ, in the units that the file names or that are given."""
    named = re.search(r'Units="([^"]*)"', head)
    if options.unit is not None:
        units = dimensionless if options.unit == "lj" else unit_system(options.unit, "read.unit")
    elif named is None:
        raise SceneError(
            f'read.unit: {path} does not name its units; most programs write unit="metal" (Å, ps, u, e), others '
            f"{', '.join(map(repr, STYLES))} or a pc.units.system(…)"
        )
    else:
        units = _named(named[1], path)
    return _Read(path, _image(path, "extxyz", options), units, is_ase=False)


def _named(text: str, path: Path) -> UnitSystem:
    """The system of units that a file of physcore names."""
    if text == "none":
        return dimensionless
    parts = dict(part.split("=", 1) for part in text.split() if "=" in part)
    try:
        return system(**{kind: (ANGSTROM, "Å") if symbol == "Å" else symbol for kind, symbol in parts.items()})
    except (SceneError, TypeError) as error:
        raise SceneError(f"read.unit: {path} has the units {text!r}, which are not known; give unit=") from error


def _from_lammps(path: Path, kind: str, head: str, options: Options) -> _Read:
    """A frame of LAMMPS, in the units that the file names or that are given."""
    found = re.search(r"units\s*=\s*(\w+)|ITEM: UNITS\s+(\w+)", head)
    named = (found[1] or found[2]) if found else None
    given = named if options.unit is None else options.unit
    if given is None:
        raise SceneError(f"read.unit: {path} does not name its units; give the `units` of its LAMMPS input: {LAMMPS}")
    if not isinstance(given, str) or given not in LAMMPS:
        raise SceneError(f"read.unit: must be one of {', '.join(map(repr, LAMMPS))} for LAMMPS, got {shown(given)}")
    # Of LAMMPS's "metal" ASE converts the time alone, and _Read takes that back.
    style = "metal" if given == "lj" else given
    more: dict[str, Any] = {"units": style}
    if kind == "lammps-data":
        more |= {"read_image_flags": False}
    image = _image(path, kind, options, **more)
    if kind == "lammps-data":
        _complete(image, head, style)
    if given == "lj" and "masses" in image.arrays:
        image.arrays["masses"] /= _converted(1.0, "mass", style)  # which is 1 but for the digits of its tables
    columns = re.search(r"ITEM: ATOMS (.*)", head)
    elements = bool({"element", "mass"} & set(columns[1].split())) if columns else "masses" in image.arrays
    units = dimensionless if given == "lj" else STYLES["metal"].units
    by_type = "type" in image.arrays and (given == "lj" or not elements)
    return _Read(path, image, units, is_ase=True, by_type=by_type)


def _converted(values: Any, quantity: str, style: str) -> Any:
    """Numbers in units of LAMMPS in those of ASE."""
    from ase.calculators import lammps

    convert: Any = lammps.convert
    return convert(values, quantity, style, "ASE")


def _complete(image: Any, head: str, style: str) -> None:
    """Set the lower corner of a data file of LAMMPS, and convert charges, which ASE does not."""
    ends = [re.search(rf"^\s*(\S+)\s+\S+\s+{axis}lo\s+{axis}hi", head, re.MULTILINE) for axis in "xyz"]
    image.set_celldisp(_converted(np.array([float(each[1]) if each else 0.0 for each in ends]), "distance", style))
    if "initial_charges" in image.arrays:
        image.arrays["initial_charges"] = _converted(image.arrays["initial_charges"], "charge", style)


def _image(path: Path, kind: str, options: Options, **more: Any) -> Any:
    """One image of a file, read by ASE.

    Raises:
        SceneError: there is no such frame.
        FileError: the file cannot be read, or has no atoms.
    """
    import ase.io

    frame = count(options.frame, "read.frame", least=-(2**31))
    with reading(path, "ASE"):
        try:
            images = ase.io.read(path, index=frame if kind != "lammps-data" else None, format=kind, **more)
        except (IndexError, StopIteration):
            images = []
    image = images[0] if isinstance(images, list) and images else images
    if isinstance(image, list):
        raise SceneError(f"read.frame: {path} has no frame {frame}, or no complete one")
    if not len(image):
        raise FileError(f"{path}: has no atoms")
    return image


def _factor(units: UnitSystem, target: UnitSystem, unit: str) -> float:
    """The factor from a unit of one system to that of another."""
    return 1.0 if units == target else target.convert(1.0, unit) / units.convert(1.0, unit)


def _domain(image: Any, path: Path, factor: float) -> Periodic | None:
    """The periodic cell; None, with a warning, if it is not rectangular."""
    edges = factor * np.asarray(image.cell, dtype=np.float64)
    periodic = np.asarray(image.pbc, dtype=bool) & (np.abs(edges).max(axis=1) > 0.0)
    if not periodic.any():
        return None
    if np.abs(edges - np.diag(np.diag(edges))).max() > TILT * np.abs(edges).max():
        warn(f"{path}: its cell is not rectangular, which Periodic is not; domain is None", SceneWarning)
        return None
    lower = factor * np.asarray(image.info.get("Origin", image.get_celldisp().ravel()), dtype=np.float64)
    upper = lower + np.diag(edges)
    return Periodic(np.where(periodic, lower, -np.inf).tolist(), np.where(periodic, upper, np.inf).tolist())


def _bonds(image: Any) -> list[tuple[int, int]] | None:
    """The pairs of bonded atoms, from ASE's texts such as "3(1),5(2)" at the first atom of each bond."""
    texts = image.arrays.get("bonds")
    if texts is None:
        return None
    return [(atom, int(other)) for atom, text in enumerate(texts) for other in re.findall(r"(\d+)\(", str(text))]
