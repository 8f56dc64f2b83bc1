"""Validation of arguments: converts a user's values to checked numbers, words, paths and read-only arrays.

For any object, the result is a value of the declared type or a SceneError that names the parameter. No other module
compares, converts or indexes values from a user.
"""

from __future__ import annotations

import inspect
import math
import os
import sys
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from reprlib import Repr
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from physcore import memory
from physcore.errors import SceneError
from physcore.spelling import did_you_mean
from physcore.units.systems import Default

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
Vector: TypeAlias = Sequence[float] | NDArray[np.floating] | NDArray[np.integer]
TimedVector: TypeAlias = Vector | Callable[[float], ArrayLike]
"""A vector, or a function of the time [s] that returns one."""
PlacedVector: TypeAlias = TimedVector | Callable[[float, FloatArray], ArrayLike]
"""A vector, a function of the time [s] that returns one, or a function of the time and positions.

The last has the positions (N, D) [m], and returns a vector for each, (N, D).
"""
T = TypeVar("T")
Word = TypeVar("Word", bound=str)

DIMENSIONS = (2, 3)

MOST = 2**53
"""Largest count. Every whole number up to here is exact as a float, so that times are exact."""

SHORTEST, LONGEST = 1e-100, 1e100
"""Range of lengths [m], times [s] and rates [1/s]. Products and quotients of two such values neither overflow nor
underflow.
"""

MANY = 10**6
"""Number of entries from which on the free memory is checked."""

DEEPEST = 8
"""Largest depth of nested lists."""

DIGITS_PER_BIT = 0.30103
"""The decimal logarithm of 2."""

LONG_INTEGER = 10**40
"""Integers beyond this size are quoted by their number of digits: Python refuses to convert very long ones to text."""


class _Short(Repr):
    """Shortens long lists and texts."""

    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = 120

    def repr_int(self, x: int, level: int) -> str:
        """A whole number, or its number of digits if it is too long."""
        if abs(x) < LONG_INTEGER:
            return super().repr_int(x, level)
        return f"a whole number of about {math.ceil(x.bit_length() * DIGITS_PER_BIT)} digits"


_SHORT = _Short()


def shown(value: object) -> str:
    """A value as quoted in a message: on one line, and shortened if it is long."""
    try:
        text = _SHORT.repr(value)
    except Exception:
        text = f"something of the type {type(value).__name__}"
    return " ".join(text.split()).encode(errors="backslashreplace").decode()


def written(point: Sequence[float]) -> str:
    """A point or a vector in the usual notation: (0, 2.5)."""
    return f"({', '.join(f'{component:g}' for component in point)})"


def number(
    value: object, path: str, *, above: float = -math.inf, least: float = -math.inf, most: float = math.inf
) -> float:
    """A finite float x with `x > above` and `least <= x <= most`."""
    result = _real(value, path)
    if not math.isfinite(result):
        raise SceneError(f"{path}: must be finite, got {result}")
    if result <= above:
        raise SceneError(f"{path}: must be > {above:g}, got {result:g}")
    if result < least:
        raise SceneError(f"{path}: must be ≥ {least:g}, got {result:g}")
    if result > most:
        raise SceneError(f"{path}: must be ≤ {most:g}, got {result:g}")
    return result


def called(function: Callable[..., T], path: str, *arguments: object) -> T:
    """Call a user's function and return its result.

    Raises:
        SceneError: the function raised an exception, which is the cause of this one.
    """
    try:
        return function(*arguments)
    except Exception as error:
        raise SceneError(f"{path}: the function raised {type(error).__name__}: {error}") from error


def span(value: object, path: str, *, empty: bool = False) -> float:
    """A length, a time or a rate from SHORTEST to LONGEST; with `empty`, 0 is valid too."""
    result = number(value, path, above=-math.inf if empty else 0.0, least=0.0, most=LONGEST)
    return result if result == 0.0 else number(result, path, least=SHORTEST)


