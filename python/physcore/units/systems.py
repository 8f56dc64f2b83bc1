"""Systems of units: the units in which the numbers of a scene are."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, cached_property
from numbers import Real
from typing import Final, TypeAlias, TypeGuard

from physcore.entrance import entrance
from physcore.errors import PhyscoreError, SceneError, SimulationDiverged
from physcore.spelling import did_you_mean
from physcore.units import constants
from physcore.units.symbols import BASE, DERIVED, OTHERS, POWERS, SYMBOLS, Kind, dimension_of, powers_of, raised

Given: TypeAlias = float | str | tuple[float, str]
"""Unit as an argument: a constant, a symbol or the name of a constant, or a value [SI] with a symbol."""

FORBIDDEN = f"·/^()[]{{}},;:'\"{POWERS}"
"""Characters that no symbol may contain, because they form products of symbols and sentences."""
LONGEST = 16
"""Most characters of a symbol."""


@dataclass(frozen=True)
class Unit:
    """Unit of length, time, mass or charge."""

    symbol: str
    """Symbol, such as "AU"; empty in a dimensionless system."""
    value: float | None
    """Value [SI]; None in a dimensionless system."""


@dataclass(frozen=True, repr=False)
class UnitSystem:
    """System of units, in which the numbers of a scene are.

        astronomical = pc.units.system(length=pc.units.AU, time=pc.units.day, mass=pc.units.solar_mass)
        astronomical.gravitational_constant  # 2.959e-4 AU³/(M☉·d²)
        astronomical.year  # 365.25 d

    `system` makes one; `SI` and `dimensionless` are two. It is immutable and compared by value. The constants of
    `pc.units` are attributes, in units of the system.

    Raises:
        SceneError: a symbol is not valid or means another unit, or some units have a value and others none.
    """

    length: Unit
    """Unit of length."""
    time: Unit
    """Unit of time."""
    mass: Unit
    """Unit of mass."""
    charge: Unit = field(default=Unit("C", 1.0))
    """Unit of charge."""

    def __post_init__(self) -> None:
        units = {kind: getattr(self, kind) for kind in SYMBOLS}
        if all(unit == Unit("", None) for unit in units.values()):
            return
        for kind, unit in units.items():
            _check(kind, unit.symbol, unit.value)
        symbols = [unit.symbol for unit in units.values()]
        if len(set(symbols)) < len(symbols):
            raise SceneError(f"units: must have different symbols, got {', '.join(symbols)}")

    @cached_property
    def is_si(self) -> bool:
        """Whether these are the units of the SI."""
        return self == SI

    @cached_property
    def is_dimensionless(self) -> bool:
        """Whether numbers have no units."""
        return self.length.value is None

    @property
    def named(self) -> str:
        """The units by kind, as in the comment of a file: "length=AU time=d mass=M☉ charge=C"."""
        return " ".join(f"{kind}={getattr(self, kind).symbol}" for kind in SYMBOLS) if self.length.value else "none"

    def symbol(self, unit: str) -> str:
        """The symbol of this system for a unit of the SI: "AU/d" for "m/s"; empty in a dimensionless system."""
        return unit if self.is_si else _symbol(self, unit)

    def suffix(self, unit: str) -> str:
        """The symbol as it follows a number, " AU/d"; empty in a dimensionless system."""
        symbol = self.symbol(unit)
        return f" {symbol}" if symbol else ""

    @property
    def per(self) -> str:
        """The unit of time as it follows "per": "second", "d", or "unit of time" in a dimensionless system."""
        return "second" if self.time.symbol == "s" else self.time.symbol or "unit of time"

    def label(self, quantity: str, unit: str) -> str:
        """A quantity with its unit in brackets, "speed [AU/d]"; without brackets in a dimensionless system."""
        symbol = self.symbol(unit)
        return f"{quantity} [{symbol}]" if symbol else quantity

    @entrance
    def convert(self, value: float, unit: str) -> float:
        """A value of the SI in units of this system.

            atomic = pc.units.system(length="nm", time="ps", mass="u")
            atomic.convert(300.0, "m/s")  # 0.3 nm/ps

        Args:
            value: the value.
            unit: its unit in the SI, such as "m/s", "kg/m³" or "N·m²/C²".

        Raises:
            SceneError: the system is dimensionless, an argument is not valid, or the result is beyond the range of
                numbers.
        """
        if not _is_number(value) or not math.isfinite(value):
            raise SceneError(f"convert.value: must be a finite number, got {value!r}")
        _check_unit(unit)
        if self.is_dimensionless:
            raise SceneError(f"units: {value:g} {unit} have no value in a dimensionless system")
        powers = {BASE[base]: power for base, power in dimension_of(unit).items() if base in BASE}
        scales = [(getattr(self, kind).value, power) for kind, power in powers.items()]
        above = math.prod(scale for scale, power in scales for _ in range(-power))
        below = math.prod(scale for scale, power in scales for _ in range(power))
        result = value * above / below if 0.0 < below < math.inf else math.inf
        if not math.isfinite(result) or (result == 0.0) != (value == 0.0):
            raise SceneError(f"units: {value:g} {unit} are beyond the range of numbers in the units {self}")
        return result

    def reworded(self, text: str) -> str:
        """A message with symbols of this system in place of those of the SI: "3 d" for "3 s".

        Numbers stay. So do names in quotes and the messages of exceptions that user functions raised.
        """
        return text if self.is_si else _pattern().sub(self._reworded, text)

    def _reworded(self, found: re.Match[str]) -> str:
        """The text in place of a match of `_pattern`."""
        if found["kept"]:
            return found[0]
        if found["rate"]:
            return f"/{self.time.symbol}" if self.time.symbol else ""
        return self.label("", found["inner"]) if found["inner"] else self.suffix(found["unit"])

    @contextmanager
    def worded(self) -> Iterator[None]:
        """Reword the errors that are raised within."""
        try:
            yield
        except PhyscoreError as error:
            error.args = tuple(self.reworded(each) if isinstance(each, str) else each for each in error.args)
            if isinstance(error, SimulationDiverged):
                error.cause, error.hint = self.reworded(error.cause), self.reworded(error.hint)
            raise

    def __getattr__(self, name: str) -> float:
        """A constant of `pc.units` in units of this system."""
        if name not in constants.UNITS:
            raise AttributeError(f"no unit or constant {name!r}{did_you_mean(name, constants.UNITS)}")
        try:
            return self.convert(getattr(constants, name), constants.UNITS[name])
        except SceneError as error:  # hasattr, inspection and completion expect an AttributeError
            raise AttributeError(str(error)) from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(name for name in constants.UNITS if hasattr(self, name))]

    def __str__(self) -> str:
        """The symbols of all units."""
        return "none" if self.is_dimensionless else ", ".join(getattr(self, kind).symbol for kind in SYMBOLS)

    def __repr__(self) -> str:
        if self.is_si or self.is_dimensionless:
            return f"units.{'SI' if self.is_si else 'dimensionless'}"
        own = {kind: getattr(self, kind) for kind in SYMBOLS}
        given = [f"{kind}=({unit.value!r}, {unit.symbol!r})" for kind, unit in own.items() if unit != getattr(SI, kind)]
        return f"units.system({', '.join(given)})"


class Default(float):
    """Default of an argument in the SI, which a scene with other units converts.

    Values that users give are in the units of their scenes. They are ordinary floats, so that the two differ in type.
    """

    unit: str
    """Unit in the SI."""

    def __new__(cls, value: float, unit: str) -> Default:
        """Make a default of a value and its unit."""
        default = super().__new__(cls, value)
        default.unit = unit
        return default

    def __getnewargs__(self) -> tuple[float, str]:  # type: ignore[override]  # for copies and pickles
        return float(self), self.unit

    def converted(self, units: UnitSystem, path: str) -> float:
        """The value in units of a scene.

        Raises:
            SceneError: the scene is dimensionless.
        """
        if units.is_dimensionless:
            raise SceneError(
                f"{path}: must be given, because this scene is without units and the default is {float(self):g} "
                f"in {self.unit}"
            )
        return units.convert(self, self.unit)


@entrance
def system(length: Given = "m", time: Given = "s", mass: Given = "kg", charge: Given = "C") -> UnitSystem:
    """A system of units for scenes: `pc.Scene(…, units=system)`.

        pc.units.system(length=pc.units.AU, time=pc.units.day, mass=pc.units.solar_mass)
        pc.units.system(length="nm", time="ps", mass="u", charge="e")
        pc.units.system(length=(0.3048, "ft"))

    The numbers of a scene with these units are in them. The engine computes with the numbers as they are. Labels,
    tables and messages have the symbols of the units. Units that are not given are those of the SI.

    Args:
        length, time, mass, charge: constants of `pc.units`, as `pc.units.day`; or symbols or names of constants,
            such as "km", "d" or "solar_mass"; or pairs of a value [SI] and a symbol, for any other unit.

    Raises:
        SceneError: a unit is not known by its value or symbol, a symbol is not valid, or two units have one symbol.
    """
    given: Mapping[Kind, Given] = {"length": length, "time": time, "mass": mass, "charge": charge}
    return UnitSystem(**{kind: _found(kind, value) for kind, value in given.items()})


def _found(kind: Kind, given: object) -> Unit:
    """The unit that an argument means."""
    path, known = f"units.system.{kind}", SYMBOLS[kind]
    if isinstance(given, tuple) and len(given) == 2:
        value, symbol = given
        _check(kind, symbol, value, path)
        return Unit(str(symbol), float(value))
    own = {name: getattr(constants, name) for name, unit in constants.UNITS.items() if BASE.get(unit) == kind}
    value = {**known, **own}.get(given) if isinstance(given, str) else given
    symbol = next((symbol for symbol, each in known.items() if _is_number(value) and each == value), None)
    if symbol is None:
        hint = _other_meaning(kind, given) or did_you_mean(given, (*known, *own))
        raise SceneError(
            f"{path}: must be a unit of {kind} of pc.units, one of {', '.join(known)}, or a pair (value in SI, "
            f"symbol), got {given!r}{hint}"
        )
    return Unit(symbol, known[symbol])


def _other_meaning(kind: Kind, given: object) -> str:
    """The end of a message that names the other kinds of a constant or a symbol; empty if there are none."""
    if not isinstance(given, str) and not _is_number(given):
        return ""
    units = [unit for name, unit in constants.UNITS.items() if given in (name, getattr(constants, name))]
    kinds = [*(BASE.get(unit, unit) for unit in units), *(each for each in SYMBOLS if given in SYMBOLS[each])]
    meant = [f"a {each}" if each in SYMBOLS else f"in {each}" for each in dict.fromkeys(kinds) if each != kind]
    return f"; {given!r} is {' or '.join(meant)}" if meant else ""


def _check(kind: Kind, symbol: object, value: object, path: str = "") -> None:
    """Check the symbol and the value of a unit.

    Raises:
        SceneError: one of them is not valid, or the symbol has another meaning.
    """
    path = path or f"units.{kind}"
    if not _is_number(value) or not 0.0 < float(value) < math.inf:
        raise SceneError(f"{path}: must have a finite value above 0 in SI, got {value!r}")
    if (
        not isinstance(symbol, str)
        or not 0 < len(symbol) <= LONGEST
        or not symbol.isprintable()
        or any(sign.isspace() or sign.isdigit() or sign in FORBIDDEN for sign in symbol)
    ):
        raise SceneError(f"{path}: must have a symbol of letters or signs, at most {LONGEST}, got {symbol!r}")
    for other, symbols in SYMBOLS.items():
        if symbol in symbols and (other != kind or symbols[symbol] != value):
            meant = f"a {other} of {symbols[symbol]:g} in SI"
            raise SceneError(f"{path}: {symbol!r} is the symbol of {meant}; take another")
    if symbol in (*DERIVED, *OTHERS):
        raise SceneError(f"{path}: {symbol!r} is a unit of the SI; take another symbol")


def _check_unit(unit: object) -> None:
    """Check that a unit is one of the SI.

    Raises:
        SceneError: it is none.
    """
    known = (*BASE, *DERIVED, *OTHERS)
    if not isinstance(unit, str) or not set(powers_of(unit)) <= set(known):
        raise SceneError(f'convert.unit: must be a product of {", ".join(known)}, such as "kg·m/s²", got {unit!r}')


def _is_number(value: object) -> TypeGuard[Real]:
    return isinstance(value, Real) and not isinstance(value, bool)


@cache
def _pattern() -> re.Pattern[str]:
    """Pattern of texts to keep, of a number with its unit ("0.5 m/s", "(0, 1) m", "3/s"), and of a unit in brackets.

    Kept are texts in quotes, as `repr` writes names, and all that follows "raised ValueError: ".
    """
    kept = r"""(?P<kept>(?<!\w)(?P<quote>['"])(?:\\.|(?!(?P=quote)).)*(?P=quote)|\braised \w+: (?s:.*))"""
    symbols = "|".join(sorted((*BASE, *DERIVED, *OTHERS), key=len, reverse=True))
    one = rf"(?:{symbols})[{POWERS}]*"
    unit = rf"(?:1/)?{one}(?:[·/]{one})*"
    number, end = r"(?:(?<=[\d)\]])|(?<=\binf)|(?<=\b[nN]a[nN]))", r"(?=$|[\s,;:.)\]])"
    return re.compile(rf"{kept}|{number}(?: (?P<unit>{unit})|/(?P<rate>s)){end}| \[(?P<inner>{unit})\]")


@cache
def _symbol(units: UnitSystem, unit: str) -> str:
    """The symbol of a system for a unit of the SI."""
    base, caret, power = unit.partition("^")
    if caret:  # as "m^(-D/2)", whose exponent is no whole number
        own = units.symbol(base)
        return f"{own}^{power}" if own else ""
    exponents = dimension_of(unit)
    if units.is_dimensionless and (exponents or unit == "1"):
        return ""
    changed = [base for base in exponents if base in BASE and getattr(units, BASE[base]).symbol != base]
    if not changed:
        return unit
    order = [*(base for base in BASE if base in exponents), *(each for each in exponents if each not in BASE)]
    factors = [(getattr(units, BASE[each]).symbol if each in BASE else each, exponents[each]) for each in order]
    above = "·".join(raised(symbol, power) for symbol, power in factors if power > 0)
    below = [raised(symbol, -power) for symbol, power in factors if power < 0]
    under = f"({'·'.join(below)})" if len(below) > 1 else "".join(below)
    return f"{above or '1'}/{under}" if below else above


SI: Final = UnitSystem(Unit("m", 1.0), Unit("s", 1.0), Unit("kg", 1.0))
"""Units of the SI: meter, second, kilogram and coulomb."""
dimensionless: Final = UnitSystem(*[Unit("", None)] * 4)
"""Numbers without units, for models that have none."""
