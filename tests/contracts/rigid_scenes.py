"""Scenes with rigid bodies: free flight, impacts, stacks, joints, motors, particles, and bodies that are driven."""

from __future__ import annotations

from typing import Any

import numpy as np

import physcore as pc

G = 9.81
DOWN = pc.Gravity((0.0, -G))
SHARD = ((0.0, 0.0, 0.0), (0.4, 0.0, 0.0), (0.1, 0.3, 0.0), (0.1, 0.1, 0.25))
"""Corners of a tetrahedron that is not its own mirror image."""


def tumbling() -> pc.Scene:
    """A box that turns about its middle axis, a shard and an L-shaped body, which fly apart and touch nothing."""
    box = pc.RigidBody(pc.Cuboid(0.4, 0.2, 0.1), (0.0, 0.0, 0.0), mass=2.0, angular_velocity=(0.1, 5.0, 0.2))
    shard = pc.RigidBody(
        pc.Hull(SHARD),
        (2.0, 0.5, -1.0),
        orientation=(0.8, 0.0, 0.6, 0.0),
        velocity=(0.5, 1.0, -0.5),
        angular_velocity=(2.0, -3.0, 1.0),
    )
    bent = pc.Compound([(pc.Cuboid(0.4, 0.1, 0.1), (0.0, 0.0, 0.0)), (pc.Capsule(0.2, 0.05), (0.2, 0.1, 0.1))])
    pieces = pc.RigidBodies(
        bent,
        [(-2.0, 0.0, 0.5), (-2.0, 1.5, 0.0)],
        orientations=[(1.0, 0.0, 0.0, 0.0), (0.5, 0.5, -0.5, 0.5)],
        velocities=[(-1.0, 0.0, 0.2), (-0.5, 0.5, 0.0)],
        angular_velocities=[(1.0, 2.0, 3.0), (-2.0, 0.5, 1.0)],
        mass=(1.0, 3.0),
    )
    return pc.Scene(box, shard, pieces)


def spinning() -> pc.Scene:
    """A shard alone."""
    return pc.Scene(tumbling().bodies[1])


def discs(side: int = 2) -> pc.Scene:
    """Discs that fall in a box and meet in pairs, with friction and restitution."""
    sites = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), -1).reshape(-1, 2)
    rows, columns = sites.T
    body = pc.RigidBodies(
        pc.Disc(0.1),
        0.5 * sites + np.column_stack([0.25 + 0.05 * (rows % 2), 0.3 + 0.03 * (columns % 3)]),
        velocities=np.column_stack([np.where(rows % 2, -1.5, 1.5), 0.4 * (columns % 2)]),
        angular_velocities=2.0 - 3.0 * (columns % 2),
        mass=1.0 + 0.5 * (rows % 3),
        friction=0.3,
        restitution=0.8,
    )
    return pc.Scene(body, pc.Box((0.0, 0.0), (0.5 * side + 0.05,) * 2, restitution=0.7, friction=0.2), DOWN)


def stack() -> pc.Scene:
    """Boxes on each other, of which the upper ones slide to a side."""
    crates = pc.RigidBodies(
        pc.Rectangle(0.5, 0.25),
        [(0.0, 0.125), (0.0, 0.375), (0.03125, 0.625)],
        velocities=[(0.0, 0.0), (0.75, 0.0), (2.0, 0.0)],
        mass=(2.0, 1.0, 0.5),
        friction=0.4,
    )
    return pc.Scene(crates, pc.Floor(restitution=0.0, friction=0.4), DOWN)


def die() -> pc.Scene:
    """A die that is thrown on a table."""
    body = pc.RigidBody(
        pc.Cuboid(0.1, 0.1, 0.1),
        (0.0, 0.0, 0.125),
        orientation=(0.9, 0.3, 0.1, 0.2),
        velocity=(0.5, -0.25, -1.0),
        angular_velocity=(4.0, 7.0, -2.0),
        friction=0.4,
        restitution=0.3,
    )
    return pc.Scene(
        body, pc.Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), restitution=0.3, friction=0.3), pc.Gravity((0, 0, -G))
    )


