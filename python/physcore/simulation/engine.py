"""The way to the engine: a scene and its numerics in, a World out. No other file builds one."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from physcore._core import World
from physcore.checks import BoolArray, FloatArray
from physcore.errors import SceneError, SceneWarning, warn
from physcore.numerics.choices import Limit, Numerics
from physcore.numerics.fluids import FluidMethod
from physcore.scene.bodies import Body
from physcore.scene.fields import FIELDS, RIGID, Field
from physcore.scene.items import ActingItem, SceneItem
from physcore.scene.records import Record
from physcore.scene.scene import Scene, indices
from physcore.simulation.plan import Plan
from physcore.simulation.state import FieldInfo, Snapshot

if TYPE_CHECKING:
    from physcore._core import StagesRecord

S = TypeVar("S", bound=Snapshot)
WARNING = "warning: "
"""Beginning of those notes of the engine that are warnings of probable mistakes in a scene."""
PLACES = ("positions", "rigid_positions")
"""Fields of positions in the periodic domain."""


def build(scene: Scene, numerics: Numerics) -> World:
    """Hand a scene to the engine.

    Raises:
        SceneError: the engine cannot do what was asked, or something starts outside of a boundary or within a body.

    Warns:
        SceneWarning: rigid bodies, or particles and rigid bodies, overlap a little at the start.
    """
    try:
        world = World(
            describe(scene, numerics),
            Record.of(numerics.integrator).described(),
            {path: Record.of(integrator).described() for path, integrator in numerics.integrators.items()},
            numerics.precision,
            numerics.threads,
            numerics.max_energy_growth,
            numerics.on_divergence,
        )
    except SceneError as error:
        raise SceneError(named(str(error), scene)) from error.__cause__
    for note in (note for system in world.plan()["systems"] for note in system["notes"]):
        if note.startswith(WARNING):
            warn(named(note.removeprefix(WARNING), scene), SceneWarning)
    return world


def named(message: str, scene: Scene) -> str:
    """A message of the engine with what it does not know: names of bodies, their methods, and the scene's units."""
    message = re.sub(r"\bbodies\[\d+\]\.method\b", "fluids", message)
    message = re.sub(r"\bbodies\[\d+\]\.contacts\b", "contacts", message)
    message = re.sub(r"\bbodies\[(\d+)\]", lambda found: scene.path(int(found[1])), message)
    return scene.units.reworded(message)


def describe(scene: Scene, numerics: Numerics) -> dict[str, object]:
    """A scene as plain dictionaries, numbers and arrays: the records of its items with their methods."""
    methods = [numerics.fluids.get(scene.path(index)) for index in range(len(scene.bodies))]
    return {
        "dimension": scene.dimension,
        "bodies": [_body(body, method, numerics) for body, method in zip(scene.bodies, methods, strict=True)],
        "forces": [_item(force, scene) for force in scene.forces],
        "boundaries": [_item(boundary, scene) for boundary in scene.boundaries],
        "constraints": [_item(constraint, scene) for constraint in scene.constraints],
        "systems": [_item(system, scene) for system in scene.systems],
        "probes": [_item(probe, scene) for probe in scene.probes],
        "periodic": None if scene.periodic is None else Record.of(scene.periodic).described(),
    }


def is_same(one: object, other: object) -> bool:
    """Whether two descriptions of scenes are equal, in all numbers and arrays; functions must be the same objects."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(is_same(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        return len(one) == len(other) and all(map(is_same, one, other))
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return type(one) is type(other) and bool(one == other)


def fields(world: World, scene: Scene) -> list[FieldInfo]:
    """The fields of the elements of a world. Without bodies there are positions and velocities of no particles.

    The engine has a row for each rigid body in the fields of particles. Here rigid bodies have fields of their own.
    """
    none = (
        []
        if scene.bodies
        else [_nothing("positions", "m", "velocities", scene), _nothing("velocities", "m/s", None, scene)]
    )
    known = none + [
        FieldInfo(name, scene.units.symbol(unit), tuple(shape), rate, state)
        for name, unit, location, shape, rate, state in world.fields()
        if location != "whole"
    ]
    if not scene.has_rigid_bodies:
        return known
    split = scene.fields
    return [own for info in known for own in _split(info, split)]


def _split(info: FieldInfo, fields: Mapping[str, Field]) -> list[FieldInfo]:
    """A field of the engine as the fields of particles and of rigid bodies that it consists of."""
    own = {name: field for name, field in fields.items() if field.source == info.name}
    rates = {FIELDS[name].source: name for name in RIGID}
    return [
        replace(
            info,
            name=name,
            shape=field.shape,
            rate=rates.get(info.rate or "", info.rate) if field.element == "rigid bodies" else info.rate,
        )
        for name, field in own.items()
    ] or [info]


def read(world: World, scene: Scene, name: str) -> FloatArray:
    """The values of a field. Positions are where particles have gone: `show` puts them into the domain."""
    if not scene.bodies and name in ("positions", "velocities"):
        return np.empty((0, scene.dimension))
    if not scene.has_rigid_bodies or name not in FIELDS:
        return world.read(name)
    field = FIELDS[name]
    values, rows = world.read(field.source), _rows(field, scene)
    return values if rows is None else values[rows]


def write(world: World, scene: Scene, fields: dict[str, FloatArray]) -> None:
    """Replace fields.

    Raises:
        SceneError: a value is not possible.
    """
    if scene.has_rigid_bodies:
        merged: dict[str, FloatArray] = {}
        for name, values in fields.items():
            source = FIELDS[name].source if name in FIELDS else name
            rows = _rows(FIELDS[name], scene) if name in FIELDS else None
            if rows is None:
                merged[source] = values
            else:
                merged.setdefault(source, world.read(source))[rows] = values
        fields = merged
    world.write(fields)


def _rows(field: Field, scene: Scene) -> BoolArray | None:
    """The rows of a field in the engine's field of particles; None for other fields."""
    if field.element in ("particles", "fluid particles"):
        return scene.are_particles
    return ~scene.are_particles if field.source != field.name else None


