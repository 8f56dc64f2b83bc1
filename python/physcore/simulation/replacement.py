"""Replacement of a scene while it runs: the state is carried over by the names of items."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

import numpy as np

from physcore._core import World
from physcore.checks import FloatArray
from physcore.errors import SceneError
from physcore.numerics.choices import BODIES, Integrators, Numerics, Options, check
from physcore.numerics.fluids import FluidMethod
from physcore.scene.bodies import Body, SpringNetwork
from physcore.scene.channels import first_spring
from physcore.scene.fluid import Fluid
from physcore.scene.items import System
from physcore.scene.scene import BodyKey, Scene
from physcore.simulation import engine

Item = TypeVar("Item", Body, System)
_RENAME = "with another name it begins as the scene says"


def require_alike(scene: Scene, before: Scene) -> None:
    """Refuse a scene to which the state of another cannot be carried over.

    Raises:
        SceneError: the dimension or the units differ, or items that both have; with the name of the item.
    """
    if scene.dimension != before.dimension:
        raise SceneError(
            f"replace.scene: must be in {before.dimension}D as before, got {scene.dimension}D; start a new Simulation"
        )
    if scene.units != before.units:
        raise SceneError("replace.scene: must have the units of the scene before; build it with the same units=")
    for one, other in pairs(before.bodies, scene.bodies, before.path, scene.path):
        path = f"replace.{scene.path(other)}"
        if isinstance(one, Fluid) != isinstance(other, Fluid):
            raise SceneError(f"{path}: is a {type(other).__name__}, and was a {type(one).__name__}; {_RENAME}")
        if len(one) != len(other):
            raise SceneError(f"{path}.positions: must be {len(one)} as before, got {len(other)}; {_RENAME}")
    for was, system in _systems(scene, before):
        path = f"replace.{scene.system(system)}"
        if type(system) is not type(was):
            raise SceneError(f"{path}: is a {type(system).__name__}, and was a {type(was).__name__}; {_RENAME}")
        known = was.shapes()
        for name, shape in system.shapes().items():
            if known.get(name) != shape:
                found = (
                    f"must have the shape {known[name]} of before, got {shape}" if name in known else "was not there"
                )
                raise SceneError(f"{path}.{name}: {found}; {_RENAME}")


def numerics_for(scene: Scene, before: Scene, numerics: Numerics) -> Numerics:
    """The numerical choices for a changed scene: those before, where they are possible, and defaults for new items.

    Raises:
        SceneError: a choice is not possible for the new scene.
    """
    integrators: dict[Any, Any] = {}
    if scene.bodies and before.bodies:
        integrators[BODIES] = numerics.integrators.get(BODIES, numerics.integrator)
    for was, system in _systems(scene, before):
        path = str(before.system(was))
        integrators[system] = numerics.integrators.get(path, numerics.integrator)
    fluids = pairs(before.bodies, scene.bodies, before.path, scene.path)
    methods: dict[BodyKey, FluidMethod | str] = {
        other: numerics.fluids[before.path(one)]
        for one, other in fluids
        if isinstance(one, Fluid) and isinstance(other, Fluid)
    }
    chosen: Integrators = integrators or "auto"
    options = Options(
        integrator=chosen,
        dt=numerics.dt,
        precision=numerics.precision,
        threads=numerics.threads,
        max_energy_growth=numerics.max_energy_growth,
        on_divergence=numerics.on_divergence,
        fluids=methods or "auto",
    )
    return check(options, scene)


def carry(world: World, scene: Scene, old: World, before: Scene) -> None:
    """Carry clock and state over to the world of a changed scene.

    Fields are written by name. All else is found anew from the state: lists of neighbors, warm starts of constraints,
    earlier steps of methods that use them.

    Raises:
        SceneError: something cannot be carried over; with its name.
    """
    clock, past = world.capture(), old.capture()
    for name in ("clock", "steps", "taken_back"):
        clock[name] = past[name]
    clock["adaptation"] = np.concatenate([past["adaptation"][:2], clock["adaptation"][2:]])
    world.restore(clock)
    fields = {info.name: engine.read(world, scene, info.name) for info in engine.fields(world, scene) if info.state}
    if scene.bodies:
        _carry_bodies(fields, scene, old, before)
    for was, system in _systems(scene, before):
        for name in system.shapes():
            path = f"{scene.system(system)}.{name}"
            if path in fields:
                fields[path] = old.read(f"{before.system(was)}.{name}")
    written = {name: values for name, values in fields.items() if values.size}
    try:
        world.write(written)
    except SceneError as error:
        raise SceneError(f"replace.{engine.named(str(error), scene)}") from None


def pairs(
    before: Sequence[Item], after: Sequence[Item], old_path: Callable[[Item], str], path: Callable[[Item], str]
) -> list[tuple[Item, Item]]:
    """Items that are the same in two scenes: the same object, the same name, or, without names, the same place.

    Items without names are the same if both scenes have equally many of the same kinds in the same order.

    Raises:
        SceneError: it cannot be told which item without a name was which.
    """
    known = {id(item): item for item in before}
    named = {item.name: item for item in before if item.name is not None}
    found = {id(item): known.get(id(item)) or named.get(item.name or "") for item in after}
    taken = {id(item) for item in found.values()}
    old = [item for item in before if item.name is None and id(item) not in taken]
    new = [item for item in after if item.name is None and found[id(item)] is None]
    if old and new:
        if [type(item) for item in old] != [type(item) for item in new]:
            raise SceneError(
                f"replace.{path(new[0])}: has no name, and it cannot be told whether it was {old_path(old[0])}, "
                "because other items without names came or went; give both name=…, or use the same object"
            )
        found |= {id(item): was for item, was in zip(new, old, strict=True)}
    return [(was, item) for item in after if (was := found[id(item)]) is not None]


def _carry_bodies(fields: dict[str, FloatArray], scene: Scene, old: World, before: Scene) -> None:
    """Put the state of bodies that were there before into the fields of the new scene."""
    matched = pairs(before.bodies, scene.bodies, before.path, scene.path)
    if not before.bodies:
        return
    known = {info.name for info in engine.fields(old, before)}
    for name in fields.keys() & known & {"positions", "velocities", "densities"}:
        values = engine.read(old, before, name)
        for one, other in matched:
            mine, own = fields[name][scene.slice(other)], values[before.slice(one)]
            kept = ~_newly_held(one, other) if name == "velocities" else np.ones(len(other), dtype=bool)
            mine[kept] = own[kept]
    if "broken" in known:
        broken = engine.read(old, before, "broken")
        for one, other in matched:
            _carry_broken(fields, (scene, other), (before, one), broken)


def _carry_broken(
    fields: dict[str, FloatArray], new: tuple[Scene, Body], old: tuple[Scene, Body], broken: FloatArray
) -> None:
    """Put the broken springs of a body that was there before into the fields of the new scene."""
    (scene, other), (before, one) = new, old
    torn = broken[_springs(before, one)]
    if not torn.any():
        return
    path = f"replace.{scene.path(other)}"
    ends = [body.pairs for body in (one, other) if isinstance(body, SpringNetwork)]
    if len(ends) < 2 or not np.array_equal(ends[0], ends[1]):
        raise SceneError(f"{path}.pairs: must be those of this body before, because some springs are broken; {_RENAME}")
    if "broken" not in fields:
        raise SceneError(f"{path}.breaking_strain: must be given as before, because some springs are broken; {_RENAME}")
    fields["broken"][_springs(scene, other)] = torn


def _newly_held(one: Body, other: Body) -> np.ndarray:
    """Mask (N,) of the particles that are held at another velocity than before, or were free."""
    same = (one.velocities == other.velocities).all(axis=1) & one.fixed
    held: np.ndarray = other.fixed & ~same
    return held


def _springs(scene: Scene, body: Body) -> slice:
    """The slice of a body's springs in the fields of springs."""
    if not isinstance(body, SpringNetwork):
        return slice(0, 0)
    start = first_spring(scene, body)
    return slice(start, start + len(body.pairs))


def _systems(scene: Scene, before: Scene) -> list[tuple[System, System]]:
    """The systems that two scenes have, as they were before and as they are."""
    paths = [partial(_path, each) for each in (before, scene)]
    return pairs(before.systems, scene.systems, *paths)


def _path(scene: Scene, system: System) -> str:
    return str(scene.system(system))
