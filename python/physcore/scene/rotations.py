"""Rotations of rigid bodies: angles, unit quaternions, and their matrices."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from physcore.arithmetic import cos, dots, lengths, sin
from physcore.checks import FloatArray, broadcast
from physcore.errors import SceneError

ROUNDING = 4.0 * float(np.finfo(float).eps)
"""Deviation of the length of a unit quaternion, by the rounding of its components and of its length."""


def unit_quaternions(value: ArrayLike, number: int, path: str) -> FloatArray:
    """Unit quaternions (w, x, y, z) in the directions of those given, of shape (number, 4).

    Quaternions of unit length, up to rounding, keep their bits.

    Raises:
        SceneError: the shape does not fit, a value is not finite, or a quaternion is zero.
    """
    given = broadcast(value, (number, 4), path)
    scale = np.abs(given).max(axis=1, initial=0.0, keepdims=True)
    if (scale == 0.0).any():
        place = "" if np.ndim(value) == 1 else f"[{int(np.argmax(scale == 0.0))}]"
        raise SceneError(f"{path}{place}: must not be zero; (1, 0, 0, 0) is no rotation")
    return normalized(given)


def normalized(vectors: FloatArray) -> FloatArray:
    """Vectors (…, D) that are not zero with length 1. Those of unit length, up to rounding, keep their bits."""
    scale = np.abs(vectors).max(axis=-1, initial=0.0, keepdims=True)
    near = vectors / scale
    size = lengths(near)[..., np.newaxis]
    with np.errstate(over="ignore"):  # infinity is no unit length
        kept = np.abs(scale * size - 1.0) <= ROUNDING
    unit: FloatArray = np.where(kept, vectors, near / size)
    return unit


def quaternion_rates(quaternions: FloatArray, angular_velocities: FloatArray) -> FloatArray:
    """Rates of change dq/dt = ½ (0, ω) q of unit quaternions (B, 4), for angular velocities ω along the axes of the
    world (B, 3).
    """
    w, axis = quaternions[:, :1], quaternions[:, 1:]
    turned = w * angular_velocities + np.cross(angular_velocities, axis)
    return 0.5 * np.column_stack([-dots(angular_velocities, axis), turned])


def planar_rotations(angles: FloatArray) -> FloatArray:
    """Rotation matrices (…, 2, 2) of angles (…) [rad]."""
    cosine, sine = cos(angles), sin(angles)
    return np.stack([np.stack([cosine, -sine], axis=-1), np.stack([sine, cosine], axis=-1)], axis=-2)


def spatial_rotations(quaternions: FloatArray) -> FloatArray:
    """Rotation matrices (…, 3, 3) of unit quaternions (w, x, y, z), shape (…, 4)."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def rotation_of(vector: FloatArray) -> FloatArray:
    """Rotation matrix of an angle, shape (1,), or of a rotation vector, shape (3,) [rad]."""
    if len(vector) == 1:
        turn: FloatArray = planar_rotations(vector)[0]
        return turn
    half = 0.5 * float(lengths(vector))
    size = float(sin(half)) / (2.0 * half) if half > 0.0 else 0.5
    return spatial_rotations(np.array([float(cos(half)), *(size * vector)]))
