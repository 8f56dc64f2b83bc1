"""Records: what a scene item says of itself, found from the fields of its class, and the forms that it takes."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, TypeAlias

import numpy as np

from physcore.storage.archive import Tree

Named: TypeAlias = Mapping[str, "list[int] | None"]
"""The indices of the bodies that fields name; None: all."""
_NONE: Named = {}
_OWN = ("name", "on")
"""Fields that have a place of their own in the engine's form."""


@dataclass(frozen=True, eq=False)
class Record:
    """A kind with named values. Whatever describes an item does so through its record, and names neither."""

    kind: str
    """The name of the class in files, hashes and the engine."""
    values: dict[str, Any]
    """Every field by name; first the arguments of the class, in their order, then what follows from them."""
    arguments: tuple[str, ...]
    """The names of the arguments."""

    @classmethod
    def of(cls, item: object) -> Record:
        """The record of an item, or of another thing with a dataclass; items in its fields are records too."""
        own = _declaring(type(item))
        arguments = tuple(parameters(own))
        named = {entry.name: entry for entry in fields(own)}
        values = {name: getattr(item, name) for name in dict.fromkeys((*arguments, *named))}
        inner = {name: _inner(value) for name, value in values.items()}
        return cls(kind_of(own), inner, arguments)

    @property
    def is_code(self) -> bool:
        """Whether it has functions of the user's, which are not written into files."""
        return any(map(_is_code, self.values.values()))

    def packed(self, bodies: Named = _NONE) -> Tree:
        """The form of files and hashes: the arguments of its class, the rest follows from them; `bodies` as below."""
        values = {name: bodies[name] if name in bodies else pack(self.values[name]) for name in self.arguments}
        return {"kind": self.kind, "fields": values}

    def described(self, bodies: Named = _NONE) -> dict[str, object]:
        """The form of the engine: all values, and the indices of the bodies that fields name; None: all."""
        hidden = (*_OWN, *bodies)
        values = {name: _described(value) for name, value in self.values.items() if name not in hidden}
        indices = {name: None if named is None else np.array(named, int) for name, named in bodies.items()}
        others = {name: named for name, named in indices.items() if name not in _OWN}
        name, on = self.values.get("name"), bodies.get("on")
        return {"kind": self.kind, "name": name, "on": on, "values": {**values, **others}}


def _is_item(value: Any) -> bool:
    """Whether a value has a record of its own."""
    return is_dataclass(value) and not isinstance(value, type)


def _inner(value: Any) -> Any:
    """A value of an item, with records for the items in it."""
    if isinstance(value, Mapping):
        return {name: _inner(each) for name, each in value.items()}
    if isinstance(value, tuple) and any(map(_is_item, value)):
        return tuple(map(_inner, value))
    return Record.of(value) if _is_item(value) else value


def _is_code(value: Any) -> bool:
    """Whether a value is a function, or holds one."""
    if isinstance(value, (tuple, dict)):
        return any(map(_is_code, value.values() if isinstance(value, dict) else value))
    return value.is_code if isinstance(value, Record) else callable(value)


def _described(value: Any) -> object:
    """A value in the form of the engine, to which a list without entries is one that was left open, and a mapping a
    record of no kind.
    """
    if isinstance(value, dict):
        values = {name: _described(each) for name, each in value.items()}
        return {"kind": "", "name": None, "on": None, "values": values}
    if isinstance(value, tuple) and (not value or any(isinstance(each, Record) for each in value)):
        return tuple(map(_described, value)) or None
    return value.described() if isinstance(value, Record) else value


def pack(value: Any) -> Tree:
    """A record, or a thing that has one, in the form of files and hashes; a plain value as it is."""
    if isinstance(value, Record):
        return value.packed()
    if isinstance(value, dict):
        return {name: pack(each) for name, each in value.items()}
    if isinstance(value, tuple):
        return list(map(pack, value)) if any(isinstance(each, Record) for each in value) else value
    return Record.of(value).packed() if _is_item(value) else value


def kind_of(kind: type[Any]) -> str:
    """The name of a class in files, hashes and the engine: its own, where it does not say another as `kind`."""
    own = _declaring(kind)
    name: str = vars(own).get("kind", own.__name__)
    return name


def parameters(kind: type[Any]) -> Mapping[str, inspect.Parameter]:
    """What a class is called with."""
    return inspect.signature(_declaring(kind)).parameters


def _declaring(kind: type[Any]) -> type[Any]:
    """The class that declares the fields: a subclass without fields of its own is of the same kind."""
    return next(each for each in kind.__mro__ if "__dataclass_fields__" in vars(each))
