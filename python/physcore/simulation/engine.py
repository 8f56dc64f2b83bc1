"""The way to the engine: a scene and its numerics in, a World out. No other file builds one."""

from __future__ import annotations

from physcore._core import World
from physcore.checks import FloatArray
from physcore.numerics.choices import Limit, Numerics
from physcore.scene.items import ActingItem, SceneItem
from physcore.scene.records import Record
from physcore.scene.scene import Scene
from physcore.simulation.plan import Plan
from physcore.simulation.state import FieldInfo, Snapshot


def build(scene: Scene, numerics: Numerics) -> World:
    """Hand a scene to the engine.

    Raises:
        SceneError: the engine cannot do what was asked, or a particle starts outside of a boundary.
    """
    return World(
        describe(scene),
        type(numerics.integrator).__name__,
        numerics.precision,
        numerics.threads,
        numerics.max_energy_growth,
        numerics.on_divergence,
    )


def describe(scene: Scene) -> dict[str, object]:
    """A scene as plain dictionaries, numbers and arrays: the records of its items."""
    return {
        "dimension": scene.dimension,
        "bodies": [Record.of(body).described() for body in scene.bodies],
        "forces": [_item(force, scene) for force in scene.forces],
        "boundaries": [_item(boundary, scene) for boundary in scene.boundaries],
        "systems": [_item(system, scene) for system in scene.systems],
        "periodic": None if scene.periodic is None else Record.of(scene.periodic).described(),
    }


def fields(world: World) -> list[FieldInfo]:
    """The fields of a world."""
    return [FieldInfo(name, unit, tuple(shape), rate, state) for name, unit, shape, rate, state in world.fields()]


def snapshot(world: World) -> Snapshot:
    """The present state. Positions are where particles have gone: `show` puts them into the domain."""
    return Snapshot(world.time, {info.name: world.read(info.name) for info in fields(world)})


def show(positions: FloatArray, scene: Scene) -> FloatArray:
    """Positions as the user sees them: within the periodic domain, if there is one."""
    return positions if scene.periodic is None else scene.periodic.wrap(positions)


def limit(world: World) -> Limit:
    """The limit of the time step in the world's present state."""
    return Limit(**world.limit())


def certified(world: World) -> float:
    """The limit of stability [s] that holds wherever springs turn, while none is shorter than half its rest length."""
    return world.certified()


def present_limit(world: World) -> Limit:
    """The limit of one step from the world's present state [s], whatever is ahead; a certified one."""
    return Limit(**world.present_limit())


def plan(world: World, bound: Limit, dt: float) -> Plan:
    """The plan of a world, with the time step and its limit."""
    facts = world.plan()
    return Plan(
        stages=tuple(facts["stages"]),
        dimension=facts["dimension"],
        precision=facts["precision"],
        integrator=facts["integrator"],
        order=facts["order"],
        evaluations=facts["evaluations"],
        pairs=facts["pairs"],
        dt=dt,
        dt_limit=bound.dt,
        limit_kind=bound.kind,
        limit_term=bound.term,
        memory=facts["memory"],
        threads=facts["threads"],
        simd=facts["simd"],
        layout=facts["layout"],
        left_out=tuple(facts["left_out"]),
        notes=tuple(facts["notes"]),
    )


def _item(item: SceneItem, scene: Scene) -> dict[str, object]:
    """An item as it is in the scene, with the indices of the bodies that it acts on, if not on all."""
    targets = scene.targets(item) if isinstance(item, ActingItem) else scene.bodies
    on = None if targets == scene.bodies else [scene.index(body) for body in targets]
    return Record.of(item.resolved(scene.dimension)).described(on)