def count(value: object, path: str, *, least: int = 0, most: int = MOST) -> int:
    """An integer from `least` to `most`."""
    if isinstance(value, (bool, np.timedelta64)) or not isinstance(value, (int, np.integer)):
        raise SceneError(f"{path}: must be a whole number, got {shown(value)}{_nature(value)}")
    if value < least:
        raise SceneError(f"{path}: must be ≥ {least}, got {shown(value)}")
    if value > most:
        raise SceneError(f"{path}: must be ≤ {most}, got {shown(value)}")
    return int(value)


def flag(value: object, path: str) -> bool:
    """A Boolean value."""
    if not isinstance(value, (bool, np.bool_)):
        raise SceneError(f"{path}: must be True or False, got {shown(value)}")
    return bool(value)


def word(value: object, path: str, known: Collection[Word]) -> Word:
    """One of the known words."""
    if not isinstance(value, str) or value not in known:
        raise SceneError(f"{path}: must be {_alternatives(known)}, got {shown(value)}{did_you_mean(value, known)}")
    return next(each for each in known if each == value)


def is_word(value: object, expected: str) -> bool:
    """Whether a value is a certain string. Arrays are never compared, because `==` compares them entry by entry."""
    return isinstance(value, str) and value == expected


def words(value: object, path: str, known: Collection[Word], hint: str = "") -> tuple[Word, ...]:
    """A tuple of known words, without repetitions."""
    if not isinstance(value, (tuple, list, set, frozenset)) or not all(
        isinstance(each, str) and each in known for each in value
    ):
        names = ", ".join(map(repr, known))
        entries = value if isinstance(value, (tuple, list)) else ()
        wrong = next((each for each in entries if isinstance(each, str) and each not in known), None)
        raise SceneError(f"{path}: must be a tuple of {names}, got {shown(value)}{hint or did_you_mean(wrong, known)}")
    return tuple(dict.fromkeys(value))


def text(value: object, path: str) -> str:
    """A string that can be encoded as UTF-8."""
    if not isinstance(value, str):
        raise SceneError(f"{path}: must be a string, got {shown(value)}")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise SceneError(f"{path}: must be a string without lone surrogates, got {shown(value)}") from None
    return value


def items(value: object, path: str, what: str) -> list[Any]:
    """The entries of a list, a tuple or a one-dimensional array."""
    if isinstance(value, (str, bytes)) or not isinstance(value, (Sequence, np.ndarray)) or np.ndim(_flat(value)) != 1:
        raise SceneError(f"{path}: must be a list of {what}, got {shown(value)}")
    return list(value)


def file_path(value: object, path: str = "path") -> Path:
    """A file path.

    Raises:
        SceneError: the value is neither a string nor a `pathlib.Path`, or is not valid as the name of a file.
    """
    try:
        name = os.fspath(value)  # type: ignore[call-overload]
    except Exception:
        name = None
    if not isinstance(name, str):
        raise SceneError(f"{path}: must be the name of a file, a string or a pathlib.Path, got {shown(value)}")
    try:
        possible = b"\0" not in os.fsencode(name)
    except UnicodeEncodeError:
        possible = False
    if not possible:
        raise SceneError(f"{path}: must be a name without null characters and lone surrogates, got {shown(name)}")
    return Path(name)


def vector(value: object, path: str, *, finite: bool = True) -> tuple[float, ...]:
    """A vector of two or three numbers. With `finite`, all of them must be finite."""
    result = array(value, path, finite=finite)
    if result.shape not in [(dimension,) for dimension in DIMENSIONS]:
        raise SceneError(f"{path}: must be 2 or 3 numbers, one for each dimension, got {shown(value)}")
    return tuple(result.tolist())


def timed(value: object, path: str) -> tuple[float, ...] | Callable[[float], ArrayLike]:
    """A vector, or a function of the time that returns one, which is called at the time 0.

    Raises:
        SceneError: the value is neither, or the function raised an exception.
    """
    if not callable(value):
        return vector(value, path)
    vector(called(value, path, 0.0), f"{path}: its value")
    return value


