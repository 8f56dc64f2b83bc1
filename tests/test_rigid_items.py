"""Rigid bodies, their shapes and joints as items of scenes: what is taken, refused, and handed to the engine."""

from __future__ import annotations

import copy
import math
import pickle
from itertools import product

import numpy as np
import pytest

import physcore as pc
from physcore.boundaries import BOUNDARIES
from physcore.numerics.choices import check
from physcore.scene.polytopes import SHAPES
from physcore.scene.records import Record
from physcore.scene.rotations import quaternion_rates
from physcore.simulation import engine
from physcore.simulation.changes import Changes
from physcore.simulation.periods import marked, period_of
from physcore.simulation.serial import unpack_scene
from physcore.simulation.state import Snapshot
from physcore.simulation.within import between

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
CORNERS = np.array(list(product((-0.2, 0.2), (-0.1, 0.1), (-0.05, 0.05))))
"""Corners of a cuboid of 0.4, 0.2 and 0.1."""
SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
FACES = [[side[0], side[i], side[i + 1]] for side in SIDES for i in (1, 2)]
"""Triangles of its surface, counterclockwise as seen from outside."""
STAR = [(math.cos(0.8 * math.pi * k), math.sin(0.8 * math.pi * k)) for k in range(5)]
"""Pentagram, which bends in one direction and crosses itself."""

BOXES = pc.RigidBodies(pc.Rectangle(0.2, 0.1), [[0.0, 1.0], [1.0, 1.0], [2.0, 1.0]], angles=[0, 1, 2], name="boxes")
WHEEL = pc.RigidBody(pc.Disc(0.1), (0.0, 3.0), mass=2.0, name="wheel")
DUST = pc.Particles([[0.0, 0.0], [1.0, 0.0]], name="dust")
BALLS = pc.RigidBodies(pc.Ball(0.1), np.eye(3))
BALL = pc.RigidBody(pc.Ball(0.1), (0.0, 0.0, 0.0))
GRAIN = pc.Particles([[0.0, 0.0, 0.0]])
UP = (0.0, 0.0, 1.0)
Z3 = (0.0, 0.0, 0.0)


def described(*items, units=None):
    """What the engine is told of the constraints of a scene."""
    scene = pc.Scene(*items, units=units)
    return [(each["kind"], each["values"]) for each in engine.describe(scene, check({}, scene))["constraints"]]


def test_shapes_have_the_quantities_of_textbooks():
    assert pc.Disc(0.1).area == pytest.approx(math.pi * 0.01, rel=1e-15)
    assert pc.Disc(0.1).moment == pytest.approx(0.5 * math.pi * 1e-4, rel=1e-15)
    assert pc.Rectangle(0.4, 0.2).area == pytest.approx(0.08, rel=1e-15)
    assert pc.Rectangle(0.4, 0.2).moment == pytest.approx(0.08 * (0.16 + 0.04) / 12, rel=1e-15)
    assert pc.Ball(0.1).volume == pytest.approx(4e-3 * math.pi / 3, rel=1e-15)
    np.testing.assert_allclose(pc.Ball(0.1).moment, 0.4 * 0.01 * pc.Ball(0.1).volume * np.eye(3), rtol=1e-15)
    np.testing.assert_allclose(np.diag(pc.Cuboid(0.4, 0.2, 0.1).moment), 0.008 / 12 * np.array([0.05, 0.17, 0.2]))
    pill = pc.Capsule(0.3, 0.1)
    assert pill.area == pytest.approx(0.06 + math.pi * 0.01, rel=1e-15)
    assert pill.volume == pytest.approx(math.pi * 0.003 + 4e-3 * math.pi / 3, rel=1e-15)


def test_a_polygon_has_the_quantities_of_the_rectangle_that_it_is():
    """In either direction, anywhere. Coordinates of 5 lose log₂(5²/0.2²) = 10 bits of the moment: 1e-12 is above."""
    whole = pc.Rectangle(0.4, 0.2)
    corners = np.array([(-0.2, -0.1), (0.2, -0.1), (0.2, 0.1), (-0.2, 0.1)])
    for direction in (1, -1):
        polygon = pc.Polygon(corners[::direction] + np.array([3.0, -5.0]))
        assert polygon.area == pytest.approx(whole.area, rel=1e-12)
        assert polygon.moment == pytest.approx(whole.moment, rel=1e-12)
        np.testing.assert_allclose(polygon.center, (3.0, -5.0), rtol=1e-14)


@pytest.mark.parametrize("faces", [FACES, [face[::-1] for face in FACES]], ids=["outward", "inward"])
def test_a_mesh_and_a_hull_have_the_quantities_of_the_cuboid_that_they_are(faces):
    """Up to the rounding of moments about the origin: ten times ε · 0.11 m⁵, or 1e-11 of the least moment."""
    whole, shift = pc.Cuboid(0.4, 0.2, 0.1), np.array([1.0, 2.0, 3.0])
    for shape in (pc.MeshShape(CORNERS + shift, faces), pc.Hull(CORNERS + shift)):
        assert shape.volume == pytest.approx(whole.volume, rel=1e-12)
        np.testing.assert_allclose(shape.center, shift, rtol=1e-13)
        np.testing.assert_allclose(shape.moment, whole.moment, rtol=1e-10, atol=1e-15)


