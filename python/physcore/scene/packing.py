"""Things as trees of plain values: their kind, and what their class was given, which they have under the same names."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from dataclasses import is_dataclass
from typing import Any

from physcore.errors import FileError
from physcore.scene.bodies import Body
from physcore.scene.items import SceneItem
from physcore.storage.archive import Tree


def pack(value: Any) -> Tree:
    """A thing as its kind and its fields; a plain value as it is."""
    if not is_dataclass(value):
        return value
    names = inspect.signature(type(value)).parameters
    return {"kind": kind_of(type(value)), "fields": {name: pack(getattr(value, name)) for name in names}}


def kind_of(kind: type[Any]) -> str:
    """The name of a class in files and hashes."""
    return kind.kind if issubclass(kind, SceneItem) else kind.__name__


def pack_items(items: Sequence[SceneItem], bodies: Sequence[Body], path: str) -> list[Tree]:
    """Forces or boundaries; the bodies that they act on by index, because a body is saved once.

    Raises:
        FileError: one of them is made of functions, which cannot be saved.
    """
    trees = []
    for position, item in enumerate(items):
        if item.is_code:
            raise FileError(
                f"{path}[{position}]: a {type(item).__name__} cannot be saved, because its function is code; "
                "save the arrays that you need with numpy.savez, or express the force by the ones that physcore has"
            )
        tree, named = pack(item), item.bodies()
        tree["fields"]["on"] = None if named is None else [bodies.index(body) for body in named]
        trees.append(tree)
    return trees
