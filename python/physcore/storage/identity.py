"""Identities: values for JSON that are equal for equal values, in every process.

An array is identified by a hash of its bytes, and a function by a hash of its code with its defaults and its closure.
"""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import partial
from types import CodeType, FunctionType, MethodType, ModuleType

import numpy as np

from physcore.checks import shown
from physcore.errors import SceneError
from physcore.storage.archive import Tree, digest

NUMBERS = "biufcSUmM"
"""Kinds of arrays whose bytes are their values."""


def identity(value: object, path: str) -> Tree:
    """The identity of a value.

    Numbers, texts, arrays, lists, mappings and dataclasses are identified by their content. A function is identified by
    its source, and a lambda by its compiled code. Global variables that a function uses are not part of its identity,
    nor is the name of its module.

    Args:
        value: the value.
        path: path of the parameter, for the error.

    Raises:
        SceneError: the value or a part of it has no identity, such as an open file.
    """
    return _identity(value, path, {})


def _identity(value: object, path: str, outer: Mapping[int, int]) -> Tree:
    """The identity of a value; `outer` has the depth of each value around it, by its address."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if id(value) in outer:
        return {"again": outer[id(value)]}  # A function that calls itself is in its own closure.

    def inner(part: object) -> Tree:
        return _identity(part, path, {**outer, id(value): len(outer)})

    if isinstance(value, np.ndarray) and value.dtype.kind in NUMBERS:
        return {"array": value.dtype.str, "shape": list(value.shape), "hash": digest({"bytes": value.tobytes()})}
    if isinstance(value, (list, tuple)):
        return [inner(each) for each in value]
    if isinstance(value, Mapping):
        named = all(isinstance(key, str) for key in value)
        entries = [[inner(key), inner(each)] for key, each in value.items()]
        return dict(entries) if named else {"entries": entries}
    if is_dataclass(value) and not isinstance(value, type):
        return {
            "kind": type(value).__qualname__,
            **{each.name: inner(getattr(value, each.name)) for each in fields(value)},
        }
    found = _of_code(value, inner)
    if found is None:
        raise SceneError(
            f"{path}: {shown(value)} cannot be recognized in another process; use numbers, texts, arrays, dataclasses "
            "and functions"
        )
    return found


def _of_code(value: object, inner: Callable[[object], Tree]) -> Tree | None:
    """The identity of a function or another object with code; None for other objects."""
    match value:
        case ModuleType():
            return {"module": value.__name__}
        case complex() | bytes() | range() | slice():
            return {type(value).__name__: repr(value)}
        case MethodType():
            return {"method": inner(value.__func__), "of": inner(value.__self__)}
        case partial():
            return {"partial": inner(value.func), "arguments": inner(value.args), "keywords": inner(value.keywords)}
        case FunctionType():
            return {"function": value.__name__, "code": _code(value), **_surroundings(value, inner)}
    name = getattr(value, "__qualname__", None)
    if callable(value) and isinstance(name, str) and not isinstance(value, type):
        return {"function": f"{getattr(value, '__module__', None)}.{name}"}  # One that is not written in Python.
    kind = value if isinstance(value, type) else type(value)
    try:
        source = _digest(textwrap.dedent(inspect.getsource(kind)))
    except (OSError, TypeError):
        return {"class": f"{kind.__module__}.{name}"} if value is kind else None
    return {"class": kind.__qualname__, "code": source, **({} if value is kind else {"state": inner(vars(value))})}


def _surroundings(function: FunctionType, inner: Callable[[object], Tree]) -> dict[str, Tree]:
    """The defaults and the closure of a function, as far as it has them."""
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    found = {
        "defaults": function.__defaults__,
        "keywords": function.__kwdefaults__,
        "closure": {name: cell.cell_contents for name, cell in cells},
    }
    return {name: inner(each) for name, each in found.items() if each}


def _code(function: FunctionType) -> str:
    """A hash of the source of a function, or of its compiled code if there is no source.

    The source of a lambda is that of its whole statement, in which there may be others.
    """
    if function.__name__ != "<lambda>":
        try:
            return _digest(textwrap.dedent(inspect.getsource(function.__code__)))
        except (OSError, TypeError):
            pass
    return _digest(repr(_compiled(function.__code__)))


def _compiled(code: CodeType) -> tuple[object, ...]:
    """All that the result of compiled code depends on."""
    constants = [_compiled(each) if isinstance(each, CodeType) else each for each in code.co_consts]
    sets = [sorted(map(repr, each)) if isinstance(each, frozenset) else each for each in constants]
    return code.co_code, sets, code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars


def _digest(text: str) -> str:
    return str(digest({"text": text}))