@pytest.mark.parametrize("angle", [0.0, 0.5 * math.pi])
def test_a_compound_of_halves_is_the_whole(angle):
    """Also of a half that is turned upright."""
    half, first = pc.Rectangle(0.2, 0.1), pc.Rectangle(0.2, 0.1) if angle == 0.0 else pc.Rectangle(0.1, 0.2)
    joined = pc.Compound([(first, (1.1, 0.0), angle), (half, (1.3, 0.0))])
    whole = pc.Rectangle(0.4, 0.1)
    assert joined.area == pytest.approx(whole.area, rel=1e-13)
    assert joined.moment == pytest.approx(whole.moment, rel=1e-12)
    np.testing.assert_allclose(joined.center, (1.2, 0.0), atol=1e-14)
    solid = pc.Compound([(pc.Cuboid(0.2, 0.1, 0.2), (0.0, 0.1 * k, 1.0), (1.0, 0.0, 0.0, 1.0)) for k in (-1.0, 1.0)])
    np.testing.assert_allclose(solid.moment, pc.Cuboid(0.1, 0.4, 0.2).moment, rtol=1e-12, atol=1e-17)
    np.testing.assert_allclose(solid.center, (0.0, 0.0, 1.0), atol=1e-14)


def test_a_compound_takes_parts_or_arrays():
    disc, plank = pc.Disc(0.1), pc.Rectangle(1.0, 0.1)
    given = pc.Compound([(disc, (0.0, 0.0)), (plank, (0.5, 0.0), 0.2)])
    assert given == pc.Compound([disc, plank], [(0.0, 0.0), (0.5, 0.0)], [0.0, 0.2])
    assert given != pc.Compound([disc, plank], [(0.0, 0.0), (0.5, 0.0)], [0.0, 0.3])
    assert given.dimensions == (2,)
    turned = pc.Compound([(pc.Ball(0.1), Z3), (pc.Ball(0.2), UP, (0.0, 3.0, 0.0, 0.0))])
    assert turned.orientations.tolist() == [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]
    assert turned.angles is None


VALUES = [
    pc.Disc(0.1),
    pc.Rectangle(0.2, 0.1),
    pc.Polygon(SQUARE),
    pc.Capsule(0.2, 0.1),
    pc.Ball(0.1),
    pc.Cuboid(0.1, 0.2, 0.3),
    pc.Hull(CORNERS),
    pc.MeshShape(CORNERS, FACES),
    pc.Compound([(pc.Disc(0.1), (0.0, 0.0))]),
]


def test_every_shape_is_tested():
    assert {type(shape) for shape in VALUES} == set(SHAPES)


@pytest.mark.parametrize("shape", VALUES, ids=lambda shape: type(shape).__name__)
def test_shapes_are_values(shape):
    shape.properties(shape.dimensions[0])
    for twin in (pickle.loads(pickle.dumps(shape)), copy.deepcopy(shape)):
        assert twin == shape
        assert hash(twin) == hash(shape)
        assert twin.properties(shape.dimensions[0]).size == shape.properties(shape.dimensions[0]).size
    for value in vars(shape).values():
        assert not isinstance(value, np.ndarray) or not value.flags.writeable
    assert [shape == other for other in VALUES].count(True) == 1
    body = pc.RigidBody(shape, (0.0,) * shape.dimensions[0])
    loaded = unpack_scene(pc.Scene(body).packed()).bodies[0]
    assert loaded.shape == shape


