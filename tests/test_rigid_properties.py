"""Properties of random scenes with rigid bodies: energy, walls, and momentum of what flies freely."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc

CELL = 0.5
"""Edge of the cells in which bodies start [m]."""
REACH = 0.2
"""Largest distance of a surface point from the center of mass [m]: bodies in different cells do not touch."""
SIDE = 2
"""Cells along each axis of the box."""
DT = 1 / 240
MOST_GAIN = 1e-3
"""Change of the energy balance, over the energy at the start, above which it must be an error of the step size.

Bodies that roll over each other's edges at ten radians per second turn by 0.04 rad in a step.
"""
LARGEST_GAIN = 1e-2
"""Largest change."""
DEEPEST = 1e-3
"""Largest depth in a wall, over the size of a body: above what contacts at rest leave, 1e-6."""

sizes = st.floats(0.3, 1.0)
units = st.floats(-1.0, 1.0)
angles = st.floats(-math.pi, math.pi)


def vectors(dimension: int) -> st.SearchStrategy[tuple[float, ...]]:
    return st.tuples(*[units] * dimension)


@st.composite
def shapes(draw: st.DrawFn, dimension: int) -> Any:
    """A shape whose surface is within `REACH` of the center of mass."""
    a, b, c = (draw(sizes) for _ in range(3))
    half = REACH / math.sqrt(dimension)
    if dimension == 2:
        corners = [(0.55 * REACH * a * math.cos(t), 0.55 * REACH * b * math.sin(t)) for t in (0.0, 1.5, 3.0, 4.5)]
        return draw(
            st.sampled_from(
                [
                    pc.Disc(REACH * a),
                    pc.Rectangle(2.0 * half * a, 2.0 * half * b),
                    pc.Capsule(REACH * a, 0.5 * REACH * b),
                    pc.Polygon(corners),
                ]
            )
        )
    tetrahedron = 0.4 * REACH * np.array([[-a, -b, -c], [a, -b, c], [-a, b, c], [a, b, -c]])
    return draw(
        st.sampled_from(
            [
                pc.Ball(REACH * a),
                pc.Cuboid(2.0 * half * a, 2.0 * half * b, 2.0 * half * c),
                pc.Capsule(REACH * a, 0.5 * REACH * b),
                pc.Hull(tetrahedron),
            ]
        )
    )


@st.composite
def placed(draw: st.DrawFn, dimension: int, count: int) -> list[pc.RigidBody]:
    """Bodies that stand, turned and moving, in cells of their own."""
    cells = draw(st.permutations(list(np.ndindex(*[SIDE] * dimension))))[:count]
    bodies = []
    for cell in cells:
        turn: dict[str, Any] = {"angle": draw(angles)}
        if dimension == 3:
            turn = {"orientation": (1.5, *draw(vectors(3)))}
        spin = np.multiply(8.0, draw(vectors(2 * dimension - 3)))
        bodies.append(
            pc.RigidBody(
                draw(shapes(dimension)),
                CELL * (np.array(cell) + 0.5),
                velocity=np.multiply(2.0, draw(vectors(dimension))),
                angular_velocity=float(spin[0]) if dimension == 2 else spin,
                mass=draw(sizes),
                friction=draw(st.floats(0.0, 1.0)),
                restitution=draw(st.floats(0.0, 1.0)),
                **turn,
            )
        )
    return bodies


@st.composite
def boxes(draw: st.DrawFn) -> pc.Scene:
    """Bodies that fall and bounce in a box."""
    dimension = draw(st.sampled_from([2, 3]))
    bodies = draw(placed(dimension, draw(st.integers(1, 2**dimension))))
    walls = pc.Box(
        (0.0,) * dimension,
        (SIDE * CELL,) * dimension,
        restitution=draw(st.floats(0.0, 1.0)),
        friction=draw(st.floats(0.0, 1.0)),
    )
    return pc.Scene(*bodies, walls, pc.Gravity(-9.81 * np.eye(dimension)[-1]))


def rotations(part: Any) -> np.ndarray:
    """Rotations (F, D, D) of a body, over time."""
    if part.positions.shape[-1] == 2:
        c, s = np.cos(part.angles[:, 0]), np.sin(part.angles[:, 0])
        return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
    w, *axis = part.orientations[:, 0].T
    x, y, z = axis
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def core(shape: Any, dimension: int) -> tuple[np.ndarray, float]:
    """Points (K, D) about the center of mass, and the distance within which the shape is around their hull."""
    if isinstance(shape, (pc.Disc, pc.Ball)):
        return np.zeros((1, dimension)), shape.radius
    if hasattr(shape, "length"):
        along = np.eye(dimension)[0 if dimension == 2 else 2]
        return 0.5 * shape.length * np.array([along, -along]), shape.radius
    if isinstance(shape, (pc.Polygon, pc.Hull)):
        points = shape.vertices if isinstance(shape, pc.Polygon) else shape.points
        return points - shape.center, 0.0
    edges = (shape.width, shape.height) if isinstance(shape, pc.Rectangle) else (shape.a, shape.b, shape.c)
    signs = np.array(list(np.ndindex(*[2] * dimension))) - 0.5
    return signs * edges, 0.0


def gained(energy: pc.Energy) -> float:
    """The largest change of the balance, over the energy at the start."""
    balance = energy.total + energy.dissipated - energy.work
    return float(np.abs(balance - balance[0]).max() / abs(energy.total[0]))


@given(boxes())
def test_bodies_in_a_box_stay_there_and_gain_no_energy(scene):
    recording = pc.simulate(scene, 0.5, fps=60, dt=DT)
    energy, start = recording.energy, abs(recording.energy.total[0])
    gain = gained(energy)
    assert gain <= LARGEST_GAIN
    if gain > MOST_GAIN:
        assert gained(pc.simulate(scene, 0.5, fps=60, dt=DT / 8).energy) <= MOST_GAIN
    assert energy.total.max() <= (1.0 + LARGEST_GAIN) * start
    assert (np.diff(energy.dissipated) >= -1e-12 * start).all()  # rounding of sums
    for body in scene.bodies:
        points, radius = core(body.shape, scene.dimension)
        part = recording[body]
        surface = part.positions + np.einsum("fij,kj->fki", rotations(part), points)
        size = np.linalg.norm(points, axis=1).max() + radius
        assert surface.min() - radius >= -DEEPEST * size
        assert surface.max() + radius <= SIDE * CELL + DEEPEST * size


THIN = 1e-3
"""Thickness of the walls of a cage [m]."""


@st.composite
def jagged(draw: st.DrawFn, dimension: int) -> tuple[Any, np.ndarray]:
    """A shape that is not convex, with its corners (K, D) about the center of mass."""
    a, b = (0.5 * REACH * draw(sizes) for _ in range(2))
    kind = draw(st.sampled_from(["outline", "parts"]))
    if dimension == 2:
        if kind == "outline":  # a star, or an arrow
            count = draw(st.integers(2, 5))
            turns = math.pi / count * np.arange(2 * count)
            radii = np.where(np.arange(2 * count) % 2, 0.4, 1.0) * (a, b)[count % 2]
            star = pc.Polygon(np.column_stack([radii * np.cos(turns), radii * np.sin(turns)]))
            return star, star.vertices - star.center
        bar, across = pc.Rectangle(2.0 * a, 0.2 * a), pc.Rectangle(0.2 * b, 2.0 * b)
        angle = pc.Compound([(bar, (0.0, -b), 0.0), (across, (-a, 0.0), 0.0)])
        corners = np.concatenate([core(bar, 2)[0] + (0.0, -b), core(across, 2)[0] + (-a, 0.0)])
        return angle, corners - angle.center
    signs = np.array(list(np.ndindex(2, 2, 2))) - 0.5
    if kind == "parts":
        bar, across = pc.Cuboid(2.0 * a, 0.2 * a, 0.3 * a), pc.Cuboid(0.2 * b, 2.0 * b, 0.1 * b)
        cross = pc.Compound([(bar, (0.0, -b, 0.0), (1, 0, 0, 0)), (across, (-a, 0.0, 0.0), (1, 0, 0, 0))])
        corners = np.concatenate([core(bar, 3)[0] + (0.0, -b, 0.0), core(across, 3)[0] + (-a, 0.0, 0.0)])
        return cross, corners - cross.center
    # A cube with a pit: the corner at (1, 1, 1) is pushed in.
    points = 1.5 * a * signs
    points[-1] *= -0.2
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]]
    mesh = pc.MeshShape(points, [*faces, [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    return mesh, points - mesh.center


@st.composite
def cages(draw: st.DrawFn) -> tuple[pc.Scene, list[tuple[pc.RigidBody, np.ndarray, float]]]:
    """Bodies that fly and spin at any speed up to 10 km/s in a cage of thin walls, with their corners and radii."""
    dimension = draw(st.sampled_from([2, 3]))
    cells = draw(st.permutations(list(np.ndindex(*[SIDE] * dimension))))[: draw(st.integers(1, 3))]
    bodies = []
    for cell in cells:
        if draw(st.booleans()):
            shape, corners = draw(jagged(dimension))
            radius = 0.0
        else:
            shape = draw(shapes(dimension))
            corners, radius = core(shape, dimension)
        fast, quick = (10.0 ** draw(st.floats(0.0, 4.0)) for _ in range(2))
        spin = quick * np.array(draw(vectors(2 * dimension - 3)))
        turn: dict[str, Any] = {"angle": draw(angles)}
        if dimension == 3:
            turn = {"orientation": (1.5, *draw(vectors(3)))}
        body = pc.RigidBody(
            shape,
            CELL * (np.array(cell) + 0.5),
            velocity=fast * np.array(draw(vectors(dimension))),
            angular_velocity=float(spin[0]) if dimension == 2 else spin,
            mass=draw(sizes),
            friction=draw(st.floats(0.0, 1.0)),
            restitution=draw(st.floats(0.0, 1.0)),
            **turn,
        )
        bodies.append((body, corners, radius))
    side, walls = SIDE * CELL, []
    for axis in range(dimension):
        for sign in (-1.0, 1.0):
            size = np.full(dimension, 1.2 * side)
            size[axis] = THIN
            place = np.full(dimension, 0.5 * side)
            place[axis] += 0.5 * sign * (side + THIN)
            shape = pc.Rectangle(*size) if dimension == 2 else pc.Cuboid(*size)
            walls.append(pc.RigidBody(shape, place, fixed=True, friction=draw(st.floats(0.0, 1.0))))
    return pc.Scene(*(body for body, _, _ in bodies), *walls, pc.Gravity(-9.81 * np.eye(dimension)[-1])), bodies


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@given(cages())
def test_nothing_passes_through_thin_walls(cage):
    """At 10 km/s a body crosses the cage forty times in a step, and may turn as often."""
    scene, bodies = cage
    recording = pc.simulate(scene, 10 * DT, fps=1 / DT, dt=DT)
    energy = recording.energy.total
    turn = DT * max(np.linalg.norm(recording[body].angular_velocities, axis=-1).max() for body, _, _ in bodies)
    # In space, a free rotation by splitting errs by up to turn² / 12 of its energy; in the plane it is exact.
    if scene.dimension == 2 or turn**2 / 12 <= MOST_GAIN:
        assert (energy <= energy[0] * (1.0 + MOST_GAIN) + 1.0).all()  # gravity gives less than 1 J
    for body, corners, radius in bodies:
        part = recording[body]
        surface = part.positions + np.einsum("fij,kj->fki", rotations(part), corners)
        size = np.linalg.norm(corners, axis=1).max() + radius
        assert surface.min() - radius >= -DEEPEST * size
        assert surface.max() + radius <= SIDE * CELL + DEEPEST * size


JOINTS = ("Hinge", "BallJoint", "Weld", "Prismatic", "Rod")


@st.composite
def trees(draw: st.DrawFn) -> pc.Scene:
    """Bodies in free flight, each joined to an earlier one."""
    dimension = draw(st.sampled_from([2, 3]))
    bodies = draw(placed(dimension, draw(st.integers(2, 4))))
    joints: list[pc.Constraint] = []
    for index, body in enumerate(bodies[1:], 1):
        other = bodies[draw(st.integers(0, index - 1))]
        anchor = 0.5 * (body.positions[0] + other.positions[0])
        kind = draw(st.sampled_from(JOINTS))
        axis = np.array([1.0, *draw(vectors(dimension - 1))])
        match kind:
            case "Hinge":
                joints.append(pc.Hinge(body, other, anchor, **({"axis": axis} if dimension == 3 else {})))
            case "Prismatic":
                joints.append(pc.Prismatic(body, other, axis))
            case "Rod":
                joints.append(pc.Rod(body, other))
            case _:
                joints.append(getattr(pc, kind)(body, other, anchor))
    return pc.Scene(*bodies, *joints)


@given(trees())
def test_trees_of_joints_in_free_flight_keep_their_momenta(scene):
    """Joints and contacts are pairs of opposite impulses at one point: what remains is the rounding of 60 steps, of all
    coordinates within 4 m, and of masses up to 1 kg at speeds of 2 m/s and some.
    """
    recording = pc.simulate(scene, 0.25, fps=60, dt=DT)
    size = sum(float(body.mass[0]) for body in scene.bodies) * 10.0
    rounding = 100.0 * 60.0 * np.finfo(float).eps * size
    for values, scale in ((recording.momentum, 1.0), (recording.angular_momentum, 4.0)):
        values = np.asarray(values)
        assert np.abs(values - values[0]).max() <= rounding * scale


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_shapes_of_these_scenes_are_within_their_cells(dimension):
    """So that no scene is refused because bodies overlap at the start."""

    @given(shapes(dimension))
    def check(shape):
        points, radius = core(shape, dimension)
        assert np.linalg.norm(points, axis=1).max() + radius <= REACH * (1.0 + 1e-12)

    check()
