"""The hand: springs from a particle or a rigid body to the pointer."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from physcore.arithmetic import combined
from physcore.checks import FloatArray, array, count, shown
from physcore.constraints.links import SpringJoint
from physcore.errors import SceneError
from physcore.forces.central import CentralForce
from physcore.forces.drag import Drag
from physcore.scene.bodies import Body
from physcore.scene.rigid import RigidBodies
from physcore.scene.rotations import planar_rotations, rotation_of, spatial_rotations
from physcore.scene.scene import Scene
from physcore.simulation.state import Part

RATE = 25.0
"""Angular frequency of the hand's spring with the mass of what it holds [rad per second of the clock on the wall]."""
SOFTEST = 0.5
"""Largest stiffness that is chosen, in units of m/dt². Verlet's method is stable up to 4."""
DAMPING = 0.35
"""Damping ratio of the held particle on the hand's spring."""


@dataclass(frozen=True, eq=False)
class Hand:
    """Spring with damping that holds one particle or rigid body.

    A hand that turns a rigid body holds it by several points instead, each on a spring to its place in the body as it
    is to be, with the center at the pointer. Equal masses at these points have the moments of inertia of the body, so
    that it turns at the frequency at which it follows the pointer.
    """

    body: Body
    """A body of the scene."""
    index: int
    """The index of the particle or rigid body in it."""
    pointer: tuple[float, ...]
    """The fixed end of the spring [m]."""
    stiffness: float
    """Stiffness, of all springs together [N/m]."""
    attitude: FloatArray | None = None
    """Orientation of a rigid body when it was taken hold of, a matrix (D, D); None of a particle."""
    rotation: FloatArray | None = None
    """Angle in 2D, shape (1,), or rotation vector in 3D by which a rigid body is turned [rad]; None: it is free."""

    @property
    def damping(self) -> float:
        """Damping of the held particle [N·s/m]."""
        return 2.0 * DAMPING * math.sqrt(self.stiffness * float(self.body.mass[self.index]))

    def at(self, point: object) -> Hand:
        """The hand with its pointer at a point [m].

        Raises:
            SceneError: the point has another dimension, or is not finite.
        """
        place = array(point, "drag.point")
        if place.shape != (self.body.dimension,):
            raise SceneError(f"drag.point: must have {self.body.dimension} components, got {shown(point)}")
        return replace(self, pointer=tuple(place.tolist()))

    def turned(self, rotation: object) -> Hand:
        """The hand that turns a rigid body by an angle, or a rotation vector, from its orientation at the grab [rad].

        Raises:
            SceneError: a particle is held, or the rotation is not valid.
        """
        if self.attitude is None:
            raise SceneError(f"turn.rotation: only a rigid body turns, and a {type(self.body).__name__} is held")
        size = {2: 1, 3: 3}[self.body.dimension]
        given = array(cast("ArrayLike", rotation), "turn.rotation")
        if given.size != size:
            expected = "an angle [rad]" if size == 1 else "a rotation vector of 3 components [rad]"
            raise SceneError(f"turn.rotation: must be {expected}, got {shown(rotation)}")
        return replace(self, rotation=given.reshape(size))

    def items(self, *, damped: bool) -> tuple[CentralForce | Drag | SpringJoint, ...]:
        """The forces or joints of the springs, with or without damping."""
        held, damping = (self.body, self.index), self.damping if damped else 0.0
        if self.rotation is None or self.attitude is None:
            drag = [Drag(damping, on=held)] if damped else []
            return CentralForce(self.pointer, self.stiffness, 1.0, on=held), *drag
        rigid = cast("RigidBodies", self.body)
        points = _grips(rigid)
        own = rigid.positions[self.index] + combined(points, attitude(rigid, self.index).T)
        ends = self.pointer + combined(combined(points, self.attitude.T), rotation_of(self.rotation).T)
        stiffness, damping = self.stiffness / len(points), damping / len(points)
        return tuple(
            SpringJoint(held, None, [grip, end], stiffness, damping, rest_length=0.0)
            for grip, end in zip(own, ends, strict=True)
        )

    def within(self, scene: Scene, before: Scene) -> Hand | None:
        """The hand in a scene that follows another one; None if what it holds is not there any more."""
        name, place = self.body.name, before.index(self.body)
        bodies = [body for body in scene.bodies if body is self.body or (name is not None and body.name == name)]
        if not bodies and name is None:
            bodies = [body for body in scene.bodies[place : place + 1] if body.name is None]
        if not bodies or len(bodies[0]) != len(self.body) or bodies[0].fixed[self.index]:
            return None
        return replace(self, body=bodies[0])


