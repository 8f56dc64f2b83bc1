"""Rotation matrices, for bodies of demos with an initial orientation."""

from __future__ import annotations

import math

import numpy as np

from physcore.checks import FloatArray


def rotation(axis: tuple[float, float, float], angle: float) -> FloatArray:
    """The matrix of a rotation about an axis by an angle [rad] (O. Rodrigues, 1840)."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    matrix: FloatArray = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return matrix
