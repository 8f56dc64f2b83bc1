"""Scenes and numerics as trees of plain values, from the arguments of their classes, and back."""

from __future__ import annotations

import inspect
from dataclasses import fields
from typing import Any, cast

from physcore.bodies import Body, Particles, SpringNetwork
from physcore.boundaries import BOUNDARIES
from physcore.errors import FileError
from physcore.fluid import Fluid
from physcore.forces import FORCES, CustomForce
from physcore.influence import Influence
from physcore.integrators import INTEGRATORS
from physcore.kernels import KERNELS
from physcore.numerics import AdaptiveStep, AutoStep, Numerics, Options
from physcore.periodic import Periodic
from physcore.scene import Scene
from physcore.storage import Tree

_BODIES = (Particles, SpringNetwork, Fluid)
_KINDS: dict[str, type[Any]] = {
    kind.__name__: kind
    for kind in (*_BODIES, *KERNELS, *FORCES, *BOUNDARIES, Periodic, *INTEGRATORS, AutoStep, AdaptiveStep)
}


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


def unpack_scene(tree: Tree) -> Scene:
    """The scene that `pack_scene` was given."""
    bodies = [_unpack(entry) for entry in tree["bodies"]]
    influences = [_unpack_influence(entry, bodies) for entry in (*tree["forces"], *tree["boundaries"])]
    domain = _unpack_value(tree["periodic"])
    return Scene(*bodies, *influences, *([] if domain is None else [domain]))


def pack_numerics(numerics: Numerics) -> Tree:
    """Numerical choices as a tree."""
    return {entry.name: _pack_value(getattr(numerics, entry.name)) for entry in fields(numerics)}


def unpack_numerics(tree: Tree) -> Options:
    """The numerical choices that `pack_numerics` was given, as arguments of Simulation."""
    return cast(Options, {name: _unpack_value(value) for name, value in tree.items()})


def _pack(value: Any) -> dict[str, Tree]:
    """The kind of a thing and what its class was given, which it has under the same names."""
    names = inspect.signature(type(value)).parameters
    return {"kind": type(value).__name__, "fields": {name: _pack_value(getattr(value, name)) for name in names}}


def _unpack(tree: dict[str, Tree]) -> Any:
    return _KINDS[tree["kind"]](**{name: _unpack_value(value) for name, value in tree["fields"].items()})


def _pack_value(value: Any) -> Tree:
    """A plain value as it is, and a thing of a known kind as a tree."""
    return _pack(value) if type(value) in _KINDS.values() else value


def _unpack_value(tree: Tree) -> Any:
    return _unpack(tree) if isinstance(tree, dict) else tree


def _pack_influence(influence: Influence, scene: Scene) -> dict[str, Tree]:
    tree = _pack(influence)
    bodies = influence.bodies()  # By index: a body is saved once.
    tree["fields"]["on"] = None if bodies is None else [scene.index(body) for body in bodies]
    return tree


def _unpack_influence(tree: dict[str, Tree], bodies: list[Body]) -> Any:
    on = tree["fields"]["on"]
    values = {**tree["fields"], "on": None if on is None else [bodies[index] for index in on]}
    return _unpack({**tree, "fields": values})