def placed(value: object, path: str) -> tuple[Any, bool]:
    """A vector, a function of the time, or a function of the time and positions; and whether it is the last.

    A function is one of the time alone if it can be called with one argument.

    Raises:
        SceneError: the value is none of these, or a function of the time raised an exception.
    """
    if not callable(value) or misfit(value, "time") is None:
        return timed(value, path), False
    reason = misfit(value, "time", "positions")
    if reason is not None:
        raise SceneError(f"{path}: must take (time) or (time, positions), got {reason}")
    return value.__call__ if hasattr(value, "__dataclass_fields__") else value, True


def misfit(function: Callable[..., object], *arguments: str) -> str | None:
    """A description of a function that cannot be called with some arguments; None if it can, or is not known."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return None  # Some functions that are not written in Python have no signature.
    try:
        signature.bind(*arguments)
    except TypeError as error:
        return f"a function of {signature} ({error})"
    return None


def regular(value: object, path: str) -> np.ndarray:
    """The result of `np.asarray`. Ragged and masked arrays are refused."""
    try:
        depth = _depth(value)
        result = np.asarray(value) if 0 <= depth <= DEEPEST else None
        masked = _masked(value)
    except SceneError:
        raise
    except Exception as error:
        cause = shown(str(error) or type(error).__name__)
        raise SceneError(f"{path}: must be a regular array of numbers ({cause})") from None
    if depth > DEEPEST or (result is not None and result.ndim > DEEPEST):
        raise SceneError(f"{path}: must be an array of numbers, got lists in lists, more than {DEEPEST} deep")
    if masked or result is None:
        raise SceneError(f"{path}: must not have masked entries; take the valid ones, or fill it: .filled(…)")
    return result


def array(value: object, path: str, *, finite: bool = True) -> FloatArray:
    """A new contiguous array of float64. With `finite`, all entries must be finite; otherwise infinity is valid too."""
    raw = regular(value, path)
    if raw.dtype.kind not in "biufO":
        raise SceneError(f"{path}: must be an array of real numbers, got {shown(value)}{_nature(raw)}")
    if raw.size > MANY:
        memory.require(8.0 * raw.size, f"{raw.size} numbers", path)
    if raw.dtype.kind == "O":
        entries = [_real(entry, f"{path}{_written(index)}") for index, entry in np.ndenumerate(raw)]
        raw = np.array(entries, dtype=np.float64).reshape(raw.shape)
    with np.errstate(over="ignore"):  # Overflow gives infinity, which is refused below.
        result = np.array(raw, dtype=np.float64, order="C")
    right = np.isfinite(result) if finite else ~np.isnan(result)
    if not right.all():
        raise SceneError(
            f"{path}{_first(~right)}: must be {'finite' if finite else 'a number'}, got {result[~right][0]}"
        )
    return result


def broadcast(value: ArrayLike, shape: tuple[int, ...], path: str, *, finite: bool = True) -> FloatArray:
    """A new array of the given shape, by NumPy's rules of broadcasting; `finite` as in `array`."""
    given = array(value, path, finite=finite)
    try:
        return np.array(np.broadcast_to(given, shape), order="C")
    except ValueError:
        raise SceneError(f"{path}: must broadcast to the shape {shape}, got the shape {given.shape}") from None


def require(condition: BoolArray, values: FloatArray, path: str, rule: str) -> None:
    """Raise a SceneError with the first entry of `values` for which `condition` does not hold."""
    if not condition.all():
        raise SceneError(f"{path}{_first(~condition)}: must be {rule}, got {values[~condition][0]:g}")


def mask(value: ArrayLike | None, length: int, path: str) -> BoolArray:
    """A Boolean array of `length` entries, from one bool, a mask, or integer indices (negative: from the end)."""
    if value is None:
        return np.zeros(length, dtype=np.bool_)
    given = regular(value, path)
    if given.dtype.kind == "b":
        if given.shape not in [(), (length,)]:
            raise SceneError(f"{path}: a mask must have {length} entries, got the shape {given.shape}")
        return np.array(np.broadcast_to(given, (length,)))
    result = np.zeros(length, dtype=np.bool_)
    if given.size == 0:
        return result
    if given.dtype.kind not in "iu":
        raise SceneError(f"{path}: must be a bool mask or integer indices, got {shown(value)}{_nature(given)}")
    outside = (given < -length) | (given >= length)
    if outside.any():
        raise SceneError(f"{path}: index {given[outside].flat[0]} is outside of the {length} particles")
    result[given] = True
    return result


