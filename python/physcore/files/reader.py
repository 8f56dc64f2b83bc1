"""Base class of readers, and the options given to them."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ClassVar

from physcore.checks import shown, span
from physcore.errors import FileError, PhyscoreError, SceneError
from physcore.spelling import did_you_mean
from physcore.storage.formats import Format
from physcore.units.constants import UNITS
from physcore.units.symbols import SYMBOLS
from physcore.units.systems import SI, UnitSystem


@dataclass(frozen=True)
class Options:
    """Options of `read`, of which each kind of file takes some."""

    unit: object = None
    """Unit of the numbers of the file."""
    units: UnitSystem = SI
    """Units of the result."""
    up: str | None = None
    """Axis of the file that points up."""
    frame: int = 0
    """Index of the frame of a trajectory."""
    masses: Mapping[str, float] | None = None
    """Masses by species, in `units`."""

    def only(self, known: tuple[str, ...], kind: str) -> None:
        """Check that no other options are given.

        Raises:
            SceneError: there are others.
        """
        for entry in fields(self):
            if entry.name not in known and getattr(self, entry.name) is not entry.default:
                raise SceneError(f"read.{entry.name}: has no meaning for {kind}; leave it out")


class Reader(Format, ABC):
    """Base class of readers: what they read, by which package."""

    kind: ClassVar[str]
    """Content of the files, for messages: "meshes"."""
    package: ClassVar[str | None] = None
    """Package that must be installed; None: none."""
    options: ClassVar[tuple[str, ...]] = ()
    """Names of the options that have a meaning."""

    @classmethod
    def missing(cls) -> str | None:
        """A sentence on the package that must be installed first; None if none is missing."""
        if cls.package is None or find_spec(cls.package):
            return None
        return f"{cls.kind} need {cls.package}: pip install 'physcore[files]'"

    def open(self, path: Path, suffix: str, options: Options) -> Any:
        """Read a file, after a check of the options and the package.

        Raises:
            SceneError: an option is not valid.
            FileError: the file cannot be read.
            PhyscoreError: a package is missing.
        """
        options.only(self.options, self.kind)
        missing = self.missing()
        if missing is not None:
            raise PhyscoreError(f"{path}: {missing}")
        if not path.is_file():
            raise FileError(f"{path}: {'is a folder' if path.is_dir() else 'there is no such file'}")
        return self.read(path, suffix, options)

    @abstractmethod
    def read(self, path: Path, suffix: str, options: Options) -> Any:
        """The content of a file."""


@contextmanager
def reading(path: Path, package: str) -> Iterator[None]:
    """Convert all errors of a package to a FileError with the path. Its warnings are ignored."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except PhyscoreError:
        raise
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror or error}") from error
    except Exception as error:
        what = " ".join(str(error).split())[:200] or type(error).__name__
        raise FileError(f"{path}: is damaged or of another kind, says {package}: {what}") from error


def length_unit(given: object, path: str) -> float:
    """A unit of length in meters, from a symbol or the name of a constant, a number of meters, or a pair of both.

    Raises:
        SceneError: it is none.
    """
    if isinstance(given, tuple) and len(given) == 2:
        given = given[0]
    if not isinstance(given, str):
        return span(given, path)
    name = ALIASES.get(given, given)
    known = {**SYMBOLS["length"], "Å": 1e-10, "in": 0.0254, "ft": 0.3048}
    constants = {name: unit for name, unit in UNITS.items() if unit == "m"}
    if name in known:
        return known[name]
    if name in constants:
        from physcore.units import constants as values

        return float(getattr(values, name))
    raise SceneError(
        f"{path}: must be a unit of length, one of {', '.join(known)}, or its number of meters, got {shown(given)}"
        f"{did_you_mean(given, known)}"
    )


ALIASES = {
    **{"meter": "m", "meters": "m", "metre": "m", "metres": "m", "millimeter": "mm", "millimeters": "mm"},
    **{"centimeter": "cm", "centimeters": "cm", "micron": "µm", "microns": "µm", "um": "µm", "kilometers": "km"},
    **{"inch": "in", "inches": "in", "feet": "ft", "foot": "ft", "Angstrom": "Å", "angstrom": "Å"},
}
"""Other names of units of length, as files and packages have them."""


def scale(units: UnitSystem, unit: str) -> float:
    """The factor from a unit of the SI to that of a system."""
    return units.convert(1.0, unit)
