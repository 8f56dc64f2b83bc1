"""Scenes and numerics as trees of plain values, from the arguments of their classes, and back."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from typing import Any, cast

from physcore.bodies import Body, Particles, SpringNetwork
from physcore.boundaries import BOUNDARIES
from physcore.errors import FileError, SceneError
from physcore.fluid import Fluid
from physcore.forces import FORCES, CustomForce
from physcore.influence import Influence
from physcore.integrators import INTEGRATORS
from physcore.kernels import KERNELS
from physcore.numerics import AdaptiveStep, AutoStep, Numerics, Options
from physcore.periodic import Periodic
from physcore.scene import Scene
from physcore.schema import anything, maybe, record, several, table, text, whole, word
from physcore.storage import Tree

_BODIES = (Particles, SpringNetwork, Fluid)
_RULES = (*INTEGRATORS, AutoStep, AdaptiveStep)
_KINDS: dict[str, type[Any]] = {
    kind.__name__: kind for kind in (*_BODIES, *KERNELS, *FORCES, *BOUNDARIES, Periodic, *_RULES)
}

_SCENE = record(bodies=several(anything), forces=several(anything), boundaries=several(anything), periodic=anything)
_THING = record(kind=text, fields=anything)


def pack_scene(scene: Scene) -> Tree:
    """A scene as a tree.

    Raises:
        FileError: the scene has a CustomForce, whose function cannot be saved.
    """
    for position, force in enumerate(scene.forces):
        if isinstance(force, CustomForce):
            raise FileError(
                f"forces[{position}]: a CustomForce cannot be saved, because its function is code; "
                "save the arrays that you need with numpy.savez, or express the force by the ones that physcore has"
            )
    return {
        "bodies": [_pack(body) for body in scene.bodies],
        "forces": [_pack_influence(force, scene) for force in scene.forces],
        "boundaries": [_pack_influence(boundary, scene) for boundary in scene.boundaries],
        "periodic": _pack_value(scene.periodic),
    }


def unpack_scene(tree: Tree, path: str = "scene") -> Scene:
    """The scene that `pack_scene` was given.

    Raises:
        FileError: the tree is no scene's; with the path of the entry.
    """
    content = _SCENE(tree, path)
    bodies = [_unpack(entry, f"{path}.bodies[{index}]", _BODIES) for index, entry in enumerate(content["bodies"])]
    influences = [
        _unpack_influence(entry, f"{path}.{room}[{index}]", kinds, bodies)
        for room, kinds in (("forces", FORCES), ("boundaries", BOUNDARIES))
        for index, entry in enumerate(content[room])
    ]
    domain = content["periodic"]
    items = [] if domain is None else [_unpack(domain, f"{path}.periodic", (Periodic,))]
    with _named(path):
        return Scene(*bodies, *influences, *items)


def pack_numerics(numerics: Numerics) -> Tree:
    """Numerical choices as a tree."""
    return {entry.name: _pack_value(getattr(numerics, entry.name)) for entry in fields(numerics)}


def unpack_numerics(tree: Tree, path: str = "numerics") -> Options:
    """The numerical choices that `pack_numerics` was given, as arguments of Simulation.

    Raises:
        FileError: the tree has something else.
    """
    content = record(dict.fromkeys(Options.__annotations__, anything))(tree, path)
    return cast(Options, {name: _unpack_value(value, f"{path}.{name}", _RULES) for name, value in content.items()})


def _pack(value: Any) -> dict[str, Tree]:
    """The kind of a thing and what its class was given, which it has under the same names."""
    names = inspect.signature(type(value)).parameters
    return {"kind": type(value).__name__, "fields": {name: _pack_value(getattr(value, name)) for name in names}}


def _unpack(tree: Tree, path: str, kinds: tuple[type[Any], ...]) -> Any:
    """The thing of one of some kinds that `_pack` was given."""
    thing = _THING(tree, path)
    kind = _KINDS[word(*(each.__name__ for each in kinds))(thing["kind"], f"{path}.kind")]
    parameters = inspect.signature(kind).parameters.values()
    optional = {each.name: anything for each in parameters if each.default is not each.empty}
    required = {each.name: anything for each in parameters if each.default is each.empty}
    fields_of = record(optional, **required)(thing["fields"], f"{path}.fields")
    values = {name: _unpack_value(value, f"{path}.{name}", KERNELS) for name, value in fields_of.items()}
    with _named(path):
        return kind(**values)


@contextmanager
def _named(path: str) -> Iterator[None]:
    """What a class refuses is wrong in the file."""
    try:
        yield
    except SceneError as error:
        raise FileError(f"{path}: {error}") from error


def _pack_value(value: Any) -> Tree:
    """A plain value as it is, and a thing of a known kind as a tree."""
    return _pack(value) if type(value) in _KINDS.values() else value


def _unpack_value(tree: Tree, path: str, kinds: tuple[type[Any], ...]) -> Any:
    return _unpack(tree, path, kinds) if isinstance(tree, dict) and kinds else tree


def _pack_influence(influence: Influence, scene: Scene) -> dict[str, Tree]:
    tree = _pack(influence)
    bodies = influence.bodies()  # By index: a body is saved once.
    tree["fields"]["on"] = None if bodies is None else [scene.index(body) for body in bodies]
    return tree


def _unpack_influence(tree: Tree, path: str, kinds: tuple[type[Any], ...], bodies: list[Body]) -> Any:
    values = table(anything)(_THING(tree, path)["fields"], f"{path}.fields")
    indices = maybe(several(whole(most=len(bodies) - 1)))(values.get("on"), f"{path}.on")
    on = None if indices is None else [bodies[index] for index in indices]
    return _unpack({**tree, "fields": {**values, "on": on}}, path, kinds)
