"""Plane and floor."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from physcore.arithmetic import dots, lengths
from physcore.checks import FloatArray, Vector, number, vector
from physcore.errors import SceneError
from physcore.scene.items import Boundary


@dataclass(frozen=True)
class Plane(Boundary):
    """Plane, a line in 2D. Particles stay on the side to which the normal points.

        ball = pc.Particles([[0.0, 1.0]], radius=0.1)
        scene = pc.Scene(ball, pc.Gravity(), pc.Plane((0.0, 0.0), normal=(1.0, 2.0), friction=0.3))

    Args:
        point: any point of the plane [m].
        normal: the normal of the plane, of any length above zero.
        restitution, friction, no_slip, on: as in Boundary.

    Raises:
        SceneError: the normal is zero, the two vectors differ in size, or a value is not finite.
    """

    point: Vector
    normal: Vector

    def __post_init__(self) -> None:
        super().__post_init__()
        point, normal = vector(self.point, "Plane.point"), vector(self.normal, "Plane.normal")
        if len(point) != len(normal):
            raise SceneError(f"Plane.normal: must have {len(point)} components like the point, got {len(normal)}")
        if not any(normal):
            raise SceneError("Plane.normal: must not be zero")
        self._set(point=point, normal=normal)

    def resolved(self, dimension: int) -> Plane:
        """The plane with a normal of length 1."""
        del dimension
        normal = np.array(self.normal)
        normal /= np.abs(normal).max()
        return replace(self, normal=tuple((normal / lengths(normal)).tolist()))

    @property
    def flat(self) -> tuple[Vector, Vector]:
        """The point and the normal."""
        return self.point, self.normal

    def is_symmetric(self, middle: FloatArray, normal: FloatArray, tolerance: float) -> bool:
        """Whether its normal lies in the plane."""
        del middle
        return bool(abs(dots(np.array(self.normal), normal)) < tolerance)


@dataclass(frozen=True)
class Floor(Boundary):
    """Horizontal floor. Particles stay above it. Up is the last axis: y in 2D, z in 3D.

        ball = pc.Particles([[0.0, 1.0]], radius=0.1)
        scene = pc.Scene(ball, pc.Gravity(), pc.Floor(restitution=0.8))

    Args:
        height: the coordinate of the floor along the last axis [m].
        restitution, friction, no_slip, on: as in Boundary.

    Raises:
        SceneError: a value is out of range or not finite.
    """

    height: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set(height=number(self.height, "Floor.height"))

    def resolved(self, dimension: int) -> Plane:
        """The floor as a Plane."""
        up = np.eye(dimension)[-1]
        shared = {entry.name: getattr(self, entry.name) for entry in fields(Boundary)}
        return Plane(tuple((self.height * up).tolist()), tuple(up.tolist()), **shared)
