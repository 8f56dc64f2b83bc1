"""Scene items are records: what a class declares as fields is what files, hashes and the engine are told."""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass, replace

import numpy as np
import pytest

import physcore as pc
from physcore.boundaries import BOUNDARIES
from physcore.constraints import CONSTRAINTS
from physcore.film.looks import look_of
from physcore.film.looks.base import Look
from physcore.forces import FORCES
from physcore.numerics.choices import check
from physcore.scene.kernels import KERNELS
from physcore.scene.polytopes import SHAPES
from physcore.scene.records import Record, kind_of, parameters
from physcore.scene.solids import Capsule
from physcore.scene.system import System
from physcore.simulation import engine
from physcore.systems import SYSTEMS

DUST = pc.Particles([[0.0, 0.0], [1.0, 0.0]], radius=0.1, name="dust")
NET = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [[0, 1]], 2.0, faces=[[0, 1, 2]])
WATER = pc.Fluid(pc.block((2.0, 0.0), (2.4, 0.4), 0.1), 0.1)
SHEET = pc.cloth((3, 3), 1.0, 1.0, origin=(0.0, 0.0, 0.0))
BOXES = pc.RigidBodies(pc.Rectangle(0.2, 0.1), [[0.0, 0.0], [1.0, 0.0]], name="boxes")
WHEEL = pc.RigidBody(pc.Disc(0.1), (0.0, 1.0))
HINGE = pc.Hinge(WHEEL, (BOXES, 0), (0.0, 0.5))
CORNERS = np.vstack([np.zeros(3), np.eye(3)])
GRID = pc.Grid((4, 3), 0.1)
ARGUMENTS: dict[str, tuple[object, ...]] = {
    "Gravity": ((0.0, -1.0),),
    "CentralForce": ((0.0, 0.0), 1.0),
    "CustomForce": (lambda time, x, v: -x, lambda x: 0.5 * float((x * x).sum())),
    "Wave": (
        pc.Grid((4, 3), 0.1),
        1.0,
        np.zeros((4, 3)),
        0.0,
        1.0,
        0.0,
        "fixed",
        None,
        pc.Source((0.1, 0.1), 1.0, 2.0),
    ),
    "ReactionDiffusion": (
        pc.Grid((4, 3), 0.1),
        pc.GrayScott(0.035, np.full((4, 3), 0.0625)),
        {"u": 2e-5, "v": 1e-5},
        {"u": np.ones((4, 3)), "v": 0.1},
        {"x": "fixed"},
    ),
    "Schrodinger": (pc.Grid((4, 3), 0.1), np.full((4, 3), 1.0 + 0.5j), np.zeros((4, 3)), 1.0, 1.0, 0.5, {"x": "free"}),
    "Tracers": ([[0.0, 0.0], [1.0, 0.0]], pc.Flow(lambda time, x: -x)),
    "PointVortices": ([[0.0, 0.0], [1.0, 0.0]], [1.0, -2.0], 0.1),
    "Dihedral": (SHEET, 0.1, 0.01),
    "Wind": ((1.0, 2.0, 3.0), 1.2, 1.1, 0.02),
    "SelfContact": (SHEET, 0.1, 0.2, 0.5),
    "Wire": ([[-9.0, -9.0], [-8.0, -8.0], [-7.0, -9.0]],),
    "Hinge": (WHEEL, None, (0.0, 1.0)),
    "BallJoint": ((BOXES, 1), (NET, 2), (0.0, 1.0)),
    "Weld": (WHEEL, (BOXES, 0)),
    "Prismatic": (None, WHEEL, (0.0, 2.0)),
    "Rod": (WHEEL, (BOXES, 0)),
    "SpringJoint": (WHEEL, None, ((0.0, 1.0), (0.0, 2.0)), 3.0),
    "Motor": (HINGE, 3.0, 1.0),
    "Anchor": (NET, [2, 0], (BOXES, 1)),
    "Disc": (0.1,),
    "Rectangle": (0.2, 0.1),
    "Polygon": ([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],),
    "Ball": (0.1,),
    "Cuboid": (0.1, 0.2, 0.3),
    "Hull": (CORNERS,),
    "MeshShape": (CORNERS, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]),
    "Compound": ([(pc.Disc(0.1), (0.0, 0.0)), (pc.Rectangle(0.2, 0.1), (0.1, 0.0), 0.5)],),
    "SoftSpheres": (10.0,),
    "LennardJones": (1.0, 0.1),
    "Plane": ((0.0, -9.0), (0.0, 2.0)),
    "Box": ((-9.0, -9.0), (9.0, 9.0)),
    "Sphere": ((0.0, 0.0), 9.0),
    "Capsule": ((-9.0, -9.0), (9.0, -9.0), 0.5),
    "ConvexHull": ([[-9.0, -9.0], [9.0, -9.0], [0.0, -8.0]],),
    "HeightField": ([-9.0, -8.0, -9.0], 1.0, -5.0),
}
ITEMS = [
    DUST,
    NET,
    WATER,
    BOXES,
    pc.Periodic((-5.0, -5.0), (5.0, 5.0)),
    *(kind(*ARGUMENTS.get(kind_of(kind), ())) for kind in (*FORCES, *BOUNDARIES, *CONSTRAINTS, *SYSTEMS, *KERNELS)),
    *(kind(*ARGUMENTS[kind_of(kind)]) for kind in SHAPES if kind is not Capsule),
    Capsule(0.3, 0.1),
]