def linkage() -> pc.Scene:
    """Bars by hinges that hang on one point, with a spring to the wall and a hinge that reaches its limit."""
    bars = pc.RigidBodies(pc.Rectangle(0.3, 0.05), [(0.15, 0.0), (0.45, 0.0), (0.75, 0.0)], mass=(1.0, 0.5, 0.25))
    joints = [
        pc.Hinge((bars, 0), None, (0.0, 0.0)),
        pc.BallJoint((bars, 1), (bars, 0), (0.3, 0.0)),
        pc.Hinge((bars, 2), (bars, 1), (0.6, 0.0), lower=-0.25, upper=0.4),
    ]
    spring = pc.SpringJoint((bars, 2), None, [(0.9, 0.0), (0.9, 1.0)], 5.0, damping=0.1, rest_length=0.8)
    return pc.Scene(bars, *joints, spring, DOWN)


def frame() -> pc.Scene:
    """A door, a plank that is welded to it, a ball on a joint, and a rod to a particle, in space."""
    door = pc.RigidBody(pc.Cuboid(0.8, 0.05, 1.0), (0.4, 0.0, 0.5), mass=4.0)
    plank = pc.RigidBody(pc.Cuboid(0.2, 0.1, 0.1), (0.9, 0.0, 0.5), mass=0.5)
    ball = pc.RigidBody(pc.Ball(0.1), (1.0, 0.0, 0.2), mass=0.5, velocity=(0.0, 0.3, 0.0), angular_velocity=(1.2, 0, 0))
    bead = pc.Particles([[1.4, 0.0, 0.2]], velocities=[(0.0, 0.0, 0.5)], mass=0.2)
    joints = [
        pc.Hinge(door, None, (0.0, 0.0, 0.5), axis=(0.1, 0.0, 1.0)),
        pc.Weld(door, plank, (0.8, 0.0, 0.5)),
        pc.BallJoint(plank, ball, (1.0, 0.0, 0.45)),
        pc.Rod(ball, (bead, 0), [(1.0, 0.0, 0.2), (1.4, 0.0, 0.2)]),
    ]
    return pc.Scene(door, plank, ball, bead, *joints, pc.Gravity((0.0, 1.0, -G)))


def machine() -> pc.Scene:
    """A motor that turns an arm against its weight, and one that pushes a slider to its end."""
    arm = pc.RigidBody(pc.Rectangle(0.4, 0.1), (0.125, 0.0), mass=1.0)
    piston = pc.RigidBody(pc.Rectangle(0.2, 0.1), (0.0, 2.0), mass=2.0)
    axle, slider = pc.Hinge(arm, None, (0.0, 0.0)), pc.Prismatic(piston, None, (0.8, 0.6), lower=-0.25, upper=0.125)
    return pc.Scene(arm, piston, axle, slider, pc.Motor(axle, 6.0, 2.5), pc.Motor(slider, 1.0, 30.0), DOWN)


def struck() -> pc.Scene:
    """A ball, struck by particles with and without size, one of which misses it."""
    ball = pc.RigidBody(pc.Ball(0.2), (0.0, 0.0, 0.0), mass=1.0, friction=0.3, restitution=0.6)
    shots = pc.Particles(
        [[-1.0, 0.05, 0.0], [0.7, 0.1, -0.05], [0.0, 0.1, 1.2], [1.0, 1.0, 1.0]],
        velocities=[[4.0, 0.0, 0.0], [-3.0, 0.0, 0.5], [0.1, 0.0, -6.0], [0.0, 1.0, 0.0]],
        radius=[0.05, 0.0, 0.1, 0.05],
        mass=[0.1, 0.2, 0.05, 0.1],
    )
    return pc.Scene(ball, shots)


def paddle() -> pc.Scene:
    """A paddle that turns as prescribed and hits a pebble."""
    blade = pc.RigidBody(pc.Rectangle(0.8, 0.1), (0.0, 0.0), fixed=True, angular_velocity=3.0, friction=0.4)
    pebble = pc.RigidBody(
        pc.Polygon([(-0.1, -0.06), (0.1, -0.05), (0.06, 0.08), (-0.05, 0.07)]),
        (0.25, 0.3),
        angle=0.4,
        mass=0.5,
        restitution=0.5,
    )
    return pc.Scene(blade, pebble, DOWN)


