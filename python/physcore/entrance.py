"""Entrances of the package: they suggest misspelt keywords, and end tracebacks at the caller's line."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from functools import wraps
from inspect import isfunction
from types import TracebackType
from typing import ParamSpec, TypeVar

from physcore.errors import FileWarning, InternalError, MachWarning, PhyscoreError, SceneWarning, StabilityWarning
from physcore.spelling import KeywordError, UnknownKey, explained

P = ParamSpec("P")
R = TypeVar("R")

FULL = "PHYSCORE_TRACEBACKS"
"""Environment variable; with the value "full", tracebacks keep the frames of this package."""

_EXPECTED = (PhyscoreError, KeywordError, UnknownKey, FileWarning, MachWarning, SceneWarning, StabilityWarning)
"""Exceptions that tell users of a mistake. Warnings are exceptions under `warnings.simplefilter("error")`."""

_SPECIAL = ("__init__", "__call__", "__getitem__")
"""Methods that users call by an operator or by the name of the class."""


def entrance(function: Callable[P, R]) -> Callable[P, R]:
    """Decorator of a public function: suggests the intended keyword, and hides frames of this package from errors.

    Frames of the user's own functions remain. Internal errors keep all frames, because they are reported.
    """

    @wraps(function)
    def entered(*arguments: P.args, **keywords: P.kwargs) -> R:
        __tracebackhide__ = True  # Debuggers and IPython skip this frame, which remains where all are shown.
        try:
            try:
                return function(*arguments, **keywords)
            except TypeError as error:
                raise explained(error, function, keywords) from error.__cause__
        except _EXPECTED as error:
            _shorten(error)
            raise

    return entered


def entrances(kinds: Iterable[object]) -> None:
    """Apply `entrance` to constructors, public methods and properties of the classes among some objects."""
    for kind in kinds:
        for base in kind.__mro__ if isinstance(kind, type) else ():
            if _is_own(base.__module__):
                for name, member in list(vars(base).items()):
                    if not name.startswith("_") or name in _SPECIAL:
                        _wrap(base, name, member)


def _wrap(kind: type, name: str, member: object) -> None:
    """Apply `entrance` to a method or a property of a class, once."""
    inner = getattr(member, "fget", None) or getattr(member, "__func__", member)
    if not isfunction(inner) or hasattr(inner, "__wrapped__"):
        return
    outer: object = entrance(inner)
    if isinstance(member, property):
        outer = property(entrance(inner), member.fset, member.fdel, member.__doc__)
    elif isinstance(member, (classmethod, staticmethod)):
        outer = type(member)(entrance(inner))
    setattr(kind, name, outer)


def _shorten(error: BaseException) -> None:
    """Remove the frames of this package from the traceback of an error, and from those of its causes."""
    if isinstance(error, InternalError) or os.environ.get(FULL) == "full":
        return
    seen: set[int] = set()
    link: BaseException | None = error
    while link is not None and id(link) not in seen:
        seen.add(id(link))
        link.__traceback__ = _outside(link.__traceback__)
        link = link.__cause__ or link.__context__


def _outside(traceback: TracebackType | None) -> TracebackType | None:
    """The entries of a traceback whose frames are not of this package, nor of its context managers."""
    entries = []
    own = False
    while traceback is not None:
        module = traceback.tb_frame.f_globals.get("__name__", "")
        own = _is_own(module) or (own and module == "contextlib")
        if not own:
            entries.append(traceback)
        traceback = traceback.tb_next
    kept: TracebackType | None = None
    for entry in reversed(entries):
        kept = TracebackType(kept, entry.tb_frame, entry.tb_lasti, entry.tb_lineno)
    return kept


def _is_own(module: str) -> bool:
    """Whether a module belongs to this package."""
    return module.partition(".")[0] == __name__.partition(".")[0]
