"""Turning what a user passes into checked numbers and read-only arrays, with messages that name the parameter."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from numbers import Real
from reprlib import Repr
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from physcore.errors import SceneError

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
Vector: TypeAlias = Sequence[float] | NDArray[np.floating] | NDArray[np.integer]

DIMENSIONS = (2, 3)

MOST = 2**53
"""The largest count: up to here every whole number is a float, so that times are right."""

_SHORT = Repr()
_SHORT.maxstring = _SHORT.maxother = 120


def shown(value: object) -> str:
    """What a user passed, as a message quotes it: long lists and texts are cut."""
    return _SHORT.repr(value)


def number(
    value: object, path: str, *, above: float = -math.inf, least: float = -math.inf, most: float = math.inf
) -> float:
    """A finite float with `value > above` and `least <= value <= most`."""
    try:
        if isinstance(value, (bool, str, bytes, np.complexfloating)) or _masked(value):
            raise TypeError  # Python would make a float of each of these.
        result = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise SceneError(f"{path}: must be a number, got {shown(value)}") from None
    if not math.isfinite(result):
        raise SceneError(f"{path}: must be finite, got {result}")
    if result <= above:
        raise SceneError(f"{path}: must be > {above:g}, got {result:g}")
    if result < least:
        raise SceneError(f"{path}: must be ≥ {least:g}, got {result:g}")
    if result > most:
        raise SceneError(f"{path}: must be ≤ {most:g}, got {result:g}")
    return result


def count(value: object, path: str, *, least: int = 0, most: int = MOST) -> int:
    """A whole number from `least` to `most`."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise SceneError(f"{path}: must be a whole number, got {shown(value)}")
    if value < least:
        raise SceneError(f"{path}: must be ≥ {least}, got {value}")
    if value > most:
        raise SceneError(f"{path}: must be ≤ {most}, got {shown(value)}")
    return int(value)


def vector(value: object, path: str) -> tuple[float, ...]:
    """Two or three finite numbers."""
    result = array(value, path)
    if result.shape not in [(dimension,) for dimension in DIMENSIONS]:
        raise SceneError(f"{path}: must be 2 or 3 numbers, one for each dimension, got {shown(value)}")
    return tuple(result.tolist())


def regular(value: object, path: str) -> np.ndarray:
    """What NumPy makes of a value, as long as that has one shape and nothing is masked."""
    try:
        result = np.asarray(value)
    except ValueError as error:
        raise SceneError(f"{path}: must be a regular array of numbers ({error})") from None
    if _masked(value):
        raise SceneError(f"{path}: must not have masked entries; take the valid ones, or fill it: .filled(…)")
    return result


def array(value: object, path: str) -> FloatArray:
    """A new contiguous array of finite float64 numbers."""
    raw = regular(value, path)
    if raw.dtype.kind == "O":
        for index, entry in np.ndenumerate(raw):
            if not isinstance(entry, Real):
                raise SceneError(f"{path}{_written(index)}: must be a real number, got {shown(entry)}")
    elif raw.dtype.kind not in "biuf":
        raise SceneError(f"{path}: must be an array of real numbers, got {shown(value)}")
    result = np.array(raw, dtype=np.float64, order="C")
    finite = np.isfinite(result)
    if not finite.all():
        raise SceneError(f"{path}{_first(~finite)}: must be finite, got {result[~finite][0]}")
    return result


def broadcast(value: ArrayLike, shape: tuple[int, ...], path: str) -> FloatArray:
    """A new array of finite numbers of exactly `shape`, repeated the way NumPy broadcasts."""
    given = array(value, path)
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
        raise SceneError(f"{path}: must be a bool mask or integer indices, got {shown(value)}")
    outside = (given < -length) | (given >= length)
    if outside.any():
        raise SceneError(f"{path}: index {given[outside].flat[0]} is outside of the {length} particles")
    result[given] = True
    return result


def frozen(values: np.ndarray) -> np.ndarray:
    """The same array, read-only."""
    values.flags.writeable = False
    return values


def _masked(value: object) -> bool:
    """Whether it has masked entries; nothing has where nobody has loaded numpy.ma, which takes its time."""
    masked_arrays = sys.modules.get("numpy.ma")
    return masked_arrays is not None and bool(masked_arrays.is_masked(value))


def _first(failed: BoolArray) -> str:
    """The index of the first failed entry, as it is written behind a name; nothing for a scalar."""
    return _written(tuple(np.argwhere(failed)[0].tolist()))


def _written(index: tuple[int, ...]) -> str:
    return f"[{', '.join(map(str, index))}]" if index else ""