def heap(count: int = 12) -> pc.Scene:
    """A column of discs that falls on a floor, as one large group where `sequential` is below their number."""
    places = [(0.02 * (index % 3), 0.15 + 0.21 * index) for index in range(count)]
    body = pc.RigidBodies(pc.Disc(0.1), places, velocities=(0.2, -1.0), friction=0.4, restitution=0.2)
    return pc.Scene(body, pc.Floor(restitution=0.2, friction=0.4), DOWN)


def naps() -> pc.Scene:
    """Two stacks that fall asleep, of which a ball wakes one, and a bar that hangs from a spring and sleeps too."""
    options = {"mass": 1.0, "friction": 0.4, "sleep": 0.05, "sleep_after": 0.25}
    crates = pc.RigidBodies(
        pc.Rectangle(0.5, 0.25), [(0.0, 0.125), (0.0, 0.375), (2.0, 0.125), (2.0, 0.375)], **options
    )
    ball = pc.RigidBody(pc.Disc(0.1), (-3.0, 0.1), velocity=(2.75, 0.0), angular_velocity=-27.5, **options)
    bar = pc.RigidBody(pc.Rectangle(0.1, 0.3), (4.0, 0.5), **options)
    spring = pc.SpringJoint(bar, None, [(4.0, 0.65), (4.0, 1.65)], G / 0.5, rest_length=0.5)
    return pc.Scene(crates, ball, bar, spring, pc.Floor(restitution=0.0, friction=0.4), DOWN)


def sails() -> pc.Scene:
    """A box, a ball and a shard that tumble in the wind."""
    box = pc.RigidBody(
        pc.Cuboid(0.4, 0.3, 0.1),
        (0.0, 0.0, 0.0),
        orientation=(0.9, 0.1, 0.3, -0.2),
        mass=0.4,
        angular_velocity=(1.0, 2.0, -1.0),
    )
    ball = pc.RigidBody(pc.Ball(0.2), (1.0, 0.0, 0.0), mass=0.2, angular_velocity=(0.0, 5.0, 1.0))
    shard = pc.RigidBody(pc.Hull(SHARD), (0.0, 1.0, 0.0), mass=0.1, velocity=(0.5, 0.0, -1.0))
    air = pc.Wind((5.0, 2.0, -1.0), tangential=0.1)
    return pc.Scene(box, ball, shard, air, pc.Gravity((0.0, 1.0, -G)))


def weathervane() -> pc.Scene:
    """A vane and a disc in a wind in the plane."""
    vane = pc.RigidBody(
        pc.Polygon([(-0.1, -0.02), (0.5, -0.02), (0.5, 0.2), (0.3, 0.02), (-0.1, 0.02)]),
        (0.2, 0.05),
        angle=0.7,
        mass=0.5,
    )
    disc = pc.RigidBody(pc.Disc(0.2), (1.0, 0.0), mass=0.3, angular_velocity=-6.0)
    air = pc.Wind((4.0, 1.0), tangential=0.2)
    return pc.Scene(vane, disc, air, pc.Gravity((0.0, -0.1 * G)))


def hammock(side: int = 5) -> pc.Scene:
    """A cloth that is tied to two boxes in flight, and a box on a joint that bears a particle."""
    cloth = pc.cloth(
        (side, side),
        0.1,
        20.0,
        damping=0.02,
        mass=0.01,
        origin=(0.0, 0.0, 0.0),
        axes=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    )
    width = 0.1 * (side - 1)
    boxes = pc.RigidBodies(
        pc.Cuboid(0.1, 0.4, 0.2),
        [(-0.06, 0.5 * width, 0.03), (width + 0.06, 0.5 * width, 0.0)],
        velocities=[(-0.5, 0.2, 0.0), (0.3, 0.0, 0.4)],
        angular_velocities=[(0.5, 1.0, -1.0), (0.0, -2.0, 0.3)],
        mass=(0.3, 0.2),
    )
    beam = pc.RigidBody(pc.Cuboid(0.6, 0.1, 0.1), (0.3, -2.0, 0.0), mass=0.5)
    weight = pc.Particles([[0.6, -2.0, 0.2]], mass=0.1)
    columns = np.arange(side * side) % side
    ties = [
        pc.Anchor(cloth, columns == 0, (boxes, 0)),
        pc.Anchor(cloth, columns == side - 1, (boxes, 1)),
        pc.Anchor(weight, 0, beam),
    ]
    return pc.Scene(
        cloth, boxes, beam, weight, *ties, pc.BallJoint(beam, None, (0.0, -2.0, 0.0)), pc.Gravity((0.0, 1.0, -G))
    )


