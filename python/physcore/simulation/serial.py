"""Serialization of scenes and numerics: trees of plain values, from the arguments of their classes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields
from functools import partial
from itertools import chain
from typing import Any, cast

from physcore.boundaries import BOUNDARIES
from physcore.constraints import CONSTRAINTS
from physcore.errors import FileError, SceneError
from physcore.forces import FORCES
from physcore.numerics.choices import AdaptiveStep, AutoStep, Numerics, Options
from physcore.numerics.contacts import ContactSolver
from physcore.numerics.fluids import FLUID_METHODS
from physcore.numerics.integrators import INTEGRATORS
from physcore.scene.bodies import Body, Particles, SpringNetwork
from physcore.scene.fluid import Fluid
from physcore.scene.items import SceneItem
from physcore.scene.kernels import KERNELS
from physcore.scene.periodic import Periodic
from physcore.scene.polytopes import SHAPES
from physcore.scene.probe import Probe
from physcore.scene.records import kind_of, pack, parameters
from physcore.scene.rigid import RigidBodies
from physcore.scene.scene import Scene
from physcore.scene.selection import Selection
from physcore.storage.archive import Tree
from physcore.storage.schema import Rule, anything, either, maybe, of, real, record, several, table, text, whole, word
from physcore.systems import SYSTEMS
from physcore.units.systems import Unit, UnitSystem

_BODIES = (Particles, SpringNetwork, Fluid, RigidBodies)
_RULES = (*INTEGRATORS, *FLUID_METHODS, ContactSolver, AutoStep, AdaptiveStep)
_SECTIONS: dict[str, tuple[type[SceneItem], ...]] = {
    "forces": FORCES,
    "boundaries": BOUNDARIES,
    "constraints": CONSTRAINTS,
}
_PARTS = (*KERNELS, *SHAPES, *dict.fromkeys(chain.from_iterable(kind.parts for kind in (*FORCES, *SYSTEMS))))
"""Classes of objects within items."""
_ITEMS: dict[str, type[SceneItem]] = {kind_of(kind): kind for kind in (*chain(*_SECTIONS.values()), *SYSTEMS)}
"""Classes that may name others, by their names in files."""

_UNIT = of(Unit, value=maybe(real()))
_SCENE = record(
    {"units": record(length=_UNIT, time=_UNIT, mass=_UNIT, charge=_UNIT)},
    bodies=several(anything),
    forces=several(anything),
    boundaries=several(anything),
    constraints=several(anything),
    systems=several(anything),
    probes=several(anything),
    periodic=anything,
)
_THING = record(kind=text, fields=anything)


def unpack_scene(tree: Tree, path: str = "scene") -> Scene:
    """The scene from the result of `Scene.packed`.

    Raises:
        FileError: the tree is not that of a scene; the message has the path of the entry.
    """
    content = _SCENE(tree, path)
    bodies = [_unpack(entry, f"{path}.bodies[{index}]", _BODIES) for index, entry in enumerate(content["bodies"])]
    acting: list[Any] = []
    for name, kinds in _SECTIONS.items():
        unpacked = partial(_unpack_item, kinds=kinds, bodies=bodies)
        acting += _unpack_linked(content[name], f"{path}.{name}", unpacked)
    systems = _unpack_linked(content["systems"], f"{path}.systems", partial(_unpack, kinds=SYSTEMS))
    probes = [_unpack(entry, f"{path}.probes[{index}]", (Probe,)) for index, entry in enumerate(content["probes"])]
    domain = content["periodic"]
    items = [] if domain is None else [_unpack(domain, f"{path}.periodic", (Periodic,))]
    with _named(path):
        named = {kind: Unit(**unit) for kind, unit in content.get("units", {}).items()}
        units = UnitSystem(**named) if named else None
        return Scene(*bodies, *acting, *systems, *probes, *items, units=units)


def pack_numerics(numerics: Numerics) -> Tree:
    """Numerical options as a tree."""
    own = {entry.name: pack(getattr(numerics, entry.name)) for entry in fields(numerics)}
    several = {path: pack(integrator) for path, integrator in own.pop("integrators").items()}
    methods = {path: pack(method) for path, method in own.pop("fluids").items()}
    one = next(iter(methods.values()), None)
    fluids = {"fluids": one if len(set(numerics.fluids.values())) == 1 else methods} if methods else {}
    if numerics.contacts is None:
        own.pop("contacts")
    return {**own, "integrator": several or own["integrator"], **fluids}


def unpack_numerics(tree: Tree, path: str = "numerics") -> Options:
    """The numerical options from the result of `pack_numerics`, as arguments of Simulation.

    Raises:
        FileError: the tree is not that of numerical options.
    """
    optional = {"fluids": anything, "contacts": anything}
    known = {entry.name: anything for entry in fields(Numerics) if entry.name not in ("integrators", *optional)}
    content = record(optional, **known)(tree, path)
    kinds: dict[str, tuple[type[Any], ...]] = {
        "integrator": INTEGRATORS,
        "fluids": FLUID_METHODS,
        "contacts": (ContactSolver,),
    }
    values = {name: _unpack_choice(value, f"{path}.{name}", kinds.get(name)) for name, value in content.items()}
    return cast(Options, values)


def _unpack_choice(tree: Tree, path: str, kinds: tuple[type[Any], ...] | None) -> Any:
    """A numerical option: an object, or several by the paths of their items."""
    if kinds is not None and isinstance(tree, dict) and "kind" not in tree:
        return {key: _unpack(each, f"{path}[{key!r}]", kinds) for key, each in tree.items()}
    return _unpack_value(tree, path, kinds or _RULES)


def _unpack(tree: Tree, path: str, kinds: tuple[type[Any], ...]) -> Any:
    """An object of one of some classes, from the result of `pack`."""
    thing = _THING(tree, path)
    named = {kind_of(kind): kind for kind in kinds}
    kind = named[word(*named)(thing["kind"], f"{path}.kind")]
    fields_of = record(**dict.fromkeys(parameters(kind), anything))(thing["fields"], f"{path}.fields")
    values = {name: _unpack_value(value, f"{path}.{name}", _PARTS) for name, value in fields_of.items()}
    with _named(path):
        return kind(**values)


@contextmanager
def _named(path: str) -> Iterator[None]:
    """Convert errors of a class about its arguments to errors of the file."""
    try:
        yield
    except SceneError as error:
        raise FileError(f"{path}: {error}") from error


def _unpack_value(tree: Tree, path: str, kinds: tuple[type[Any], ...]) -> Any:
    if isinstance(tree, list) and any(isinstance(each, dict) for each in tree):
        return tuple(_unpack_value(each, f"{path}[{index}]", kinds) for index, each in enumerate(tree))
    if isinstance(tree, dict) and kinds and "kind" not in tree:
        return {name: _unpack_value(each, f"{path}[{name!r}]", kinds) for name, each in tree.items()}
    return _unpack(tree, path, kinds) if isinstance(tree, dict) and kinds else tree


def _unpack_linked(trees: Sequence[Tree], path: str, unpacked: Callable[[Tree, str], Any]) -> list[Any]:
    """Items of one section; an item that names another, by its index, is created after that."""
    found: dict[int, Any] = {}
    waiting = dict(enumerate(trees))
    while waiting:
        ready = {index: _with_named(tree, f"{path}[{index}]", found) for index, tree in waiting.items()}
        done = {index: tree for index, tree in ready.items() if tree is not None}
        if not done:
            raise FileError(f"{path}: must name items of the scene, and not each other in turn")
        found |= {index: unpacked(tree, f"{path}[{index}]") for index, tree in done.items()}
        waiting = {index: tree for index, tree in waiting.items() if index not in done}
    return [found[index] for index in range(len(trees))]


def _with_named(tree: Tree, path: str, found: dict[int, Any]) -> Tree | None:
    """The tree of an item with the named items in place of their indices; None if one of them does not exist yet."""
    thing = _THING(tree, path)
    values = table(anything)(thing["fields"], f"{path}.fields")
    for field in getattr(_ITEMS.get(thing["kind"]), "linking", ()):
        if isinstance(values.get(field), list):
            (index,) = several(whole(), lengths=(1,))(values[field], f"{path}.{field}")
            if index not in found:
                return None
            values = {**values, field: found[index]}
    return {**tree, "fields": values}


def _unpack_item(tree: Tree, path: str, kinds: tuple[type[Any], ...], bodies: list[Body]) -> Any:
    thing = _THING(tree, path)
    values = table(anything)(thing["fields"], f"{path}.fields")
    named: dict[str, list[Body | Selection]] = {}
    index = whole(most=len(bodies) - 1)
    rule = maybe(several(either(list, several(anything, lengths=(2,)), index)))
    for field in getattr(_ITEMS.get(thing["kind"]), "naming", ()):
        own = f"{path}.{field}"
        targets = rule(values.get(field), own)
        named |= {} if targets is None else {field: [_target(each, own, bodies, index) for each in targets]}
    return _unpack({**tree, "fields": {**values, **named}}, path, kinds)


def _target(tree: Tree, path: str, bodies: list[Body], index: Rule) -> Body | Selection:
    """A body from its index, or some of its particles from the index with those of the particles."""
    if not isinstance(tree, tuple):
        return bodies[tree]
    with _named(path):
        return Selection(bodies[index(tree[0], path)], tree[1], path)