@dataclass(frozen=True)
class Pond(System):
    """A system that the engine has never heard of."""

    heights: tuple[float, float]

    @property
    def dimension(self) -> int:
        return 2

    @property
    def elements(self) -> dict[str, int]:
        return {"cells": 2}

    def shapes(self) -> dict[str, tuple[int, ...]]:
        return {"heights": (2,)}


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Gas(pc.Particles):
    """A body that the engine has never heard of."""

    temperature: float = 300.0


class Sand(pc.SpringNetwork):
    """A network with a method of the user's."""

    def weight(self) -> float:
        return 9.81 * float(self.mass.sum())


def told_of(value: object) -> object:
    """What the engine is told of items within an item."""
    if isinstance(value, tuple):
        return tuple(map(told_of, value))
    if isinstance(value, dict):
        return {
            "kind": "",
            "name": None,
            "on": None,
            "members": None,
            "values": {name: told_of(each) for name, each in value.items()},
        }
    return Record.of(value).described() if is_dataclass(value) else value


@pytest.mark.parametrize("item", ITEMS, ids=lambda item: type(item).__name__)
def test_a_record_has_every_field_and_files_hold_every_argument(item):
    record = Record.of(item)
    assert set(record.values) == {entry.name for entry in fields(item)}
    assert list(record.packed()["fields"]) == list(parameters(type(item)))
    told = record.described()["values"]
    assert set(told) == set(record.values) - {"name", "on"}
    for name, value in told.items():
        given = getattr(item, name)
        assert value is given or value == told_of(given), "values are passed on as they are, uncopied"


def test_a_subclass_without_fields_is_of_the_same_kind():
    net = pc.SpringNetwork([[0.0, 0.0], [2.0, 0.0]], [[0, 1]], 10.0, rest_length=1.0)
    sand = Sand([[0.0, 0.0], [2.0, 0.0]], [[0, 1]], 10.0, rest_length=1.0)
    assert pc.Scene(net).hash() == pc.Scene(sand).hash()
    runs = [pc.Simulation(pc.Scene(body), dt=1e-2) for body in (net, sand)]
    for run in runs:
        run.step(10)
    assert runs[0].state_hash() == runs[1].state_hash()
    assert "springs" in runs[1].plan.stages