def caught() -> pc.Scene:
    """A ball and a box, smaller than its faces, that are thrown into a cloth in flight."""
    cloth = pc.cloth(
        (4, 4),
        0.2,
        60.0,
        damping=0.05,
        mass=0.02,
        origin=(-0.3, -0.3, 0.0),
        axes=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    )
    ball = pc.RigidBody(pc.Ball(0.05), (0.21, -0.13, 0.06), velocity=(-0.5, 0.2, -1.0), mass=0.1, friction=0.4)
    box = pc.RigidBody(
        pc.Cuboid(0.1, 0.08, 0.06),
        (-0.15, 0.12, 0.08),
        velocity=(0.3, 0.0, -0.8),
        angular_velocity=(1.0, -2.0, 0.5),
        mass=0.15,
        friction=0.3,
        restitution=0.5,
    )
    return pc.Scene(cloth, ball, box, pc.Gravity((0.0, 0.0, -G)))


def flagpole() -> pc.Scene:
    """A flag on a pole that turns as prescribed, in the wind."""
    flag = pc.cloth(
        (6, 4),
        0.1,
        40.0,
        damping=0.05,
        mass=0.01,
        origin=(0.05, 0.0, 0.0),
        axes=((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    )
    pole = pc.RigidBody(pc.Cuboid(0.05, 0.05, 1.0), (0.0, 0.0, 0.0), fixed=True, angular_velocity=(0.0, 0.0, 3.0))
    tie = pc.Anchor(flag, np.arange(24) % 6 == 0, pole)
    return pc.Scene(flag, pole, tie, pc.Wind((3.0, 1.0, 0.0)), pc.Gravity((0.0, 0.0, -G)))


def pile(**options: Any) -> dict[str, Any]:
    """Numerics of a large group of a few bodies."""
    return {"contacts": pc.ContactSolver(**{"sequential": 4, **options})}


def floating(spacing: float = 0.1) -> pc.Scene:
    """A box that falls into water, and a paddle in the water that turns as prescribed."""
    box = pc.RigidBody(
        pc.Rectangle(0.4, 0.3), (0.5, 0.95), angle=0.2, velocity=(0.2, -1.0), angular_velocity=0.5, density=600.0
    )
    paddle = pc.RigidBody(pc.Capsule(0.3, 0.12), (1.2, 0.4), angle=0.3, fixed=True, angular_velocity=2.0)
    points = pc.block((0.0, 0.0), (1.6, 0.7), spacing)
    water = pc.Fluid(points[~paddle.contains(points)], spacing, viscosity=1.0)
    return pc.Scene(box, paddle, water, pc.Box((0.0, 0.0), (1.6, 1.4), restitution=0.2, friction=0.4), DOWN)


def splashes(spacing: float = 0.15) -> pc.Scene:
    """A shard that is hit by a drop."""
    shard = pc.RigidBody(
        pc.Hull([tuple(2.0 * each for each in corner) for corner in SHARD]),
        (0.0, 0.0, 0.0),
        orientation=(0.8, 0.0, 0.6, 0.0),
        angular_velocity=(1.0, -0.5, 2.0),
        density=800.0,
    )
    drop = pc.Fluid(pc.block((0.55, -0.45, -0.45), (1.45, 0.45, 0.45), spacing), spacing, velocities=(-2.0, 0.0, 0.0))
    return pc.Scene(shard, drop)
