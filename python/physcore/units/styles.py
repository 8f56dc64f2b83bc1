"""Systems of units of programs for atoms, by the names that these programs give them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from physcore.errors import SceneError
from physcore.spelling import did_you_mean
from physcore.units import constants
from physcore.units.systems import SI, UnitSystem, system

ANGSTROM: Final = (1e-10, "Å")
"""Ångström, as an argument of `system`."""
CALORIE: Final = 4.184
"""Thermochemical calorie [J], exact."""
AVOGADRO: Final = 6.02214076e23
"""Avogadro constant [1/mol], exact."""


@dataclass(frozen=True)
class Style:
    """Units of a program for atoms. Its unit of energy need not follow from the others."""

    units: UnitSystem
    """Units of length, time, mass and charge."""
    energy: float
    """Unit of energy [J]."""
    energy_symbol: str
    """Symbol of the unit of energy."""


STYLES: Final[Mapping[str, Style]] = {
    "si": Style(SI, 1.0, "J"),
    "metal": Style(system(ANGSTROM, "ps", "u", "e"), constants.electron_volt, "eV"),
    "real": Style(system(ANGSTROM, "fs", "u", "e"), 1e3 * CALORIE / AVOGADRO, "kcal/mol"),
    "gromacs": Style(system("nm", "ps", "u", "e"), 1e3 / AVOGADRO, "kJ/mol"),
}
"""Units by name. "metal", "real" and "si" are those of LAMMPS.

Source: A. P. Thompson et al., Comput. Phys. Commun. 271, 108171 (2022), and the LAMMPS manual, command `units`.
"""


ATOMS = ("metal", "real", "gromacs")
"""Styles of programs for atoms."""


def style_of(value: object, path: str) -> Style:
    """The style of a name, or one of a system of units, whose unit of energy follows from the others.

    Raises:
        SceneError: the value is neither.
    """
    if isinstance(value, str) and value in STYLES:
        return STYLES[value]
    units = unit_system(value, path)
    return Style(units, 1.0 if units.is_dimensionless else 1.0 / units.convert(1.0, "J"), units.symbol("J"))


def unit_system(value: object, path: str) -> UnitSystem:
    """A system of units, given itself or by the name of a style.

    Raises:
        SceneError: it is neither.
    """
    if isinstance(value, UnitSystem):
        return value
    if isinstance(value, str) and value in STYLES:
        return STYLES[value].units
    names = ", ".join(map(repr, STYLES))
    got = repr(value) if isinstance(value, str) else f"something of the type {type(value).__name__}"
    raise SceneError(f"{path}: must be {names} or pc.units.system(…), got {got}{did_you_mean(value, STYLES)}")
