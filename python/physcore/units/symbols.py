"""Symbols of units: their values in SI, and their dimensions."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Final, Literal, TypeAlias

from physcore.units import constants

Kind: TypeAlias = Literal["length", "time", "mass", "charge"]
Dimension: TypeAlias = Mapping[str, int]
"""Exponents of base units by symbol; of the SI's, or of others that are the same in every system, such as K."""

SYMBOLS: Final[Mapping[Kind, Mapping[str, float]]] = {
    "length": {
        "fm": 1e-15,
        "pm": 1e-12,
        "nm": 1e-9,
        "µm": 1e-6,
        "mm": 1e-3,
        "cm": 1e-2,
        "m": 1.0,
        "km": 1e3,
        "AU": constants.AU,
        "ly": constants.light_year,
        "pc": constants.parsec,
        "kpc": 1e3 * constants.parsec,
        "Mpc": 1e6 * constants.parsec,
        "R⊕": constants.earth_radius,
        "R☉": constants.solar_radius,
    },
    "time": {
        "fs": 1e-15,
        "ps": 1e-12,
        "ns": 1e-9,
        "µs": 1e-6,
        "ms": 1e-3,
        "s": 1.0,
        "min": constants.minute,
        "h": constants.hour,
        "d": constants.day,
        "yr": constants.year,
        "kyr": 1e3 * constants.year,
        "Myr": 1e6 * constants.year,
        "Gyr": 1e9 * constants.year,
    },
    "mass": {
        "mₑ": constants.electron_mass,
        "u": constants.atomic_mass,
        "mₚ": constants.proton_mass,
        "mg": 1e-6,
        "g": 1e-3,
        "kg": 1.0,
        "t": 1e3,
        "M⊕": constants.earth_mass,
        "M♃": constants.jupiter_mass,
        "M☉": constants.solar_mass,
    },
    "charge": {"e": constants.elementary_charge, "nC": 1e-9, "µC": 1e-6, "mC": 1e-3, "C": 1.0},
}
"""Values [SI] of units by kind and symbol, in increasing order for films; those of radii of bodies come last."""

DERIVED: Final[Mapping[str, Dimension]] = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "Hz": {"s": -1},
    "V": {"kg": 1, "m": 2, "s": -2, "C": -1},
    "T": {"kg": 1, "s": -1, "C": -1},
}
"""Dimensions of the derived units of the SI."""

BASE: Final[Mapping[str, Kind]] = {"kg": "mass", "m": "length", "s": "time", "C": "charge"}
"""Base units, in the order in which products have them. Charge takes the place of the SI's current."""

OTHERS: Final = ("K", "mol")
"""Base units that are the same in every system."""

POWERS: Final = "⁰¹²³⁴⁵⁶⁷⁸⁹"


def powers_of(unit: str) -> Dimension:
    """The exponents in a unit by symbol, as it is written: in "kg·m/s", or "m³/(kg·s²)"; empty for "1"."""
    found: dict[str, int] = {}
    above, _, below = unit.partition("/")
    for part, sign in ((above, 1), (below.strip("()"), -1)):
        for factor in part.split("·"):
            symbol = factor.rstrip(POWERS)
            digits = "".join(str(POWERS.index(digit)) for digit in factor[len(symbol) :])
            if symbol not in ("", "1"):
                found[symbol] = found.get(symbol, 0) + sign * int(digits or 1)
    return found


@cache
def dimension_of(unit: str) -> Dimension:
    """The dimension of a unit of the SI: its exponents with derived units, such as N, in base units."""
    found: dict[str, int] = {}
    for symbol, power in powers_of(unit).items():
        for base, exponent in DERIVED.get(symbol, {symbol: 1}).items():
            found[base] = found.get(base, 0) + power * exponent
    return {symbol: exponent for symbol, exponent in found.items() if exponent}


def raised(symbol: str, exponent: int) -> str:
    """A symbol with an exponent as a superscript: m²."""
    return symbol if exponent == 1 else symbol + "".join(POWERS[int(digit)] for digit in str(exponent))
