"""Tables of columns with names, from text."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from physcore.checks import FloatArray, frozen, shown
from physcore.entrance import entrance
from physcore.errors import FileError, SceneError
from physcore.files.reader import Options, Reader
from physcore.scene.bodies import Particles
from physcore.spelling import did_you_mean
from physcore.units.styles import unit_system
from physcore.units.symbols import BASE, DERIVED, SYMBOLS, dimension_of, powers_of
from physcore.units.systems import SI, UnitSystem

HEADING = re.compile(r"\s*(?P<name>.*?)\s*(?:[\[(](?P<unit>[^\])]*)[\])])?\s*")
"""Heading of a column: its name, and its unit in brackets if it has one."""
COLUMNS: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "positions": ("m", ("x", "y", "z")),
    "velocities": ("m/s", ("vx", "vy", "vz")),
    "mass": ("kg", ("mass",)),
    "charge": ("C", ("charge",)),
    "radius": ("m", ("radius",)),
}
"""Units and names of the columns that particles are made of."""


class Table(Mapping[str, NDArray[Any]]):
    """Columns of a file of text by their names: numbers as in the file, or texts.

        stars: pc.Table = pc.read("stars.csv")  # with the heading: x [AU], y [AU], mass [M☉], name
        stars["x"], stars.units["x"], list(stars)
        scene = pc.Scene(stars.particles(), pc.Gravitation())

    A heading may have the unit of its column in brackets. `pandas.DataFrame(table)` is a data frame.

    Attributes:
        units: units of the columns by name, as written in the heading; without those that have none.
        path: the file.
    """

    def __init__(self, columns: Mapping[str, NDArray[Any]], units: Mapping[str, str], path: str) -> None:
        for given, name in ((columns, "columns"), (units, "units")):
            if not isinstance(given, Mapping):
                raise SceneError(f"Table.{name}: must be a mapping from the names of columns, got {shown(given)}")
        self._columns = {name: np.asarray(column) for name, column in columns.items()}
        self.units = dict(units)
        self.path = path

    def __getitem__(self, name: str) -> NDArray[Any]:
        """A column, shape (rows,)."""
        if name not in self._columns:
            names = tuple(self._columns)
            raise KeyError(f"{self.path} has the columns {names}, not {name!r}{did_you_mean(name, names)}")
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        rows = len(next(iter(self._columns.values()), ()))
        names = (f"{name} [{self.units[name]}]" if name in self.units else name for name in self)
        return f"Table({rows} rows of {', '.join(names)})"

    @entrance
    def particles(self, unit: UnitSystem | str | None = None, units: UnitSystem | str = SI, **fixed: Any) -> Particles:
        """Particles with the columns x, y and perhaps z, vx, vy, vz, mass, charge and radius.

            planets = pc.read("planets.csv").particles(unit=pc.units.system(length="AU", time="d", mass="M☉"))

        Args:
            unit: units of the columns without a unit in the heading, a system or the name of a style such as "si";
                None: each must have one.
            units: units of the result, for `Scene(units=…)`.
            fixed: further arguments of Particles, such as fixed, name or radius.

        Raises:
            SceneError: there is no column x or y, a column has no unit, or one of another quantity.
        """
        source = None if unit is None else unit_system(unit, "particles.unit")
        target = unit_system(units, "particles.units")
        found: dict[str, Any] = {}
        for field, (kind, names) in COLUMNS.items():
            columns = [self._number(name, kind, source, target) for name in names if name in self]
            if field == "positions" and not ("x" in self and "y" in self):
                raise SceneError(f"particles: {self.path} must have the columns x and y, and has {', '.join(self)}")
            if field == "velocities" and columns and len(columns) != found["positions"].shape[1]:
                raise SceneError(f"particles: {self.path} must have as many velocities as coordinates")
            if columns:
                found[field] = np.column_stack(columns) if len(names) > 1 else columns[0]
        return Particles(**{**found, **fixed})

    def _number(self, name: str, kind: str, source: UnitSystem | None, target: UnitSystem) -> FloatArray:
        """A column in units of a system."""
        values = self[name]
        if values.dtype.kind != "f":
            raise SceneError(f"particles: the column {name!r} of {self.path} must be numbers, got {shown(values[0])}")
        if name in self.units:
            return np.asarray(target.convert(_si(self.units[name], kind, f"{self.path}: {name}"), kind) * values)
        if source is None:
            raise SceneError(
                f"particles.unit: the column {name!r} of {self.path} has no unit; write it into the heading, as in "
                f'"{name} [{kind}]", or give unit="si" or pc.units.system(…)'
            )
        return (
            values if source == target else np.asarray(target.convert(1.0 / source.convert(1.0, kind), kind) * values)
        )


class TableReader(Reader):
    """Reader of tables of text."""

    kind: ClassVar = "tables"
    suffixes: ClassVar = (".csv", ".tsv", ".txt", ".dat")

    def read(self, path: Path, suffix: str, options: Options) -> Table:
        """All columns of a file."""
        del suffix, options
        try:
            lines = path.read_text("utf-8-sig").splitlines()
        except UnicodeDecodeError as error:
            raise FileError(f"{path}: is no text in UTF-8: {error.reason} at byte {error.start}") from error
        except OSError as error:
            raise FileError(f"{path}: cannot be read: {error.strerror or error}") from error
        numbered = [(number, line) for number, line in enumerate(lines, 1) if line.strip()]
        if numbered and numbered[0][1].startswith("#"):  # a heading as NumPy writes it
            numbered[0] = (numbered[0][0], numbered[0][1].lstrip("# "))
        numbered = [(number, line) for number, line in numbered if not line.lstrip().startswith("#")]
        if not numbered:
            raise FileError(f"{path}: is empty")
        rows = [(number, _cells(line, _delimiter(numbered[0][1]))) for number, line in numbered]
        return _table(rows, str(path))


class ArrayReader(Reader):
    """Reader of arrays of NumPy."""

    kind: ClassVar = "arrays"
    suffixes: ClassVar = (".npy", ".npz")

    def read(self, path: Path, suffix: str, options: Options) -> Any:
        """An array, or a mapping from names to arrays; objects are refused."""
        del suffix, options
        try:
            found = np.load(path, allow_pickle=False)
            return found if isinstance(found, np.ndarray) else {name: found[name] for name in found.files}
        except Exception as error:
            raise FileError(f"{path}: is no array of NumPy: {error}") from error


def _delimiter(line: str) -> str:
    """The separator of a line: a semicolon, a tab or a comma; a space if it has none of these."""
    bare = re.sub(r"\[[^\]]*\]|\([^)]*\)", "", line)
    return next((each for each in ";\t," if each in bare), " ")


def _cells(line: str, delimiter: str) -> list[str]:
    """The cells of a line."""
    if delimiter == " ":
        return re.sub(r"\s+([\[(])", r"\1", line).split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]


def _table(rows: list[tuple[int, list[str]]], path: str) -> Table:
    """A table from the cells of all lines, the first of which is the heading."""
    number, head = rows[0]
    if all(_value(cell) is not None for cell in head):
        raise FileError(
            f"{path}: line {number} must be a heading with the names of the columns, got {', '.join(head[:4])}; "
            "numpy.loadtxt reads numbers without names"
        )
    headings = [HEADING.fullmatch(cell) for cell in head]
    names = [found["name"] if found else "" for found in headings]
    if len(set(names)) < len(names) or not all(names):
        raise FileError(f"{path}: line {number} must have a different name for each column, got {', '.join(head)}")
    units = {found["name"]: found["unit"].strip() for found in headings if found and found["unit"]}
    for line, cells in rows[1:]:
        if len(cells) != len(names):
            raise FileError(f"{path}: line {line} has {len(cells)} cells, and the heading {len(names)}")
    columns = {}
    for place, name in enumerate(names):
        values = [_value(cells[place]) for _, cells in rows[1:]]
        wrong = next((row for row, value in enumerate(values) if value is None), None)
        if wrong is not None and any(value is not None for value in values):
            line, cells = rows[1 + wrong]
            raise FileError(f"{path}: line {line}, column {name!r}: must be a number, got {cells[place]!r}")
        texts = [cells[place] for _, cells in rows[1:]]
        columns[name] = frozen(np.array(texts if wrong is not None else values, dtype=None if texts else np.float64))
    return Table(columns, units, path)


def _value(cell: str) -> float | None:
    """The number in a cell, NaN if it is empty; None if it is no number."""
    try:
        return float(cell) if cell else math.nan
    except ValueError:
        return None


def _si(unit: str, kind: str, path: str) -> float:
    """The value of a unit in the SI.

    Raises:
        SceneError: it is unknown, or a unit of another quantity.
    """
    known = {symbol: (value, base) for base, each in _BASES.items() for symbol, value in each.items()}
    product, found = 1.0, dict[str, int]()
    for symbol, power in powers_of(unit).items():
        if symbol not in known and symbol not in DERIVED:
            raise SceneError(f"{path}: the unit {unit!r} is not known{did_you_mean(symbol, (*known, *DERIVED))}")
        value, base = known.get(symbol, (1.0, ""))
        for _ in range(abs(power)):
            product = product * value if power > 0 else product / value
        for each, exponent in ({base: 1} if base else DERIVED[symbol]).items():
            found[each] = found.get(each, 0) + power * exponent
    if {each: exponent for each, exponent in found.items() if exponent} != dict(dimension_of(kind)):
        raise SceneError(f"{path}: must be a unit as {kind}, got {unit!r}")
    return product


_BASES = {base: {**SYMBOLS[kind], **({"Å": 1e-10} if kind == "length" else {})} for base, kind in BASE.items()}
"""Values of units in the SI, by base unit and symbol."""
