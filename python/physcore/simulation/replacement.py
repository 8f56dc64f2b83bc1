"""Replacement of a scene while it runs: the state is carried over by the names of items and fields."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from physcore._core import World
from physcore.checks import BoolArray, FloatArray
from physcore.errors import SceneError
from physcore.numerics.choices import BODIES, Numerics, Options, check
from physcore.scene.bodies import Body
from physcore.scene.fields import FIELDS
from physcore.scene.scene import Scene
from physcore.scene.system import System
from physcore.simulation import engine

Item = TypeVar("Item", Body, System)
Captured: TypeAlias = "dict[str, NDArray[np.generic]]"
"""Captured world: arrays by name."""
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
    for body, known in _bodies(scene, before):
        path = _path(scene, body)
        if (body.is_fluid, body.is_rigid) != (known.is_fluid, known.is_rigid):
            raise SceneError(f"{path}: is a {type(body).__name__}, and was a {type(known).__name__}; {_RENAME}")
        if len(body) != len(known):
            raise SceneError(f"{path}.positions: must be {len(known)} as before, got {len(body)}; {_RENAME}")
    for system, was in _systems(scene, before):
        path, shapes = _path(scene, system), was.shapes()
        if type(system) is not type(was):
            raise SceneError(f"{path}: is a {type(system).__name__}, and was a {type(was).__name__}; {_RENAME}")
        for name, shape in system.shapes().items():
            if name not in shapes:
                raise SceneError(f"{path}.{name}: was not there; {_RENAME}")
            if shape != shapes[name]:
                raise SceneError(f"{path}.{name}: must have the shape {shapes[name]} as before, got {shape}; {_RENAME}")


def numerics_for(scene: Scene, before: Scene, numerics: Numerics) -> Numerics:
    """The numerical choices for a changed scene: those before, and defaults for new items.

    Raises:
        SceneError: a choice is not possible for the new scene.
    """
    one, several = numerics.integrator, numerics.integrators
    integrators: dict[Any, Any] = {BODIES: several.get(BODIES, one)} if scene.bodies and before.bodies else {}
    integrators |= {system: several.get(str(before.system(was)), one) for system, was in _systems(scene, before)}
    fluids: dict[Any, Any] = {
        body: numerics.fluids[before.path(known)] for body, known in _bodies(scene, before) if known.is_fluid
    }
    options = Options(
        integrator=integrators or "auto",
        dt=numerics.dt,
        precision=numerics.precision,
        threads=numerics.threads,
        max_energy_growth=numerics.max_energy_growth,
        on_divergence=numerics.on_divergence,
        fluids=fluids or "auto",
        contacts=numerics.contacts if numerics.contacts is not None and scene.has_rigid_bodies else "auto",
    )
    return check(options, scene)


def carry(world: World, scene: Scene, old: World, before: Scene) -> None:
    """Carry clock and state over to the world of a changed scene, for which `require_alike` has to hold.

    Fields are written by name, and equal layers of absorbing edges are copied. All else is found anew from the state:
    lists of neighbors, warm starts of constraints, other layers, and what methods keep from earlier steps.

    Raises:
        SceneError: broken springs have no counterpart, or the state is not possible in the new scene.
    """
    clock, past = world.capture(), old.capture()
    for name in ("clock", "steps", "taken_back"):
        clock[name] = past[name]
    clock["adaptation"] = np.concatenate([past["adaptation"][:2], clock["adaptation"][2:]])
    for system, was in _systems(scene, before):
        if _has_same_layer(system, was):
            clock |= _arrays(clock, str(scene.system(system)), past, str(before.system(was)))
    world.restore(clock)
    fields = {info.name: engine.read(world, scene, info.name) for info in engine.fields(world, scene) if info.state}
    every: list[tuple[Body | System, Body | System]] = [*_bodies(scene, before), *_systems(scene, before)]
    for item, known in every:
        _carry_item(fields, (scene, item), (before, known), old)
    try:
        engine.write(world, scene, {name: values for name, values in fields.items() if values.size})
    except SceneError as error:
        raise SceneError(f"replace.{engine.named(str(error), scene).removeprefix('set.')}") from None


def _has_same_layer(system: System, known: System) -> bool:
    """Whether two systems on grids have absorbing edges with the same layer, in which what has left goes on."""
    names = ("grid", "edges", "absorbing")
    is_open = getattr(system, "is_open", False)
    return is_open and all(getattr(system, name, None) == getattr(known, name, None) for name in names)


def _arrays(new: Captured, path: str, old: Captured, known: str) -> Captured:
    """The arrays of a system in a captured world, from another one where it was called `known`; without budgets."""
    start, before = f"systems/{path}/", f"systems/{known}/"
    own = {name: f"{before}{name.removeprefix(start)}" for name in new if name.startswith(start)}
    alike = {name: was for name, was in own.items() if was in old and old[was].shape == new[name].shape}
    return {name: old[was] for name, was in alike.items() if not name.endswith("/tallies")}


def _carry_item(
    fields: dict[str, FloatArray], new: tuple[Scene, Body | System], old: tuple[Scene, Body | System], world: World
) -> None:
    """Put the state of an item that was there before into the fields of the new scene."""
    (scene, item), (before, known) = new, old
    parts, were = scene.parts(item), before.parts(known)
    torn = {name: world.read(name)[rows] for part, (name, rows) in were.items() if part == "broken"}
    for broken in torn.values():
        _require_springs(_path(scene, item), cast("Body", item), cast("Body", known), broken)
    for part in parts.keys() & were.keys():
        (name, rows), (old_name, old_rows) = parts[part], were[part]
        if name not in fields:
            continue
        values = engine.read(world, before, old_name)[old_rows]
        if part in ("velocities", "angular_velocities") and name in FIELDS:
            held = _newly_held(cast("Body", item), cast("Body", known))
            values[held] = fields[name][rows][held]
        if part != "broken" or values.any():
            fields[name][rows] = values


def _require_springs(path: str, body: Body, known: Body, broken: FloatArray) -> None:
    """Refuse other springs, or springs that cannot break, where some are broken.

    Raises:
        SceneError: the springs of the body differ from those before.
    """
    if not broken.any():
        return
    network, was = body.network, known.network
    if network is None or was is None or not np.array_equal(network.pairs, was.pairs):
        raise SceneError(f"{path}.pairs: must be those of before, because some springs are broken; {_RENAME}")
    if "broken" not in network.quantities:
        raise SceneError(f"{path}.breaking_strain: must be given as before, because springs are broken; {_RENAME}")


def _newly_held(body: Body, known: Body) -> BoolArray:
    """Mask (N,) of the particles or rigid bodies that are held, and were not held at the same velocities."""
    kept = known.fixed & (known.motion == body.motion).all(axis=1)
    held: BoolArray = body.fixed & ~kept
    return held


def _bodies(scene: Scene, before: Scene) -> Iterator[tuple[Body, Body]]:
    """The bodies that both scenes have: as they are, and as they were."""
    return _pairs((scene, scene.bodies), (before, before.bodies))


def _systems(scene: Scene, before: Scene) -> Iterator[tuple[System, System]]:
    """The systems that both scenes have: as they are, and as they were."""
    return _pairs((scene, scene.systems), (before, before.systems))


def _pairs(new: tuple[Scene, Sequence[Item]], old: tuple[Scene, Sequence[Item]]) -> Iterator[tuple[Item, Item]]:
    """Items that are the same in two scenes: the same object, the same name, or, without names, the same place.

    Items without names are the same if both scenes have equally many of the same kinds in the same order.

    Raises:
        SceneError: it cannot be told which item without a name was which.
    """
    (scene, items), (before, known) = new, old
    objects = {id(item): item for item in known}
    named = {item.name: item for item in known if item.name is not None}
    found = {id(item): objects.get(id(item)) or named.get(item.name or "") for item in items}
    taken = {id(item) for item in found.values()}
    left = [item for item in known if item.name is None and id(item) not in taken]
    nameless = [item for item in items if item.name is None and found[id(item)] is None]
    if left and nameless:
        if [type(item) for item in left] != [type(item) for item in nameless]:
            candidate = _path(before, left[0]).removeprefix("replace.")
            raise SceneError(
                f"{_path(scene, nameless[0])}: has no name, and it cannot be told whether it was {candidate}, "
                "because other items without names came or went; give both name=…, or use the same object"
            )
        found |= {id(item): was for item, was in zip(nameless, left, strict=True)}
    for item in items:
        was = found[id(item)]
        if was is not None:
            yield item, was


def _path(scene: Scene, item: Body | System) -> str:
    """The path of an item in messages."""
    return f"replace.{scene.system(item) or scene.path(cast('Body', item))}"
