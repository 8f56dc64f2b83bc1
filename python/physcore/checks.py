"""The boundary where arguments enter: what a user passes becomes checked numbers, words, paths and read-only arrays.

Whatever is passed, an object of any kind included, the answer is a value of the declared type or a SceneError that
names the parameter: nothing else compares, converts or indexes what a user has passed.
"""

from __future__ import annotations

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

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
Vector: TypeAlias = Sequence[float] | NDArray[np.floating] | NDArray[np.integer]
T = TypeVar("T")
Word = TypeVar("Word", bound=str)

DIMENSIONS = (2, 3)

MOST = 2**53
"""The largest count: up to here every whole number is a float, so that times are right."""

SHORTEST, LONGEST = 1e-100, 1e100
"""The range of lengths [m], times [s] and rates [1/s]: products and quotients of two are neither zero nor infinite."""

MANY = 10**6
"""The number of entries from which the free memory is looked at."""

DEEPEST = 8
"""How deep lists are nested at most."""

DIGITS_PER_BIT = 0.30103
"""The decimal logarithm of 2."""

LONG_INTEGER = 10**40
"""Whole numbers beyond are quoted by their number of digits: Python refuses to write out very long ones."""


class _Short(Repr):
    """Cuts long lists and texts."""

    def __init__(self) -> None:
        super().__init__()
        self.maxstring = self.maxother = 120

    def repr_int(self, x: int, level: int) -> str:
        """A whole number, or how long it is."""
        if abs(x) < LONG_INTEGER:
            return super().repr_int(x, level)
        return f"a whole number of about {math.ceil(x.bit_length() * DIGITS_PER_BIT)} digits"


_SHORT = _Short()


def shown(value: object) -> str:
    """A value as a message quotes it: in one line, and cut where it is long."""
    try:
        text = _SHORT.repr(value)
    except Exception:
        text = f"something of the type {type(value).__name__}"
    return " ".join(text.split()).encode(errors="backslashreplace").decode()


def written(point: Sequence[float]) -> str:
    """A point or a vector as people write it: (0, 2.5)."""
    return f"({', '.join(f'{component:g}' for component in point)})"


def number(
    value: object, path: str, *, above: float = -math.inf, least: float = -math.inf, most: float = math.inf
) -> float:
    """A finite float with `value > above` and `least <= value <= most`."""
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
    """What a function of the user's gives.

    Raises:
        SceneError: it raised an exception, which is the cause.
    """
    try:
        return function(*arguments)
    except Exception as error:
        raise SceneError(f"{path}: the function raised {type(error).__name__}: {error}") from error


def span(value: object, path: str, *, empty: bool = False) -> float:
    """A length, a time or a rate from SHORTEST to LONGEST; 0 too where it may be empty."""
    result = number(value, path, above=-math.inf if empty else 0.0, least=0.0, most=LONGEST)
    return result if result == 0.0 else number(result, path, least=SHORTEST)


def count(value: object, path: str, *, least: int = 0, most: int = MOST) -> int:
    """A whole number from `least` to `most`."""
    if isinstance(value, (bool, np.timedelta64)) or not isinstance(value, (int, np.integer)):
        raise SceneError(f"{path}: must be a whole number, got {shown(value)}{_nature(value)}")
    if value < least:
        raise SceneError(f"{path}: must be ≥ {least}, got {shown(value)}")
    if value > most:
        raise SceneError(f"{path}: must be ≤ {most}, got {shown(value)}")
    return int(value)


def flag(value: object, path: str) -> bool:
    """True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise SceneError(f"{path}: must be True or False, got {shown(value)}")
    return bool(value)


def word(value: object, path: str, known: Collection[Word]) -> Word:
    """One of some words."""
    if not isinstance(value, str) or value not in known:
        raise SceneError(f"{path}: must be {_alternatives(known)}, got {shown(value)}{did_you_mean(value, known)}")
    return next(each for each in known if each == value)


def is_word(value: object, expected: str) -> bool:
    """Whether it is a certain word; arrays compare entry by entry, and so are not asked."""
    return isinstance(value, str) and value == expected


def words(value: object, path: str, known: Collection[Word], hint: str = "") -> tuple[Word, ...]:
    """Some of some words, each once."""
    if not isinstance(value, (tuple, list, set, frozenset)) or not all(
        isinstance(each, str) and each in known for each in value
    ):
        names = ", ".join(map(repr, known))
        entries = value if isinstance(value, (tuple, list)) else ()
        wrong = next((each for each in entries if isinstance(each, str) and each not in known), None)
        raise SceneError(f"{path}: must be a tuple of {names}, got {shown(value)}{hint or did_you_mean(wrong, known)}")
    return tuple(dict.fromkeys(value))


def text(value: object, path: str) -> str:
    """A text that can be written into a file."""
    if not isinstance(value, str):
        raise SceneError(f"{path}: must be a string, got {shown(value)}")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise SceneError(f"{path}: must be a string without lone surrogates, got {shown(value)}") from None
    return value


def items(value: object, path: str, what: str) -> list[Any]:
    """Several things, in a list, a tuple or a one-dimensional array."""
    if isinstance(value, (str, bytes)) or not isinstance(value, (Sequence, np.ndarray)) or np.ndim(_flat(value)) != 1:
        raise SceneError(f"{path}: must be a list of {what}, got {shown(value)}")
    return list(value)


def file_path(value: object, path: str = "path") -> Path:
    """The name of a file.

    Raises:
        SceneError: it is neither a string nor a `pathlib.Path`, or no file can have that name.
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
    """Two or three numbers; `finite` says whether all of them have to be."""
    result = array(value, path, finite=finite)
    if result.shape not in [(dimension,) for dimension in DIMENSIONS]:
        raise SceneError(f"{path}: must be 2 or 3 numbers, one for each dimension, got {shown(value)}")
    return tuple(result.tolist())


