"""Replacement of a scene while it runs: the state is carried over by the names of items."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from physcore._core import World
from physcore.checks import FloatArray
from physcore.errors import SceneError
from physcore.numerics.choices import BODIES, Integrators, Numerics, Options, check
from physcore.numerics.fluids import FluidMethod
from physcore.scene.bodies import Body
from physcore.scene.contents import BodyKey
from physcore.scene.items import System
from physcore.scene.scene import Scene
from physcore.simulation import engine

Item = TypeVar("Item", Body, System)
_RENAME = "with another name it begins as the scene says"
ROUNDING = 1e-6
"""Largest change of a position by rounding to single precision, over the extent."""


def numerics_for(scene: Scene, before: Scene, numerics: Numerics) -> Numerics:
    """The numerical choices for a changed scene: those before, where they are possible, and defaults for new items.

    Raises:
        SceneError: a choice is not possible for the new scene.
    """
    integrators: dict[Any, Any] = {}
    if scene.bodies and before.bodies:
        integrators[BODIES] = numerics.integrators.get(BODIES, numerics.integrator)
    for one, other in pairs(before.systems, scene.systems, _path_of(before), _path_of(scene)):
        path = str(before.system(one))
        integrators[other] = numerics.integrators.get(path, numerics.integrator)
    fluids = pairs(before.bodies, scene.bodies, before.path, scene.path)
    methods: dict[BodyKey, FluidMethod | str] = {
        other: numerics.fluids[before.path(one)] for one, other in fluids if one.is_fluid and other.is_fluid
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
    _require_same_space(scene, before)
    clock, past = world.capture(), old.capture()
    for name in ("clock", "steps", "taken_back"):
        clock[name] = past[name]
    clock["adaptation"] = np.concatenate([past["adaptation"][:2], clock["adaptation"][2:]])
    world.restore(clock)
    fields = {info.name: engine.read(world, scene, info.name) for info in engine.fields(world, scene) if info.state}
    if scene.bodies:
        _carry_bodies(fields, scene, old, before)
    for one, other in pairs(before.systems, scene.systems, _path_of(before), _path_of(scene)):
        _carry_system(fields, (str(scene.system(other)), other), (str(before.system(one)), one), old)
    written = {name: values for name, values in fields.items() if values.size}
    world.write(written)
    _require_written(world, scene, written)


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
    for one, other in matched:
        if one.is_fluid != other.is_fluid:
            kinds = [type(body).__name__ for body in (other, one)]
            raise SceneError(f"replace.{scene.path(other)}: is a {kinds[0]}, and was a {kinds[1]}; {_RENAME}")
        if len(one) != len(other):
            raise SceneError(
                f"replace.{scene.path(other)}.positions: must be of the {len(one)} particles of this body before, got "
                f"{len(other)}; {_RENAME}"
            )
    known = {info.name for info in engine.fields(old, before)} if before.bodies else set()
    for name in ("positions", "velocities"):
        if name not in known:
            continue
        values = engine.read(old, before, name)
        for one, other in matched:
            mine, own = fields[name][scene.slice(other)], values[before.slice(one)]
            kept = np.ones(len(other), dtype=bool) if name == "positions" else ~_newly_held(one, other)
            mine[kept] = own[kept]


def _newly_held(one: Body, other: Body) -> np.ndarray:
    """Mask (N,) of the particles that are held at another velocity than before, or were free."""
    same = (one.velocities == other.velocities).all(axis=1) & one.fixed
    held: np.ndarray = other.fixed & ~same
    return held


def _carry_system(
    fields: dict[str, FloatArray], new: tuple[str, System], old: tuple[str, System], world: World
) -> None:
    """Put the state of a system that was there before into the fields of the new scene."""
    (path, system), (old_path, was) = new, old
    if type(system) is not type(was):
        raise SceneError(f"replace.{path}: is a {type(system).__name__}, and was a {type(was).__name__}; {_RENAME}")
    known = was.shapes()
    for name in system.shapes():
        if f"{path}.{name}" not in fields:
            continue
        if name not in known:
            raise SceneError(f"replace.{path}.{name}: was not there before; {_RENAME}")
        values = world.read(f"{old_path}.{name}")
        expected = fields[f"{path}.{name}"].shape
        if values.shape != expected:
            raise SceneError(
                f"replace.{path}.{name}: must have the shape {values.shape} of this field before, "
                f"got {expected}; {_RENAME}"
            )
        fields[f"{path}.{name}"] = values


def _require_same_space(scene: Scene, before: Scene) -> None:
    """Refuse another dimension, and other units."""
    if scene.dimension != before.dimension:
        raise SceneError(
            f"replace.scene: must be in {before.dimension}D as before, got {scene.dimension}D; start a new Simulation"
        )
    if scene.units != before.units:
        raise SceneError("replace.scene: must have the units of the scene before; build it with the same units=")


def _require_written(world: World, scene: Scene, fields: Mapping[str, FloatArray]) -> None:
    """Refuse positions that a boundary of the new scene has moved."""
    if "positions" not in fields:
        return
    given, found = fields["positions"], engine.read(world, scene, "positions")
    scale = float(np.abs(given).max(initial=0.0)) + float(np.ptp(given))
    moved = np.abs(found - given).max(axis=1) > ROUNDING * scale
    for index in np.flatnonzero(moved)[:1]:
        body = next(body for body in scene.bodies if index < scene.slice(body).stop)
        raise SceneError(
            f"replace.{scene.path(body)}: particle {index - scene.slice(body).start} is now at "
            f"{given[index].round(6).tolist()}, beyond a boundary of the new scene; move the boundary, or the particle "
            "with set(positions=…) before"
        )


def _path_of(scene: Scene) -> Callable[[System], str]:
    """The path of a system in messages."""
    return lambda system: str(scene.system(system))
