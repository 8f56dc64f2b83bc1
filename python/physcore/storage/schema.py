"""Schemas of the content of files, which is validated once, when it is read.

A rule takes a value and its path within the file. It returns the value in the form used, or raises a FileError with the
path. Rules are combined like the content: `record(times=array("F"), fps=real(above=0.0))`.
"""

from __future__ import annotations

import builtins
import math
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias, get_args, get_origin, get_type_hints

import numpy as np

from physcore.checks import MOST, shown
from physcore.errors import FileError

Rule: TypeAlias = Callable[[Any, str], Any]


class Sizes(dict[str, int]):
    """Lengths of axes by name. The first array with an axis determines its length, which all others must have."""

    def array(self, *axes: str, finite: bool = False, kind: type[np.generic] = np.float64) -> Rule:
        """An array of numbers of a kind whose axes have these names. With `finite`, all entries must be finite."""

        def check(value: Any, path: str) -> Any:
            if not isinstance(value, np.ndarray) or value.dtype != kind or value.ndim != len(axes):
                raise _wrong(path, f"an array of {kind.__name__} numbers with {len(axes)} axes", _kind(value))
            expected = tuple(self.setdefault(axis, size) for axis, size in zip(axes, value.shape, strict=True))
            if value.shape != expected:
                raise _wrong(path, f"an array of the shape {expected}", f"the shape {value.shape}")
            if finite and not np.isfinite(value).all():
                raise _wrong(path, "finite", "numbers that are not")
            return value

        return check


def record(optional: Mapping[str, Rule] | None = None, /, **rules: Rule) -> Rule:
    """A mapping with exactly these names, and possibly some of the optional ones."""
    every = {**rules, **(optional or {})}

    def check(value: Any, path: str) -> dict[str, Any]:
        given = _mapping(value, path)
        for name in rules:
            if name not in given:
                raise FileError(f"{_inner(path, name)}: is missing")
        for name in given:
            if name not in every:
                raise FileError(f"{_inner(path, name)}: is unknown")
        return {name: every[name](entry, _inner(path, name)) for name, entry in given.items()}

    return check


def table(rule: Rule) -> Rule:
    """A mapping with any names."""
    return lambda value, path: {name: rule(entry, _inner(path, name)) for name, entry in _mapping(value, path).items()}


def several(rule: Rule, *, lengths: tuple[int, ...] | None = None) -> Rule:
    """A list, of one of some lengths."""

    def check(value: Any, path: str) -> tuple[Any, ...]:
        if not isinstance(value, list) or (lengths is not None and len(value) not in lengths):
            size = "" if lengths is None else f" of {' or '.join(map(str, lengths))}"
            raise _wrong(path, f"a list{size}", shown(value))
        return tuple(rule(entry, f"{path}[{index}]") for index, entry in enumerate(value))

    return check


def maybe(rule: Rule) -> Rule:
    """None, or a value that obeys a rule."""
    return lambda value, path: None if value is None else rule(value, path)


def either(first: type, one: Rule, other: Rule) -> Rule:
    """One rule for values of a type, and another one for all others."""
    return lambda value, path: (one if isinstance(value, first) else other)(value, path)


def text(value: Any, path: str) -> str:
    """A string."""
    if not isinstance(value, str):
        raise _wrong(path, "a text", shown(value))
    return value


def word(*known: str) -> Rule:
    """One of some words."""

    def check(value: Any, path: str) -> str:
        if not isinstance(value, str) or value not in known:
            raise _wrong(path, f"one of {', '.join(map(repr, known))}", shown(value))
        return value

    return check


def whole(*, least: int = 0, most: int = MOST) -> Rule:
    """An integer."""

    def check(value: Any, path: str) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise _wrong(path, f"a whole number from {least} to {most}", shown(value))
        return value

    return check


def real(*, least: float = -math.inf, above: float = -math.inf, finite: bool = True) -> Rule:
    """A number, never NaN; with `finite`, it must be finite."""

    def check(value: Any, path: str) -> float:
        right = isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= math.inf
        if right and isinstance(value, int) and abs(value) > MOST:
            right = False
        if not right or (finite and math.isinf(value)) or value < least or not (value > above or above == -math.inf):
            limits = [f"≥ {least:g}"] * (least > -math.inf) + [f"> {above:g}"] * (above > -math.inf)
            raise _wrong(path, " ".join([f"a {'finite ' if finite else ''}number", *limits]), shown(value))
        return float(value)

    return check


def flag(value: Any, path: str) -> bool:
    """A Boolean value."""
    if not isinstance(value, bool):
        raise _wrong(path, "true or false", shown(value))
    return value


def anything(value: Any, path: str) -> Any:
    """Any value, without validation; it is validated elsewhere."""
    del path
    return value


def of(kind: type, **special: Rule | None) -> Rule:
    """The fields of a dataclass or a TypedDict, with rules derived from their types.

    Args:
        kind: the class.
        special: rules for fields of other types; None: the field is not in the file.
    """
    rules = {name: special.get(name, _by_type(hint)) for name, hint in get_type_hints(kind).items()}
    return record(**{name: rule for name, rule in rules.items() if rule is not None})


def _by_type(hint: Any) -> Rule:
    """The rule for a type."""
    simple: dict[Any, Rule] = {str: text, bool: flag, int: whole(), float: real(finite=False)}
    if hint in simple:
        return simple[hint]
    parts = get_args(hint)
    match get_origin(hint):
        case typing.Literal:
            return word(*parts)
        case builtins.tuple:
            return several(_by_type(parts[0]), lengths=None if parts[-1] is ... else (len(parts),))
        case types.UnionType if types.NoneType in parts:
            return maybe(_by_type(parts[0]))
        case types.UnionType if get_origin(parts[1]) is tuple:
            return either(list, _by_type(parts[1]), _by_type(parts[0]))
    return anything


def _mapping(value: Any, path: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise _wrong(path, "a table of entries", shown(value))
    return value


def _wrong(path: str, expected: str, found: str) -> FileError:
    return FileError(f"{path}: must be {expected}, got {found}")


def _kind(value: Any) -> str:
    return f"{value.dtype} of shape {value.shape}" if isinstance(value, np.ndarray) else shown(value)


def _inner(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name
