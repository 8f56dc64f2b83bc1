"""Records of scene items: the values of their fields, in the forms of files, hashes and the engine."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, TypeAlias

import numpy as np

from physcore.checks import BoolArray
from physcore.scene.edges import Sides
from physcore.storage.archive import Tree
from physcore.units.systems import Default

Named: TypeAlias = Mapping[str, "list[Any] | None"]
"""Indices of the bodies that fields name; [index, particles] where a field names some particles; None: all."""
Masks: TypeAlias = Mapping[str, BoolArray]
"""Whether fields name each particle of the scene, for fields that name some particles of a body."""
_NONE: Named = {}
_NO_MASKS: Masks = {}
_OWN = ("name", "on")
"""Fields that have a separate place in the form of the engine."""


@dataclass(frozen=True, eq=False)
class Record:
    """Record of an object: its class name and its named values, from which all other forms are made."""

    kind: str
    """Name of the class in files, hashes and the engine."""
    values: dict[str, Any]
    """All fields by name: first the arguments of the class, in order, then the derived fields."""
    arguments: tuple[str, ...]
    """Names of the arguments."""

    @classmethod
    def of(cls, item: object) -> Record:
        """The record of an item, or of another dataclass instance; items in its fields become records too."""
        own = _declaring(type(item))
        arguments = tuple(parameters(own))
        named = {entry.name: entry for entry in fields(own)}
        values = {name: getattr(item, name) for name in dict.fromkeys((*arguments, *named))}
        inner = {name: _inner(value) for name, value in values.items()}
        return cls(kind_of(own), inner, arguments)

    @property
    def code(self) -> str:
        """Path of the first user function, which cannot be saved, such as ".wind"; empty if there is none."""
        return next((path for path, _ in self.functions()), "")

    def functions(self) -> Iterator[tuple[str, object]]:
        """User functions with their paths, such as ".wind"."""
        return _functions(self, "")

    def packed(self, bodies: Named = _NONE) -> Tree:
        """The form of files and hashes: the arguments of the class. `bodies` as in `described`."""
        values = {name: bodies[name] if name in bodies else pack(self.values[name]) for name in self.arguments}
        return {"kind": self.kind, "fields": values}

    def described(self, bodies: Named = _NONE, masks: Masks = _NO_MASKS) -> dict[str, object]:
        """The form of the engine: all values, and the indices of the bodies that fields name, or masks of particles."""
        hidden = (*_OWN, *bodies)
        values = {name: _described(value) for name, value in self.values.items() if name not in hidden}
        indices = {name: None if named is None else np.array(named, int) for name, named in bodies.items()}
        others = {name: masks.get(name, named) for name, named in indices.items() if name not in _OWN}
        return _form(self.kind, {**values, **others}, self.values.get("name"), bodies.get("on"), masks.get("on"))


def _form(
    kind: str,
    values: dict[str, object],
    name: str | None = None,
    on: list[int] | None = None,
    members: BoolArray | None = None,
) -> dict[str, object]:
    """The form of the engine."""
    return {"kind": kind, "name": name, "on": on, "members": members, "values": values}


def _is_item(value: Any) -> bool:
    """Whether a value has a record of its own."""
    return is_dataclass(value) and not isinstance(value, type)


def _inner(value: Any) -> Any:
    """A value with records in place of items."""
    if isinstance(value, Mapping):
        return {name: _inner(each) for name, each in value.items()}
    if isinstance(value, tuple) and any(map(_is_item, value)):
        return type(value)(map(_inner, value))
    return Record.of(value) if _is_item(value) else value


def _functions(value: Any, path: str) -> Iterator[tuple[str, object]]:
    """The functions in a value at a path, with their own paths."""
    if isinstance(value, Record):
        parts = [(f".{name}", each) for name, each in value.values.items()]
    elif isinstance(value, dict):
        parts = [(f"[{key!r}]", each) for key, each in value.items()]
    elif isinstance(value, tuple):
        keys = Sides.names if isinstance(value, Sides) else range(len(value))
        parts = [(f"[{key!r}]", each) for key, each in zip(keys, value, strict=False)]
    else:
        if callable(value):
            yield path, value
        return
    for part, each in parts:
        yield from _functions(each, path + part)


def _described(value: Any) -> object:
    """A value in the form of the engine. An empty tuple becomes None, a mapping becomes a record without a class."""
    if isinstance(value, dict):
        return _form("", {name: _described(each) for name, each in value.items()})
    if isinstance(value, tuple) and (not value or any(isinstance(each, Record) for each in value)):
        return tuple(map(_described, value)) or None
    return value.described() if isinstance(value, Record) else value


def pack(value: Any) -> Tree:
    """A record, or an object that has one, in the form of files and hashes; other values unchanged."""
    if isinstance(value, Record):
        return value.packed()
    if isinstance(value, dict):
        return {name: pack(each) for name, each in value.items()}
    if isinstance(value, tuple):
        return list(map(pack, value)) if any(isinstance(each, Record) for each in value) else value
    if isinstance(value, Default):
        return float(value)
    return Record.of(value).packed() if _is_item(value) else value


def kind_of(kind: type[Any]) -> str:
    """The name of a class in files, hashes and the engine."""
    return _declaring(kind).__name__


def parameters(kind: type[Any]) -> Mapping[str, inspect.Parameter]:
    """The parameters of a class, which are looked up once."""
    if kind not in _PARAMETERS:
        _PARAMETERS[kind] = inspect.signature(_declaring(kind)).parameters
    return _PARAMETERS[kind]


_PARAMETERS: dict[type[Any], Mapping[str, inspect.Parameter]] = {}
"""Parameters of classes of items, because inspection takes longer than the description of an item."""


def _declaring(kind: type[Any]) -> type[Any]:
    """The class that declares the fields; a subclass without own fields has the name of its parent."""
    return next(each for each in kind.__mro__ if "__dataclass_fields__" in vars(each))
