"""Marks of rigid bodies: points of the bodies that show how these move and turn."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import cast

import numpy as np

from physcore.checks import FloatArray
from physcore.scene.bodies import Body
from physcore.scene.contents import Contents
from physcore.scene.rigid import RigidBodies
from physcore.scene.rotations import planar_rotations, spatial_rotations

TURNS = {2: "angles", 3: "orientations"}
"""Field of the orientations of rigid bodies in each dimension."""


def marks(scene: Contents, fields: Mapping[str, FloatArray]) -> FloatArray:
    """Centers of all rigid bodies, and in 2D one point, in 3D two points of each at its radius of gyration [m].

    Args:
        scene: scene with rigid bodies.
        fields: "rigid_positions" (…, B, D) [m], and "angles" (…, B) [rad] or "orientations" (…, B, 4).

    Returns:
        FloatArray: positions (…, B D, D): the centers, the points on the x axes, and in 3D those on the y axes.
    """
    centers = fields["rigid_positions"]
    return np.concatenate([centers, *(centers + arm for arm in arms(scene, fields))], axis=-2)


def mark_velocities(scene: Contents, fields: Mapping[str, FloatArray]) -> FloatArray:
    """Velocities [m/s] of the points of `marks`, in their order.

    Args:
        scene: scene with rigid bodies.
        fields: also "rigid_velocities" (…, B, D) [m/s], and "angular_velocities" (…, B) or (…, B, 3) [rad/s].
    """
    centers, turning = fields["rigid_velocities"], fields["angular_velocities"]
    rates = [
        turning[..., np.newaxis] * arm[..., ::-1] * (-1.0, 1.0) if scene.dimension == 2 else np.cross(turning, arm)
        for arm in arms(scene, fields)
    ]
    return np.concatenate([centers, *(centers + rate for rate in rates)], axis=-2)


def arms(scene: Contents, fields: Mapping[str, FloatArray]) -> list[FloatArray]:
    """Vectors (…, B, D) from the centers of rigid bodies along their x axes, in 3D also along their y axes, as long as
    the radii of gyration [m].
    """
    turns = fields[TURNS[scene.dimension]]
    rotations = planar_rotations(turns) if scene.dimension == 2 else spatial_rotations(turns)
    reach = gyrations(scene)[:, np.newaxis]
    return [reach * rotations[..., axis] for axis in range(scene.dimension - 1)]


def gyrations(scene: Contents) -> FloatArray:
    """Radii of gyration of all rigid bodies [m], shape (B,)."""
    return np.concatenate([np.full(len(body), _gyration(body)) for body in scene.bodies if body.is_rigid])


def _gyration(body: Body) -> float:
    """The radius of gyration of the shape of rigid bodies [m]; in 3D the root mean square distance from the center."""
    size, _, moment = cast("RigidBodies", body).shape.properties(body.dimension)
    square = float(np.trace(moment)) / 2.0 / size if isinstance(moment, np.ndarray) else moment / size
    return math.sqrt(square)