def test_a_capsule_of_two_lengths_is_a_shape_and_between_two_points_an_obstacle():
    assert pc.Capsule(0.2, 0.1) == pc.Capsule(length=0.2, radius=0.1) == pc.Capsule(0.2, radius=0.1)
    obstacle = pc.Capsule((0.0, 0.0), (1.0, 0.0), 0.1)
    assert isinstance(obstacle, pc.Boundary)
    assert pc.Capsule in BOUNDARIES
    assert pickle.loads(pickle.dumps(obstacle)) == obstacle
    scene = pc.Scene(pc.RigidBody(pc.Capsule(0.2, 0.1), (0.0, 0.0)), obstacle)
    assert unpack_scene(scene.packed()).hash() == scene.hash()
    with pytest.raises(pc.SceneError, match=r"Capsule.center: depends on the dimension; take properties\(2\)"):
        _ = pc.Capsule(0.2, 0.1).center
    with pytest.raises(TypeError, match="missing"):
        pc.Capsule((0.0, 0.0), (1.0, 0.0))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.Disc(0.0), "Disc.radius: must be > 0"),
        (lambda: pc.Rectangle(1.0, -1.0), "Rectangle.height: must be > 0"),
        (lambda: pc.Cuboid(1.0, 1.0, math.nan), "Cuboid.c: must be finite"),
        (lambda: pc.Capsule(-1.0, 0.1), "Capsule.length: must be > 0"),
        (
            lambda: pc.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]),
            r"vertices: must not cross itself, but the edges 0 \(from vertex 0 to 1\) and 2 \(from vertex 2 to 3\)",
        ),
        (lambda: pc.Polygon(STAR), "Polygon.vertices: must not cross itself, but the edges 0 .* and 2 "),
        (lambda: pc.Polygon([(0, 0), (1, 0), (2, 0)]), "Polygon.vertices: must have an area"),
        (lambda: pc.Polygon([(0, 0), (1, 0), (1, 0), (0, 1)]), r"Polygon.vertices\[1\]: must differ from the next"),
        (lambda: pc.Polygon([*SQUARE, SQUARE[0]]), r"Polygon.vertices\[4\]: must differ from the next vertex"),
        (
            lambda: pc.Polygon([(0, 0), (2, 0), (2, 2), (2, 1), (0, 1)]),
            r"vertices\[2\]: must not be the end of a spike",
        ),
        (
            lambda: pc.Polygon(SQUARE[:2]),
            r"Polygon.vertices: must have the shape \(K, 2\) with at least 3 points, got \(2, 2\)",
        ),
        (lambda: pc.Hull(CORNERS * (1.0, 1.0, 0.0)), "Hull.points: must span a volume"),
        (lambda: pc.MeshShape(CORNERS, FACES[1:]), "MeshShape.faces: must be a closed surface, but one face alone"),
        (lambda: pc.MeshShape(CORNERS, [FACES[0][::-1], *FACES[1:]]), "faces: must have one direction as seen"),
        (lambda: pc.MeshShape(CORNERS * (1.0, 1.0, 0.0), FACES), "MeshShape.vertices: must enclose a volume"),
        (lambda: pc.MeshShape(CORNERS, [[0, 1, 8], *FACES]), r"MeshShape.faces\[0, 2\]: index 8 is outside of the 8"),
        (
            lambda: pc.MeshShape(CORNERS, [[0, 1, 1], *FACES]),
            r"MeshShape.faces\[0\]: must have three different corners",
        ),
        (lambda: pc.Compound([]), "Compound.positions: must have the shape"),
        (lambda: pc.Compound([pc.Disc(1.0)]), r"Compound.shapes\[0\]: must be \(shape, position\)"),
        (lambda: pc.Compound([(pc.Ball(1.0), (0, 0))]), r"Compound.shapes\[0\]: must be a shape in 2D"),
        (lambda: pc.Compound([(VALUES[-1], (0, 0))]), r"Compound.shapes\[0\]: must be a convex shape"),
        (lambda: pc.Compound([(pc.Ball(1.0), Z3, Z3)]), r"Compound.shapes\[0\]\[2\]: must be an orientation"),
        (lambda: pc.Compound([(pc.Ball(1.0), Z3, (0, 0, 0, 0))]), r"Compound.orientations\[0\]: must not be zero"),
        (lambda: pc.Compound([pc.Ball(1.0)], [Z3], 1.0), "Compound.angles: must be None in 3D"),
        (lambda: pc.Ball(0.1).area, "Ball: is a shape in 3D, and has no properties in 2D"),
    ],
)
def test_what_is_no_shape_is_refused(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()


def test_bodies_broadcast_and_their_mass_follows_from_the_density():
    assert BOXES.mass.tolist() == pytest.approx([20.0] * 3)
    assert BOXES.density.tolist() == pytest.approx([1000.0] * 3)
    assert WHEEL.mass.tolist() == [2.0]
    assert BOXES.angles.tolist() == [0.0, 1.0, 2.0]
    assert BOXES.orientations is None
    assert (len(BOXES), BOXES.dimension, BOXES.radius.tolist()) == (3, 2, [0.0] * 3)
    thrown = pc.RigidBodies(pc.Ball(0.1), np.eye(3), velocities=UP, angular_velocities=UP, density=[1, 2, 3], fixed=[1])
    assert thrown.velocities.tolist() == thrown.angular_velocities.tolist() == [list(UP)] * 3
    assert (thrown.mass / thrown.mass[0]).tolist() == pytest.approx([1.0, 2.0, 3.0])
    assert thrown.fixed.tolist() == [False, True, False]
    assert thrown.angles is None
    assert not thrown.orientations.flags.writeable
    assert pc.RigidBodies(pc.Ball(0.1), np.eye(3)) != pc.RigidBodies(pc.Ball(0.1), np.eye(3))


def test_quaternions_are_normalized_and_unit_ones_keep_their_bits():
    rng = np.random.default_rng(1)
    given = rng.normal(size=(200, 4)) * 10.0 ** rng.uniform(-200, 150, (200, 1))
    bodies = pc.RigidBodies(pc.Ball(0.1), rng.normal(size=(200, 3)), orientations=given)
    np.testing.assert_allclose(np.linalg.norm(bodies.orientations, axis=1), 1.0, rtol=1e-15)
    np.testing.assert_allclose(
        bodies.orientations * np.abs(given).max(axis=1, keepdims=True),
        given * np.abs(bodies.orientations).max(axis=1, keepdims=True),
        rtol=1e-14,
    )
    again = pc.RigidBodies(pc.Ball(0.1), bodies.positions, orientations=bodies.orientations)
    assert again.orientations.tobytes() == bodies.orientations.tobytes()


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (
            lambda: pc.RigidBodies(pc.Disc(1.0), np.eye(3)),
            "RigidBodies.shape: must be a shape in 3D like the positions",
        ),
        (lambda: pc.RigidBodies(pc.Disc, [[0, 0]]), r"RigidBodies.shape: .*; write Disc\(…\)"),
        (lambda: pc.RigidBodies(0.1, [[0, 0]]), "RigidBodies.shape: must be a shape, such as Disc or Ball, got 0.1"),
        (lambda: pc.RigidBodies(pc.Disc(1.0), [0, 0]), r"RigidBodies.positions: must have the shape \(N, 2\)"),
        (lambda: pc.RigidBodies(pc.Disc(1.0), [[0, 0]], density=0.0), r"RigidBodies.density\[0\]: must be > 0"),
        (lambda: pc.RigidBodies(pc.Disc(1.0), [[0, 0]], mass=-1.0), r"RigidBodies.mass\[0\]: must be > 0"),
        (lambda: pc.RigidBodies(pc.Disc(1.0), [[0, 0]], friction=-1.0), r"RigidBodies.friction\[0\]: must be ≥ 0"),
        (lambda: pc.RigidBodies(pc.Disc(1.0), [[0, 0]], restitution=2.0), r"RigidBodies.restitution\[0\]: must be ≤ 1"),
        (
            lambda: pc.RigidBodies(pc.Disc(1.0), [[0, 0]], orientations=(1, 0, 0, 0)),
            "RigidBodies.orientations: .* in 2D",
        ),
        (lambda: pc.RigidBodies(pc.Disc(1.0), [[0, 0]], torsional_friction=1.0), "torsional_friction: must be 0 in 2D"),
        (lambda: pc.RigidBodies(pc.Ball(1.0), [Z3], angles=1.0), "RigidBodies.angles: must be 0 in 3D"),
        (
            lambda: pc.RigidBodies(pc.Ball(1.0), [Z3], angular_velocities=1.0),
            "angular_velocities: must be vectors in 3D",
        ),
        (lambda: pc.RigidBodies(pc.Ball(1.0), [Z3], orientations=[[0] * 4]), r"orientations\[0\]: must not be zero"),
        (
            lambda: pc.RigidBodies(pc.Ball(1.0), [Z3], orientations=(1, 0, 0)),
            "RigidBodies.orientations: must broadcast",
        ),
        (lambda: pc.RigidBody(pc.Ball(1.0), Z3, angle=1.0), "RigidBody.angle: must be 0 in 3D"),
        (lambda: pc.RigidBody(pc.Ball(1.0), Z3, orientation=(0, 0, 0, 0)), "RigidBody.orientation: must not be zero"),
        (lambda: pc.RigidBody(pc.Ball(1.0), [Z3]), "RigidBody.position: must be 2 or 3 numbers"),
        (lambda: pc.RigidBody(pc.Ball(1.0), Z3, mass=0.0), "RigidBody.mass: must be > 0"),
        (
            lambda: pc.RigidBody(pc.Ball(1.0), Z3, angular_velocity=(1, 2)),
            "RigidBody.angular_velocity: must be a vector",
        ),
        (
            lambda: pc.RigidBody(pc.Disc(1.0), (0, 0), angular_velocity=UP),
            "RigidBody.angular_velocity: must be a number",
        ),
        (lambda: pc.RigidBody(pc.Disc(1.0), (0, 0), velocity=UP), "RigidBody.velocity: must broadcast"),
    ],
)
def test_what_is_no_rigid_body_is_refused(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()


def test_one_body_is_several_of_one():
    one = pc.RigidBody(pc.Disc(0.1), (1.0, 2.0), 0.5, None, (3.0, 4.0), 5.0, friction=0.1, fixed=True, name="disc")
    several = pc.RigidBodies(
        pc.Disc(0.1), [(1.0, 2.0)], 0.5, None, (3.0, 4.0), 5.0, friction=0.1, fixed=True, name="disc"
    )
    assert pc.Scene(one).hash() == pc.Scene(several).hash()
    assert Record.of(one).kind == "RigidBodies"
    assert unpack_scene(pc.Scene(one).packed()).hash() == pc.Scene(one).hash()


def test_rigid_bodies_are_no_particles():
    scene = pc.Scene(BOXES, DUST, WHEEL)
    assert scene.particles == 2
    assert scene.count("rigid bodies") == 4
    assert [scene.slice(body) for body in scene.bodies] == [slice(0, 0), slice(0, 2), slice(2, 2)]
    assert {name: field.shape for name, field in scene.fields.items()} == {
        "positions": (2, 2),
        "velocities": (2, 2),
        "rigid_positions": (4, 2),
        "rigid_velocities": (4, 2),
        "angles": (4,),
        "angular_velocities": (4,),
    }
    assert scene.parts(WHEEL) == {
        "positions": ("rigid_positions", slice(3, 4)),
        "velocities": ("rigid_velocities", slice(3, 4)),
        "angles": ("angles", slice(3, 4)),
        "angular_velocities": ("angular_velocities", slice(3, 4)),
    }
    assert scene.parts("dust") == {"positions": ("positions", slice(0, 2)), "velocities": ("velocities", slice(0, 2))}
    space = pc.Scene(BALLS).fields
    assert [space[name].shape for name in ("positions", "orientations", "angular_velocities")] == [
        (0, 3),
        (3, 4),
        (3, 3),
    ]
    assert "angles" not in space


def test_forces_act_on_rigid_bodies_unless_they_act_between_particles():
    some = pc.Gravity((1.0, 0.0), on=(BOXES, [1]))
    grains = pc.Particles([[5.0, 5.0]], radius=0.1)
    scene = pc.Scene(BOXES, grains, pc.Gravity(), some, pc.Drag(0.1), pc.SoftSpheres(1.0), pc.Floor(-1.0))
    assert [scene.targets(force) for force in scene.forces] == [
        (BOXES, grains),
        (BOXES,),
        (BOXES, grains),
        (grains,),
    ]
    assert scene.targets(scene.boundaries[0]) == (BOXES, grains)
    assert [scene.members(force).tolist() for force in scene.forces] == [[True], [False], [True], [True]]
    told = engine.describe(scene, check({}, scene))["forces"]
    assert [force["on"] for force in told] == [None, [0], None, [1]]
    assert told[1]["members"].tolist() == [False, True, False, False]


@pytest.mark.parametrize(
    ("items", "message"),
    [
        ((BOXES, pc.SoftSpheres(1.0)), r"forces\[0\].on: SoftSpheres acts on particles, not on rigid bodies"),
        (
            (BOXES, DUST, pc.LennardJones(1.0, 1.0, on=BOXES)),
            r"forces\[0\].on: LennardJones acts on particles, not on Ri",
        ),
        (
            (BOXES, DUST, pc.Wire([[0, 0], [1, 0]], on=[BOXES])),
            r"constraints\[0\].on: Wire acts on particles, not on Ri",
        ),
        ((BOXES, pc.Gravity(on=WHEEL)), r"forces\[0\].on: RigidBody.* is not in the scene"),
        ((BOXES, BALLS), r"bodies\[1\].positions: 3D, but the first body is 2D"),
    ],
)
def test_scenes_refuse_what_does_not_act_on_rigid_bodies(items, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.Scene(*items)


def test_the_default_density_is_that_of_the_si():
    atomic = pc.units.system(length="nm", time="ps", mass="u")
    with pytest.raises(
        pc.SceneError, match=r"bodies\['boxes'\].density: must be given in the units .* density=602\.214"
    ):
        pc.Scene(BOXES, units=atomic)
    with pytest.raises(pc.SceneError, match=r"bodies\[0\].density: must be given, because this scene is without units"):
        pc.Scene(BALLS, units=pc.units.dimensionless)
    pc.Scene(WHEEL, units=atomic)
    pc.Scene(pc.RigidBody(pc.Disc(0.1), (0.0, 0.0), density=1000.0), units=atomic)


def test_scenes_of_rigid_bodies_are_taken_by_a_method_of_order_two():
    """Contacts take those of higher order to order one."""
    for items in ((BALL,), (BALL, GRAIN), (BALL, GRAIN, pc.BallJoint(BALL, None, Z3))):
        assert type(check({}, pc.Scene(*items)).integrator) is pc.VelocityVerlet
    assert type(check({}, pc.Scene(GRAIN)).integrator) is pc.BlanesMoan4


HINGE = pc.Hinge("wheel", None, (0.0, 3.0))
JOINTS = [
    HINGE,
    pc.Hinge((BOXES, 1), WHEEL, (0.0, 0.0), lower=-1.0, upper=2.0, breaking_force=3.0),
    pc.BallJoint(("dust", 1), ("boxes", -1), (1.0, 0.0)),
    pc.Weld(WHEEL, (BOXES, 0)),
    pc.Prismatic(None, WHEEL, (0.0, 2.0), upper=1.0),
    pc.Rod(WHEEL, (BOXES, 1)),
    pc.SpringJoint((BOXES, 0), None, [(0.0, 1.0), (0.0, 3.0)], 3.0, damping=0.5),
    pc.Motor(HINGE, 3.0, 1.0),
]


def test_joints_are_told_by_rows_of_all_particles():
    """The rows are those of dust (0, 1), boxes (2, 3, 4) and wheel (5)."""
    free = {"axis": None, "lower": None, "upper": None, "breaking_force": None}
    told = described(JOINTS[-1], *JOINTS[:-1], DUST, BOXES, WHEEL)
    assert told[:6] == [
        ("Motor", {"joint": 1.0, "speed": 3.0, "torque": 1.0}),
        ("Hinge", {"one": 5.0, "other": None, "anchor": (0.0, 3.0), **free}),
        (
            "Hinge",
            {
                "one": 3.0,
                "other": 5.0,
                "anchor": (0.0, 0.0),
                "axis": None,
                "lower": -1.0,
                "upper": 2.0,
                "breaking_force": 3.0,
            },
        ),
        ("BallJoint", {"one": 1.0, "other": 4.0, "anchor": (1.0, 0.0), "breaking_force": None}),
        ("Weld", {"one": 5.0, "other": 2.0, "anchor": (0.0, 3.0), "breaking_force": None}),
        ("Prismatic", {"one": None, "other": 5.0, "anchor": (0.0, 3.0), **free, "axis": (0.0, 1.0), "upper": 1.0}),
    ]
    (rod, ends), (spring, values) = told[6:]
    assert (rod, spring) == ("Rod", "SpringJoint")
    assert ends.pop("anchors").tolist() == [[0.0, 3.0], [1.0, 1.0]]
    assert ends == {"one": 5.0, "other": 3.0, "breaking_force": None}
    assert values.pop("anchors").tolist() == [[0.0, 1.0], [0.0, 3.0]]
    assert values == {
        "one": 2.0,
        "other": None,
        "stiffness": 3.0,
        "damping": 0.5,
        "rest_length": 2.0,
        "breaking_force": None,
    }


def test_axes_have_the_length_one():
    ((_, values),) = described(BALL, pc.Hinge(BALL, None, Z3, (3e-200, 0.0, 4e-200)))
    assert values["axis"] == pytest.approx((0.6, 0.0, 0.8), rel=1e-15)


def test_each_joint_has_a_row_of_results():
    """Motors have none, wherever they stand."""
    scene = pc.Scene(DUST, BOXES, WHEEL, JOINTS[0], JOINTS[-1], *JOINTS[1:-1])
    assert scene.fields["joint_forces"].shape == (7, 2)
    assert scene.fields["joint_torques"].shape == (7,)
    for row, joint in enumerate(JOINTS[:-1]):
        assert scene.parts(joint) == {"force": ("joint_forces", row), "torque": ("joint_torques", row)}
    assert pc.Scene(BALL, pc.BallJoint(BALL, None, Z3)).fields["joint_torques"].shape == (1, 3)
    assert scene.targets(JOINTS[2]) == (DUST, BOXES)
    assert scene.targets(JOINTS[-1]) == (WHEEL,)
    assert scene.members(JOINTS[2]).tolist() == scene.members(JOINTS[2], "one").tolist() == [False, True]
    assert scene.members(JOINTS[2], "other").tolist() == [False, False]
    with pytest.raises(pc.SceneError, match="is no constraint of this scene"):
        scene.parts(pc.Weld(WHEEL, (BOXES, 1)))


def test_scenes_with_joints_are_saved_sent_and_hashed():
    """A motor that comes before its joint too."""
    scene = pc.Scene(JOINTS[-1], *JOINTS[:-1], DUST, BOXES, WHEEL)
    for twin in (unpack_scene(scene.packed()), pickle.loads(pickle.dumps(scene))):
        assert twin.hash() == scene.hash()
        assert twin.constraints[0].joint is twin.constraints[1]
    other = pc.Hinge(WHEEL, None, (0.0, 3.0), lower=-1.0)
    assert pc.Scene(WHEEL, other).hash() != pc.Scene(WHEEL, HINGE).hash()
    assert pc.Scene(WHEEL, HINGE).hash() == pc.Scene(WHEEL, pc.Hinge(WHEEL, None, (0.0, 3.0))).hash()


def test_joints_are_values():
    assert pc.Rod(WHEEL, (BOXES, 1)) == JOINTS[5]
    assert hash(pc.Rod(WHEEL, (BOXES, 1))) == hash(JOINTS[5])
    assert pc.Rod(WHEEL, (BOXES, 2)) != JOINTS[5]
    assert pc.Motor(pc.Hinge("wheel", None, (0.0, 3.0)), 3.0, 1.0) == JOINTS[-1]
    assert all(joint == other for joint, other in zip(JOINTS, map(copy.copy, JOINTS), strict=True))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.Hinge(WHEEL, WHEEL, (0, 0)), "Hinge.other: must be another body than one"),
        (lambda: pc.Hinge((BALLS, 1), (BALLS, -2), Z3, UP), "Hinge.other: must be another body than one"),
        (lambda: pc.Hinge(None, None, (0, 0)), "Hinge.one: must be a body, because other=None is the world"),
        (lambda: pc.Hinge((BALLS, 3), None, Z3, UP), "Hinge.one: index 3 is outside of RigidBodies"),
        (lambda: pc.Hinge(BALLS, None, Z3, UP), r"Hinge.one: must be one of them, as \(body, index\)"),
        (lambda: pc.Hinge((BALLS, [0, 1]), None, Z3, UP), r"Hinge.one: must be one of them, as \(body, index\)"),
        (lambda: pc.Hinge([WHEEL, BALL], None, Z3, UP), r"Hinge.one: must be one body, \(body, index\), or None"),
        (lambda: pc.Hinge(3, None, (0, 0)), "Hinge.one: must be a body, its name"),
        (lambda: pc.Hinge(BALL, None, Z3), "Hinge.axis: must be a vector of 3 components in 3D, got None"),
        (lambda: pc.Hinge(BALL, None, Z3, Z3), "Hinge.axis: must be a vector that is not zero"),
        (lambda: pc.Hinge(WHEEL, None, (0, 3), UP), "Hinge.axis: must be None in 2D"),
        (lambda: pc.Hinge(BALL, None, (0, 0), UP), "Hinge.anchor: must have 3 components like the bodies"),
        (lambda: pc.Hinge(WHEEL, None, (0, 3), lower=2, upper=1), "Hinge.lower: must be ≤ upper, got 2 and 1"),
        (lambda: pc.Hinge(WHEEL, None, (0, 3), lower=0.5), "Hinge.lower: must be ≤ 0, because the angle at the start"),
        (lambda: pc.Hinge(WHEEL, None, (0, 3), upper=-0.5), "Hinge.upper: must be ≥ 0, because the angle at the start"),
        (lambda: pc.Hinge(WHEEL, None, (0, 3), breaking_force=0), "Hinge.breaking_force: must be > 0"),
        (lambda: pc.Hinge(GRAIN, BALL, Z3, UP), "Hinge.one: must be a rigid body or None, .* take a BallJoint"),
        (lambda: pc.BallJoint(GRAIN, None, Z3), "BallJoint.one: must be a rigid body, or other must be one"),
        (lambda: pc.BallJoint(GRAIN, BALL, UP), "BallJoint.anchor: must be the position of the particle"),
        (lambda: pc.BallJoint(WHEEL, BALL, Z3), "BallJoint.other: must be in 2D like one"),
        (
            lambda: pc.BallJoint((pc.Fluid([Z3], 0.1), 0), BALL, Z3),
            "BallJoint.one: .* a particle of Particles or a Spr",
        ),
        (lambda: pc.Weld(BALL, None, (1, 2)), "Weld.anchor: must have 3 components like the bodies"),
        (lambda: pc.Prismatic(BALL, None, (0, 1)), "Prismatic.axis: must have 3 components like the bodies"),
        (lambda: pc.Prismatic(BALL, None, Z3), "Prismatic.axis: must be a vector that is not zero"),
        (lambda: pc.Prismatic(BALL, None, UP, lower=1.0), "Prismatic.lower: must be ≤ 0, because the way at the start"),
        (lambda: pc.Rod(BALL, None), "Rod.anchors: must be given, because an end is the world"),
        (lambda: pc.Rod(BALL, GRAIN), "Rod.anchors: must differ; a rod without length is a BallJoint"),
        (lambda: pc.Rod(BALL, None, [(0, 0), (0, 1)]), r"Rod.anchors\[0\]: must have 3 components like the bodies"),
        (lambda: pc.Rod(BALL, None, Z3), "Rod.anchors: must be two points, one on each end"),
        (lambda: pc.SpringJoint(BALL, None, [Z3, UP], -1.0), "SpringJoint.stiffness: must be ≥ 0"),
        (lambda: pc.SpringJoint(BALL, None, [Z3, UP], 1.0, rest_length=-1.0), "SpringJoint.rest_length: must be ≥ 0"),
        (lambda: pc.Motor(JOINTS[3], 1.0, 1.0), "Motor.joint: must be a Hinge or a Prismatic, got Weld"),
        (lambda: pc.Motor(HINGE, 1.0, -1.0), "Motor.torque: must be ≥ 0"),
        (lambda: pc.Scene(WHEEL, JOINTS[-1]), r"constraints\[0\].joint: Hinge.* is not in the scene; add it"),
        (lambda: pc.Scene(WHEEL, JOINTS[1]), r"constraints\[0\].one: RigidBodies.* is not in the scene; add it"),
        (lambda: pc.Scene(WHEEL, pc.Weld("whel", None)), r"constraints\[0\].one: nothing is called 'whel'.*'wheel'\?"),
        (lambda: pc.Scene(BOXES, pc.Weld("boxes", None)), r"Weld.one: must be one of them, as \(body, index\)"),
        (lambda: pc.Scene(WHEEL, pc.Weld("wheel", "wheel")), "Weld.other: must be another body than one"),
    ],
)
def test_what_is_no_joint_is_refused(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()


@pytest.mark.parametrize("kind", [pc.Hinge, pc.BallJoint, pc.Weld, pc.Prismatic, pc.Rod, pc.SpringJoint])
@pytest.mark.parametrize("named", [False, True])
@pytest.mark.parametrize("first", [False, True])
def test_no_joint_holds_a_particle_of_a_fluid(kind, named, first):
    """The engine has no points of fluids for joints: it would leave such a joint out."""
    water = pc.Fluid.block((0.0, 0.0), (0.2, 0.2), 0.05, name="water")
    box = pc.RigidBody(pc.Rectangle(0.1, 0.1), (0.5, 0.1), name="box")
    particle = tuple(water.positions[3].tolist())
    body, grain = ("box", ("water", 3)) if named else (box, (water, 3))
    ends, points = ((grain, body), [particle, (0.5, 0.1)]) if first else ((body, grain), [(0.5, 0.1), particle])
    arguments = {"Prismatic": [(1.0, 0.0)], "Rod": [points], "SpringJoint": [points, 10.0]}
    with pytest.raises(pc.SceneError, match=rf"{kind.__name__}.{'one' if first else 'other'}: must be a rigid body"):
        pc.Scene(water, box, kind(*ends, *arguments.get(kind.__name__, [particle])))


def test_bodies_that_may_touch_are_refused_in_a_periodic_domain():
    """Contacts across its faces are not found. A body that meets nothing may be there."""
    square = pc.Periodic((0.0, 0.0), (1.0, 1.0))
    pair = pc.RigidBodies(pc.Disc(0.1), [(0.2, 0.5), (0.8, 0.5)])
    single = pc.RigidBody(pc.Disc(0.1), (0.2, 0.5), velocity=(1.0, 0.0))
    grain = pc.Particles([[0.5, 0.5]])
    floor = pc.Floor(0.0)
    for items in ([pair], [single, grain], [single, floor]):
        with pytest.raises(pc.SceneError, match=r"no Periodic domain in a scene of bodies that may touch"):
            pc.Simulation(pc.Scene(*items, square))
    assert pc.simulate(pc.Scene(single, square), 1.0, dt=0.1)[single].positions[-1, 0].tolist() == pytest.approx([0.2, 0.5])


class Engine:
    """The fields of particles and rigid bodies as the engine has them, with a row each."""

    def __init__(self) -> None:
        self.values = {
            "positions": np.arange(12.0).reshape(6, 2),
            "velocities": np.arange(12.0).reshape(6, 2) + 100.0,
            "angles": np.arange(4.0),
            "angular_velocities": np.arange(4.0) + 10.0,
        }

    def fields(self):
        rates = {"positions": "velocities", "angles": "angular_velocities"}
        return [(name, "1", "", list(own.shape), rates.get(name), True) for name, own in self.values.items()]

    def read(self, name):
        return self.values[name].copy()

    def write(self, fields):
        self.values |= fields


def test_fields_of_the_engine_are_split_and_put_together():
    """The rows of the scene's bodies are boxes (0, 1, 2), dust (3, 4) and wheel (5)."""
    scene, world = pc.Scene(BOXES, DUST, WHEEL), Engine()
    assert {info.name: (info.shape, info.rate) for info in engine.fields(world, scene)} == {
        "positions": ((2, 2), "velocities"),
        "rigid_positions": ((4, 2), "rigid_velocities"),
        "velocities": ((2, 2), None),
        "rigid_velocities": ((4, 2), None),
        "angles": ((4,), "angular_velocities"),
        "angular_velocities": ((4,), None),
    }
    assert engine.read(world, scene, "positions").tolist() == [[6.0, 7.0], [8.0, 9.0]]
    assert engine.read(world, scene, "rigid_velocities")[:, 0].tolist() == [100.0, 102.0, 104.0, 110.0]
    assert engine.read(world, scene, "angles").tolist() == [0.0, 1.0, 2.0, 3.0]
    changes = Changes(world, scene)
    changes.put("positions", {"dust": -1.0, WHEEL: [[-2.0, -3.0]]})
    changes.put("velocities", 0.0)
    changes.put_part(BOXES, "angles", 7.0, "boxes")
    engine.write(world, scene, changes.fields)
    assert world.values["positions"].tolist() == [*[[2 * k, 2 * k + 1] for k in range(3)], [-1, -1], [-1, -1], [-2, -3]]
    assert world.values["velocities"][:, 0].tolist() == [100.0, 102.0, 104.0, 0.0, 0.0, 110.0]
    assert world.values["angles"].tolist() == [7.0, 7.0, 7.0, 3.0]
    with pytest.raises(
        pc.SceneError, match=r"set.positions: must broadcast to the shape \(2, 2\), got the shape \(6, 2\)"
    ):
        changes.put("positions", np.zeros((6, 2)))
    with pytest.raises(pc.SceneError, match=r"set.velocities: no body 'rust'.*'dust'\?"):
        changes.put("velocities", {"rust": 0.0})


def steady(times, spin, start):
    """Orientations (F, 1, 4) of a body that turns at a constant angular velocity [rad/s]."""
    half = 0.5 * np.linalg.norm(spin) * np.asarray(times)
    axis = spin / np.linalg.norm(spin)
    w, x = np.cos(half)[:, np.newaxis], np.sin(half)[:, np.newaxis] * axis
    product = np.column_stack(
        [w[:, 0] * start[0] - x @ start[1:], w * start[1:] + start[0] * x + np.cross(x, start[1:])]
    )
    return product[:, np.newaxis]


def test_orientations_between_steps_are_of_order_four_and_of_unit_length():
    """The error of order four is along the quaternion in a steady rotation, and is lost with its length: a step that is
    twice as long has 2⁵ times the error, up to the next order. In the middle of the step it vanishes by symmetry.
    """
    spin, start = np.array([1.0, 2.0, -2.0]), np.array([0.5, 0.5, -0.5, 0.5])

    def error(dt, sign):
        first, middle, last = steady([0.0, 0.2 * dt, dt], spin, start)
        states = [
            Snapshot(0.0, {"orientations": q, "angular_velocities": spin[np.newaxis]}) for q in (first, sign * last)
        ]
        found = between(*states, 0.2, dt, {"orientations": None, "angular_velocities": None}).orientations
        assert abs(np.linalg.norm(found) - 1.0) < 4e-16
        return np.abs(found - middle).max()

    for sign in (1.0, -1.0):
        assert 30.0 < error(0.2, sign) / error(0.1, sign) < 34.0
        assert error(1e-9, sign) < 1e-15


def test_the_rate_of_a_quaternion_is_that_of_a_turning_body():
    """By central differences of step h, with an error h²/6 of the third derivative (ω/2)³: 6e-9 for h = 1e-4."""
    spin, start = np.array([1.0, 2.0, -2.0]), np.array([0.5, 0.5, -0.5, 0.5])
    before, after = steady([-1e-4, 1e-4], spin, start)
    rate = quaternion_rates(start[np.newaxis], spin[np.newaxis])
    np.testing.assert_allclose((after - before) / 2e-4, rate, atol=1e-8)


@pytest.mark.parametrize("body", [WHEEL, BALL], ids=["2D", "3D"])
def test_a_body_that_turns_in_place_has_the_period_of_its_rotation(body):
    times, scene = np.linspace(0.0, 3.0, 181), pc.Scene(body)
    rate = 2.0 * math.pi / 0.7
    channels = {
        "positions": np.empty((181, 0, scene.dimension)),
        "rigid_positions": np.zeros((181, 1, scene.dimension)),
    }
    turned = steady(times, np.array([0.0, 0.0, rate]), np.array([1.0, 0.0, 0.0, 0.0]))
    channels |= {"angles": rate * times[:, np.newaxis]} if scene.dimension == 2 else {"orientations": turned}
    # The parabola through three frames of 1/60 s is off by (ω Δt)²/24 of a frame at most: 2e-5 s.
    assert period_of(times, marked(scene, channels), None) == pytest.approx(0.7, abs=2e-5)
    assert marked(scene, {"positions": channels["positions"]}) is None