def test_the_engine_refuses_what_it_does_not_know_with_its_path():
    gas = Gas([[0.0, 0.0]])
    with pytest.raises(pc.SceneError, match=r"^bodies\[1\]: expected a body: .*, got Gas"):
        pc.Simulation(pc.Scene(DUST, gas))
    scene = pc.Scene(DUST, Pond((1.0, 2.0)), Pond((1.0, 2.0), name="sea"))
    with pytest.raises(pc.SceneError, match=r"^systems\[0\]: expected a kind of system, got Pond"):
        pc.Simulation(scene)


def test_a_scene_takes_systems_beside_bodies():
    pond = Pond((1.0, 2.0), name="pond")
    scene = pc.Scene(pond, DUST)
    assert scene.systems == (pond,)
    assert "Pond" in repr(scene)
    assert engine.describe(scene, check({}, scene))["systems"] == [
        {"kind": "Pond", "name": "pond", "on": None, "members": None, "values": {"heights": (1.0, 2.0)}}
    ]
    assert pc.Scene(DUST).packed()["systems"] == []
    hashes = {pc.Scene(DUST).hash(), scene.hash(), pc.Scene(DUST, Pond((1.0, 3.0), name="pond")).hash()}
    assert len(hashes) == 3
    with pytest.raises(
        pc.SceneError, match=r"^systems\[0\].heights: Pond must have 2 components in this 2D scene, got 3"
    ):
        pc.Scene(DUST, Pond((1.0, 2.0, 3.0)))  # type: ignore[arg-type]
    with pytest.raises(pc.SceneError, match=r"^Pond.name: "):
        Pond((1.0, 2.0), name=3)  # type: ignore[arg-type]


def test_every_boundary_has_a_look():
    for kind in BOUNDARIES:
        assert type(look_of(kind(*ARGUMENTS.get(kind.__name__, ())).resolved(2))) is not Look, kind


def test_a_further_system_has_a_path_a_name_of_its_own_and_the_dimension_of_the_scene():
    pond, lake = Pond((1.0, 2.0)), Pond((3.0, 4.0), name="lake")
    scene = pc.Scene(DUST, pond, lake)
    assert [scene.system(key) for key in (pond, lake, "lake", DUST, 0, "dust")] == [
        "systems[0]",
        "lake",
        "lake",
        *[None] * 3,
    ]
    assert tuple(scene.fields) == ("positions", "velocities", "systems[0].heights", "lake.heights")
    with pytest.raises(pc.SceneError, match=r"systems\[1\]: the same item is in the scene twice"):
        pc.Scene(DUST, pond, pond)
    with pytest.raises(pc.SceneError, match=r"systems\[1\].name: 'lake' is already the name of another item"):
        pc.Scene(DUST, lake, Pond((0.0, 0.0), name="lake"))
    with pytest.raises(pc.SceneError, match=r"systems\[0\]: 2D, but the scene is 3D"):
        pc.Scene(pc.Particles([[0.0, 0.0, 0.0]]), Pond((0.0, 0.0)))


def test_a_recording_gives_the_part_of_a_further_system():
    lake = Pond((3.0, 4.0), name="lake")
    scene = pc.Scene(DUST, lake)
    whole = pc.Simulation(pc.Scene(DUST), dt=0.1).record(0.2, fps=10.0)
    heights = np.arange(6.0).reshape(3, 2)
    recording = replace(whole, scene=scene, channels={**whole.channels, "lake.heights": heights})
    for key in (lake, "lake"):
        np.testing.assert_array_equal(recording[key].heights, heights)
        assert list(recording[key].channels) == ["heights"]
    assert list(recording["dust"].channels) == ["positions", "velocities"]
    with pytest.raises(AttributeError, match="no field 'depth': there are heights"):
        _ = recording[lake].depth


def test_a_class_in_a_field_is_no_item():
    """Classes are functions to call; only instances of them are items with a record."""
    record = Record.of(pc.CustomForce(pc.Drag, potential=pc.Particles))
    assert record.values["function"] is pc.Drag
    assert record.values["potential"] is pc.Particles