def regular(value: object, path: str) -> np.ndarray:
    """The array that NumPy makes of a value, as long as that has one shape and nothing is masked."""
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
    """A new contiguous array of float64 numbers; `finite` says whether all of them have to be, or infinite ones do."""
    raw = regular(value, path)
    if raw.dtype.kind not in "biufO":
        raise SceneError(f"{path}: must be an array of real numbers, got {shown(value)}{_nature(raw)}")
    if raw.size > MANY:
        memory.require(8.0 * raw.size, f"{raw.size} numbers", path)
    if raw.dtype.kind == "O":
        entries = [_real(entry, f"{path}{_written(index)}") for index, entry in np.ndenumerate(raw)]
        raw = np.array(entries, dtype=np.float64).reshape(raw.shape)
    with np.errstate(over="ignore"):  # What is too large is refused as infinite.
        result = np.array(raw, dtype=np.float64, order="C")
    right = np.isfinite(result) if finite else ~np.isnan(result)
    if not right.all():
        raise SceneError(
            f"{path}{_first(~right)}: must be {'finite' if finite else 'a number'}, got {result[~right][0]}"
        )
    return result


def broadcast(value: ArrayLike, shape: tuple[int, ...], path: str, *, finite: bool = True) -> FloatArray:
    """A new array of numbers of exactly `shape`, repeated the way NumPy broadcasts; `finite` as of `array`."""
    given = array(value, path, finite=finite)
    try:
        return np.array(np.broadcast_to(given, shape), order="C")
    except ValueError:
        raise SceneError(f"{path}: must broadcast to the shape {shape}, got the shape {given.shape}") from None


def require(condition: BoolArray, values: FloatArray, path: str, rule: str) -> None:
    """Raise with the first entry of `values` for which `condition` does not hold."""
    if not condition.all():
        raise SceneError(f"{path}{_first(~condition)}: must be {rule}, got {values[~condition][0]:g}")


def mask(value: ArrayLike | None, length: int, path: str) -> BoolArray:
    """A bool array of `length` entries, from one bool, a mask, or integer indices (negative: from the end)."""
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
    """The same array, read-only."""
    values.flags.writeable = False
    return values


def _real(value: object, path: str) -> float:
    """A value as a float, but for what only looks like a number: truth values, text and masked entries."""
    try:
        if isinstance(value, (bool, np.bool_, str, np.complexfloating, np.timedelta64)) or _masked(value):
            raise TypeError
        if not hasattr(type(value), "__float__") and not hasattr(type(value), "__index__"):
            raise TypeError  # Bytes are read as text.
        if np.ndim(value) != 0:  # type: ignore[arg-type]
            raise TypeError
        return float(value)  # type: ignore[arg-type]
    except OverflowError:
        raise SceneError(f"{path}: must be at most {sys.float_info.max:.2g} in size, got {shown(value)}") from None
    except Exception:  # Whatever an object of the user's does instead.
        raise SceneError(f"{path}: must be a number, got {shown(value)}{_nature(value)}") from None


def _nature(value: object) -> str:
    """The reason why a value is no number, where its type says it."""
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
    """How many lists are in each other, counted up to one more than DEEPEST; −1 if one of their entries is masked.

    A list that is there several times is looked at once, so that one that has itself in it has an end.
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
    """An array as it is, and a one-dimensional one for anything else, whatever is in it."""
    return value if isinstance(value, np.ndarray) else np.empty(0)


def _masked(value: object) -> bool:
    """Whether it has masked entries; nothing has where nobody has loaded numpy.ma, which takes its time."""
    masked_arrays = sys.modules.get("numpy.ma")
    if masked_arrays is None or not isinstance(value, masked_arrays.MaskedArray):
        return False
    return bool(masked_arrays.is_masked(value))


def _alternatives(known: Collection[str]) -> str:
    """'a', 'b' or 'c'."""
    *others, last = map(repr, known)
    return f"{', '.join(others)} or {last}" if others else last


def _first(failed: BoolArray) -> str:
    """The index of the first failed entry, as it is written behind a name; nothing for a scalar."""
    return _written(tuple(np.argwhere(failed)[0].tolist()))


def _written(index: tuple[int, ...]) -> str:
    return f"[{', '.join(map(str, index))}]" if index else ""