def frozen(values: np.ndarray) -> np.ndarray:
    """Make an array read-only, and return it."""
    values.flags.writeable = False
    return values


def _real(value: object, path: str) -> float:
    """A value as a float. Values that only resemble numbers are refused: truth values, text and masked entries."""
    try:
        if isinstance(value, (bool, np.bool_, str, np.complexfloating, np.timedelta64)) or _masked(value):
            raise TypeError
        if not hasattr(type(value), "__float__") and not hasattr(type(value), "__index__"):
            raise TypeError  # float() would read bytes as text.
        if np.ndim(value) != 0:  # type: ignore[arg-type]
            raise TypeError
        return value if isinstance(value, Default) else float(value)  # type: ignore[arg-type]
    except OverflowError:
        raise SceneError(f"{path}: must be at most {sys.float_info.max:.2g} in size, got {shown(value)}") from None
    except Exception:  # An object of the user's may raise anything.
        raise SceneError(f"{path}: must be a number, got {shown(value)}{_nature(value)}") from None


def _nature(value: object) -> str:
    """The reason why a value is not a number, if its type tells; otherwise empty."""
    if _masked(value):
        return ", which is masked"
    kind = value.dtype.kind if isinstance(value, (np.ndarray, np.generic)) else ""
    if isinstance(value, str) or kind == "U":
        return ", which is text"
    if isinstance(value, (bytes, bytearray, memoryview)) or kind == "S":
        return ", which is bytes"
    if isinstance(value, complex) or kind == "c":
        return ", which is complex"
    if kind in ("M", "m"):
        return ", which is a date or a time"
    return f", an array of shape {value.shape}" if isinstance(value, np.ndarray) and value.ndim else ""


def _depth(value: object) -> int:
    """The nesting depth of lists, counted up to DEEPEST + 1; −1 if one of their entries is masked.

    Each distinct list is visited once per level, so that a list that contains itself does not cause an endless loop.
    """
    level: list[Any] = [value] if isinstance(value, (list, tuple)) else []
    for depth in range(DEEPEST + 1):
        kinds = set().union(*(map(type, each) for each in level))
        if any(kind.__module__.partition(".")[0] == "numpy" and "Masked" in kind.__name__ for kind in kinds):
            return -1
        if not any(issubclass(kind, (list, tuple)) for kind in kinds):
            return depth + bool(level)
        level = list(
            {id(entry): entry for each in level for entry in each if isinstance(entry, (list, tuple))}.values()
        )
    return DEEPEST + 1


def _flat(value: Any) -> Any:
    """An array unchanged; for any other value, an empty one-dimensional array."""
    return value if isinstance(value, np.ndarray) else np.empty(0)


def _masked(value: object) -> bool:
    """Whether a value has masked entries. Always False unless numpy.ma was imported, because the import is slow."""
    masked_arrays = sys.modules.get("numpy.ma")
    if masked_arrays is None or not isinstance(value, masked_arrays.MaskedArray):
        return False
    return bool(masked_arrays.is_masked(value))


def _alternatives(known: Collection[str]) -> str:
    """A list of alternatives as text: 'a', 'b' or 'c'."""
    *others, last = map(repr, known)
    return f"{', '.join(others)} or {last}" if others else last


def _first(failed: BoolArray) -> str:
    """The index of the first failed entry, as text to append to a name; empty for a scalar."""
    return _written(tuple(np.argwhere(failed)[0].tolist()))


def _written(index: tuple[int, ...]) -> str:
    return f"[{', '.join(map(str, index))}]" if index else ""
