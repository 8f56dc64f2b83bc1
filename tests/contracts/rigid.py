"""Rigid bodies in the contracts: their state as points that move with them, and what other coordinates make of them.

A body is its center and the tips of arrows from there along its axes. Tips move as points of any kind, in a mirror too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import physcore as pc

if TYPE_CHECKING:
    from contracts.transforms import Transform

Array = NDArray[np.float64]
DEPTH = 4.0
"""Depth of what was in the plane, in space [m]: far more than its size, so that it is easiest to turn in the plane."""


def gyration(body: pc.RigidBodies) -> float:
    """The least radius of gyration about an axis of the shape [m]: the length of arrows."""
    properties = body.shape.properties(body.dimension)
    return float(np.sqrt(np.min(np.diag(np.atleast_2d(properties.moment))) / properties.size))


def matrices(orientations: Array) -> Array:
    """The rotations of unit quaternions (…, 4), shape (…, 3, 3)."""
    w, x, y, z = np.moveaxis(orientations, -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternion(rotation: Array) -> Array:
    """The unit quaternion of a rotation (3, 3), from the largest of its components."""
    r = rotation
    products = np.array(  # 4 q qᵀ
        [
            [1 + r[0, 0] + r[1, 1] + r[2, 2], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], 1 + r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], 1 - r[0, 0] + r[1, 1] - r[2, 2], r[1, 2] + r[2, 1]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 1 - r[0, 0] - r[1, 1] + r[2, 2]],
        ]
    )
    row = products[int(np.argmax(np.diag(products)))]
    return row / np.linalg.norm(row)


def arrows(body: pc.RigidBodies, part: Any, axes: int) -> tuple[list[Array], list[Array]]:
    """Arrows along the first axes of bodies, and their rates of change, shape (…, B, D) each."""
    length = gyration(body)
    if body.dimension == 2:
        along = [np.stack([np.cos(part.angles), np.sin(part.angles)], axis=-1)]
        rates = [part.angular_velocities[..., None] * each[..., ::-1] * (-1.0, 1.0) for each in along]
    else:
        turned = matrices(part.orientations)
        along = [turned[..., axis] for axis in range(axes)]
        rates = [np.cross(part.angular_velocities, each) for each in along]
    return [length * each for each in along], [length * each for each in rates]


def material(state: Any, axes: int | None = None) -> tuple[Array, Array]:
    """Positions and velocities, shape (…, N, D): of particles, and of centers and tips of rigid bodies, in the order of
    the scene. `axes` is the number of arrows of a body, D − 1 by default.
    """
    x, v = [], []
    for body in state.scene.bodies:
        part = state[body]
        x.append(part.positions)
        v.append(part.velocities)
        if body.is_rigid:
            along, rates = arrows(body, part, body.dimension - 1 if axes is None else axes)
            x += [part.positions + each for each in along]
            v += [part.velocities + each for each in rates]
    return np.concatenate(x, axis=-2), np.concatenate(v, axis=-2)


def rows(scene: pc.Scene, orders: list[NDArray[np.int64]]) -> NDArray[np.int64]:
    """The rows of `material` of a scene whose bodies are in other orders."""
    found, start = [], 0
    for body, order in zip(scene.bodies, orders, strict=True):
        for _ in range(body.dimension if body.is_rigid else 1):
            found.append(start + np.asarray(order, dtype=int))
            start += len(body)
    return np.concatenate(found)


def centers(scene: pc.Scene) -> NDArray[np.bool_]:
    """Which rows of `material` are particles and centers."""
    parts = [np.arange((body.dimension if body.is_rigid else 1) * len(body)) < len(body) for body in scene.bodies]
    return np.concatenate(parts)


def put(run: pc.Simulation, x: Array, v: Array) -> None:
    """Set a run to centers and tips that are nearly those of its bodies."""
    start = 0
    for body in run.scene.bodies:
        count = len(body)
        parts = body.dimension if body.is_rigid else 1
        places, speeds = (each[start : start + parts * count].reshape(parts, count, -1) for each in (x, v))
        start += parts * count
        values: dict[str, Any] = {"positions": places[0], "velocities": speeds[0]}
        if body.is_rigid:
            along, rates = (places[1:] - places[0]) / gyration(body), (speeds[1:] - speeds[0]) / gyration(body)
            values |= _turns(run[body], along, rates)
        run[body].set(**values)


def _turns(part: Any, along: Array, rates: Array) -> dict[str, Any]:
    """The orientations and angular velocities of bodies whose arrows, of unit length, are nearly those of `part`."""
    if along.shape[-1] == 2:
        before = np.stack([np.cos(part.angles), np.sin(part.angles)], axis=-1)
        (after,), (rate,) = along, rates
        change = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        spins = after[:, 0] * rate[:, 1] - after[:, 1] * rate[:, 0]
        return {"angles": part.angles + change, "angular_velocities": spins}
    turns, spins = [], []
    for first, second, *speeds in zip(*along, *rates, strict=True):
        one = first / np.linalg.norm(first)
        other = second - one * one.dot(second)
        other /= np.linalg.norm(other)
        turns.append(quaternion(np.column_stack([one, other, np.cross(one, other)])))
        across = np.concatenate([-np.cross(np.eye(3), each).T for each in (one, other)])  # ω × e, as a matrix
        spins.append(np.linalg.lstsq(-across, np.concatenate(speeds), rcond=None)[0])
    return {"orientations": np.array(turns), "angular_velocities": np.array(spins)}


def turning(t: Transform) -> float | Array:
    """What becomes of angular velocities, which are axial: a sign in the plane, a matrix in space, or the axis that the
    plane has in space.
    """
    if t.axes.shape == (3, 2):
        return np.cross(t.axes[:, 0], t.axes[:, 1])
    sign = np.round(np.linalg.det(t.axes))
    return float(sign) if len(t.axes) == 2 else sign * t.axes


def spins(t: Transform, values: Array) -> Array:
    """Angular velocities, or axes of joints, in other coordinates."""
    how = turning(t)
    if t.axes.shape == (3, 2):
        return np.multiply.outer(values, how)
    return values * how if len(t.axes) == 2 else np.asarray(values) @ np.asarray(how).T


def _mirror(t: Transform) -> Array:
    """The coordinates of shapes: a mirror turns round their last axis, so that rotations stay rotations."""
    mirror = np.eye(t.axes.shape[1])
    if t.axes.shape[0] == t.axes.shape[1] and np.linalg.det(t.axes) < 0.0:
        mirror[-1, -1] = -1.0
    return mirror


def shape(given: Any, t: Transform) -> Any:
    """A shape in other coordinates; in space one of the plane is the prism over it, along the last axis of the body."""
    mirror = _mirror(t)
    if t.axes.shape == (3, 2):
        if isinstance(given, pc.Rectangle):
            return pc.Cuboid(given.width, given.height, DEPTH)
        return pc.Hull([(*each, end) for each in given.vertices for end in (-0.5 * DEPTH, 0.5 * DEPTH)])
    if isinstance(given, pc.Polygon):
        return pc.Polygon(given.vertices @ mirror * t.m)
    if isinstance(given, pc.Hull):
        return pc.Hull(given.points @ mirror * t.m)
    if isinstance(given, pc.Compound):
        parts = [shape(each, t) for each in given.shapes]
        turns = (
            None
            if given.orientations is None
            else given.orientations * np.where(np.diag(mirror)[-1] < 0, (1, -1, -1, 1), 1)
        )
        angles = None if given.angles is None else given.angles * np.linalg.det(mirror)
        return pc.Compound(parts, given.positions @ mirror * t.m, angles, turns)
    return type(given)(**{name: value * t.m for name, value in vars(given).items() if name != "_properties"})


def _orientation(t: Transform, given: Array) -> Array:
    """A quaternion in other coordinates."""
    if np.array_equal(t.axes, np.eye(3)):
        return given
    return quaternion(t.axes @ matrices(given) @ _mirror(t))


def bodies(body: pc.RigidBodies, t: Transform, order: NDArray[np.int64]) -> pc.RigidBodies:
    """Rigid bodies in another order and in other coordinates."""
    turns: dict[str, Any] = {}
    if body.orientations is not None:
        turns["orientations"] = np.array([_orientation(t, each) for each in body.orientations])[order]
    elif len(t.axes) == 3:
        across = np.column_stack([t.axes, turning(t)])
        rotations = matrices(
            np.stack([np.cos(body.angles / 2), *[0 * body.angles] * 2, np.sin(body.angles / 2)], axis=-1)
        )
        turns["orientations"] = np.array([quaternion(across @ each) for each in rotations])[order]
    else:
        turns["angles"] = (np.linalg.det(t.axes) * body.angles + np.arctan2(t.axes[1, 0], t.axes[0, 0]))[order]
    return pc.RigidBodies(
        shape(body.shape, t),
        t.points(body.positions)[order],
        velocities=t.velocities(body.velocities)[order],
        angular_velocities=spins(t, body.angular_velocities)[order] * t.unit(0, -1),
        mass=body.mass[order] * t.kg,
        friction=body.friction[order],
        restitution=body.restitution[order],
        fixed=body.fixed[order],
        rolling_friction=body.rolling_friction[order] * t.m,
        torsional_friction=body.torsional_friction[order] * t.m,
        charge=body.charge[order],
        sleep=None if body.sleep is None else body.sleep[order] * t.unit(1, -1),
        sleep_after=body.sleep_after[order] * t.s,
        name=body.name,
        **turns,
    )


def joint(item: Any, values: dict[str, Any], t: Transform) -> dict[str, Any]:
    """The parameters of a joint in other coordinates, as far as they are no plain quantities."""
    result = dict(values)
    if isinstance(item, pc.Hinge):
        plane, sign = item.axis is None, turning(t)
        if len(t.axes) == 3:
            result["axis"] = tuple(spins(t, 1.0 if plane else np.array(item.axis)))
        elif sign == -1.0:
            result["lower"], result["upper"] = (None if end is None else -end for end in (item.upper, item.lower))
    return result


def motor(item: pc.Motor, driven: Any, t: Transform) -> pc.Motor:
    """A motor of a joint in other coordinates."""
    turns = isinstance(item.joint, pc.Hinge)
    sign = turning(t) if turns and len(t.axes) == 2 else 1.0
    speed = item.speed * sign * t.unit(0 if turns else 1, -1)
    return pc.Motor(driven, speed, item.torque * t.unit(2 if turns else 1, -2, 1))