def snapshot(world: World, scene: Scene) -> Snapshot:
    """The present state, with positions as `read` gives them."""
    values = {info.name: read(world, scene, info.name) for info in fields(world, scene)}
    return Snapshot(world.time, values, scene=scene)


def shown(state: S, scene: Scene) -> S:
    """A snapshot as the user sees it."""
    if scene.periodic is None:
        return state
    places = {name: show(state.fields[name], scene) for name in PLACES if name in state.fields}
    return replace(state, fields={**state.fields, **places})


def show(positions: FloatArray, scene: Scene) -> FloatArray:
    """Positions as the user sees them: within the periodic domain, if there is one."""
    return positions if scene.periodic is None else scene.periodic.wrap(positions)


def _nothing(name: str, unit: str, rate: str | None, scene: Scene) -> FieldInfo:
    """A field of no particles."""
    return FieldInfo(name, scene.units.symbol(unit), (0, scene.dimension), rate, state=True)


def limit(world: World) -> Limit:
    """The limit of the time step in the world's present state."""
    return Limit(**world.limit())


def certified(world: World) -> float:
    """The limit [s] that holds wherever springs turn, while none is shorter than half its rest length."""
    return world.certified()


def present_limit(world: World) -> Limit:
    """The limit of one step from the world's present state [s], whatever is ahead; a certified one."""
    return Limit(**world.present_limit())


def limit_varies(world: World) -> bool:
    """Whether the limit of the time step changes with the state."""
    return any(system["limit_varies"] for system in world.plan()["systems"])


def evaluations(world: World) -> int:
    """Evaluations of the rates per step: the most of any system."""
    return max(system["evaluations"] for system in world.plan()["systems"])


def plan(world: World, scene: Scene, bound: Limit, dt: float) -> Plan:
    """The plan of a world, with the time step and its limit."""
    facts = world.plan()
    first, *others = facts["systems"]
    notes = (*first["notes"], *(note for system in others for note in (_summary(system), *system["notes"])))
    return Plan(
        stages=tuple(first["stages"]),
        dimension=first["dimension"],
        precision=first["precision"],
        integrator=first["integrator"],
        order=min(system["order"] for system in facts["systems"]),
        evaluations=evaluations(world),
        pairs=sum(system["pairs"] for system in facts["systems"]),
        force_error=max((system["force_error"] for system in facts["systems"]), default=0.0),
        dt=dt,
        dt_limit=bound.dt,
        limit_kind=bound.kind,
        limit_term=bound.term,
        memory=facts["memory"],
        threads=facts["threads"],
        simd=facts["simd"],
        layout=scene.units.reworded(first["layout"]),
        left_out=tuple(first["left_out"]),
        notes=tuple(named(note.removeprefix(WARNING), scene) for note in notes),
        units=scene.units,
    )


def _summary(system: StagesRecord) -> str:
    """One line on a system beside the first one."""
    return (
        f"{system['item']}: {' → '.join(system['stages'])}, by {system['integrator']} of order {system['order']}, "
        f"{system['layout']}"
    )


def _body(body: Body, method: FluidMethod | None, numerics: Numerics) -> dict[str, Any]:
    """A body; a fluid with its method, rigid bodies with the solver of their contacts."""
    described: dict[str, Any] = Record.of(body).described()
    added = {"method": method, "contacts": numerics.contacts if body.is_rigid else None}
    records = {name: Record.of(each).described() for name, each in added.items() if each is not None}
    return {**described, "values": {**described["values"], **records}}


def _item(item: SceneItem, scene: Scene) -> dict[str, object]:
    """An item as it is in the scene, with the indices of the bodies that it acts on, if not on all."""
    record = Record.of(item.resolved(scene.dimension))
    if not isinstance(item, ActingItem):
        return record.described(indices(scene, item))
    bodies = {field: item.bodies(field) for field in item.naming}
    targets = scene.targets(item)
    bodies["on"] = None if targets == scene.bodies else targets
    named = {field: None if own is None else [scene.index(body) for body in own] for field, own in bodies.items()}
    other = item.references(scene)
    masks = {field: scene.rows(item, field) for field in item.partial if field not in other}
    described = record.described(named | dict.fromkeys(other), masks)
    return {**described, "values": {**cast("dict[str, object]", described["values"]), **other}}