def scene_with(scene: Scene, hand: Hand | None, *, damped: bool) -> Scene:
    """The scene with the forces or joints of a hand. Its items are those of the scene."""
    if hand is None:
        return scene
    held = copy(scene)
    for item in hand.items(damped=damped):
        object.__setattr__(held, item.section, (*getattr(held, item.section), item))
    return held


def attitude(rigid: RigidBodies | Part, index: int) -> FloatArray:
    """Orientation of a rigid body as a matrix (D, D)."""
    if rigid.positions.shape[1] == 2:
        return planar_rotations(cast("FloatArray", rigid.angles)[index])
    return spatial_rotations(cast("FloatArray", rigid.orientations)[index])


def grasp(scene: Scene, key: object, places: dict[Body, FloatArray]) -> tuple[Body, int]:
    """Body and index of the element to be held: as named, or the free one nearest to a point.

    Args:
        scene: the scene.
        key: what was asked for.
        places: the present positions of each body [m].

    Raises:
        SceneError: there is no such body or element, or it is held by the scene.
    """
    free = [body for body in scene.bodies if not body.fixed.all()]
    if not free:
        raise SceneError("grab.key: there is nothing to hold: the scene has no particles or rigid bodies that can move")
    if not _is_point(key):
        return _named(scene, *(key if isinstance(key, tuple) and len(key) == 2 else (key, 0)))
    point = array(key, "grab.key")
    if point.shape != (scene.dimension,):
        raise SceneError(
            f"grab.key: must be (body, index), or a point of {scene.dimension} components, got {shown(key)}"
        )
    nearest = [_nearest(body, places[body], point) for body in free]
    best = min(range(len(free)), key=lambda place: nearest[place][0])
    return free[best], nearest[best][1]


def chosen_stiffness(body: Body, index: int, dt: float, speed: float) -> float:
    """A stiffness [N/m] with which a held element follows the pointer, at a time step [s] and a speed of play [s/s].

    A network is moved as a whole, other particles are moved one by one.
    """
    own = float(body.mass[index])
    carried = own if body.network is None else float(body.mass[~body.fixed].sum())
    return min(carried * (RATE / speed) * (RATE / speed), SOFTEST * own / (dt * dt))


def _grips(rigid: RigidBodies) -> FloatArray:
    """Points of a shape, in its coordinates relative to its center of mass [m], shape (2 D, D).

    Two on each axis. Points of equal masses there have the moments of inertia of the body about these axes.
    """
    size, _, moment = rigid.shape.properties(rigid.dimension)
    diagonal = np.full(2, 0.5 * moment) if rigid.dimension == 2 else 0.5 * np.trace(moment) - np.diagonal(moment)
    reach = np.diag(np.sqrt(rigid.dimension * diagonal / size))
    return np.concatenate([reach, -reach])


def _is_point(key: object) -> bool:
    """Whether a value is a list or an array, or a tuple of numbers."""
    numbers = isinstance(key, tuple) and all(isinstance(each, (int, float, np.number)) for each in key)
    return numbers or isinstance(key, (list, np.ndarray))


def _named(scene: Scene, key: Any, index: object) -> tuple[Body, int]:
    """The element that a body, or its name, and an index stand for."""
    try:
        body = scene.bodies[scene.index(key)]
    except KeyError as error:
        raise SceneError(f"grab.key: {error.args[0]}") from None
    place = count(index, "grab.key[1]", most=len(body) - 1)
    if body.fixed[place]:
        raise SceneError(f"grab.key: {scene.path(body)} holds element {place} fixed, and no force moves it")
    return body, place


def _nearest(body: Body, places: FloatArray, point: FloatArray) -> tuple[float, int]:
    """Squared distance and index of the free element of a body that is nearest to a point."""
    squares = ((places - point) * (places - point)).sum(axis=1)
    squares[body.fixed] = math.inf
    index = int(squares.argmin())
    return float(squares[index]), index
