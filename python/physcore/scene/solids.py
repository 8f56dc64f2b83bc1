"""Shapes of rigid bodies: their base class, and round and rectangular ones."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from physcore import _core
from physcore.checks import DIMENSIONS, FloatArray, count, frozen, span
from physcore.errors import SceneError
from physcore.scene.by_value import ByValue
from physcore.scene.records import Record


class MassProperties(NamedTuple):
    """Mass properties of a shape of density 1."""

    size: float
    """Area [m²] in 2D, volume [m³] in 3D."""
    center: FloatArray
    """Center of mass in the coordinates of the shape [m], shape (D,)."""
    moment: float | FloatArray
    """Moment of inertia per unit density about the center: in 2D a number [m⁴], in 3D the tensor [m⁵], (3, 3)."""


@dataclass(frozen=True, eq=False, repr=False)
class Shape(ByValue):
    """Base class of the shapes of rigid bodies. Shapes are immutable and compared by value."""

    is_part: ClassVar[bool] = True
    """Whether the shape can be a part of a Compound."""

    def __post_init__(self) -> None:
        """Check the fields, which are lengths above zero; other shapes have checks of their own."""
        kind = type(self).__name__
        self._set(**{each.name: span(getattr(self, each.name), f"{kind}.{each.name}") for each in fields(self)})

    @property
    def dimensions(self) -> tuple[int, ...]:
        """Dimensions of space in which the shape exists."""
        return DIMENSIONS

    @property
    def area(self) -> float:
        """Area [m²], of a shape in 2D."""
        return self.properties(2).size

    @property
    def volume(self) -> float:
        """Volume [m³], of a shape in 3D."""
        return self.properties(3).size

    @property
    def center(self) -> FloatArray:
        """Center of mass in the coordinates of the shape [m], shape (D,)."""
        return self.properties(self._only("center")).center

    @property
    def moment(self) -> float | FloatArray:
        """Moment of inertia per unit density about the center of mass: in 2D a number [m⁴], in 3D the tensor [m⁵] along
        the axes of the shape, (3, 3).
        """
        return self.properties(self._only("moment")).moment

    def properties(self, dimension: int) -> MassProperties:
        """The mass properties in 2D or 3D.

            pc.Cuboid(0.4, 0.2, 0.1).properties(3).size  # the volume

        Args:
            dimension: 2 or 3.

        Raises:
            SceneError: the shape does not exist in this dimension.
        """
        known = self._properties
        if count(dimension, "properties.dimension") not in self.dimensions:
            raise SceneError(
                f"{type(self).__name__}: is a shape in {self._spaces}, and has no properties in {dimension}D"
            )
        if dimension not in known:
            size, center, inertia = _core.shape_properties(Record.of(self).described(), dimension)
            moment = float(inertia[2, 2]) if dimension == 2 else frozen(np.array(inertia))
            known[dimension] = MassProperties(size, frozen(np.array(center[:dimension])), moment)
        return known[dimension]

    def __getstate__(self) -> dict[str, object]:
        """The state without what is found anew."""
        return {name: value for name, value in self.__dict__.items() if name != "_properties"}

    @cached_property
    def _properties(self) -> dict[int, MassProperties]:
        """The properties by dimension, as far as they were asked for."""
        return {}

    @property
    def _spaces(self) -> str:
        """The dimensions as text."""
        return " and ".join(f"{each}D" for each in self.dimensions)

    def _only(self, name: str) -> int:
        """The only dimension of the shape.

        Raises:
            SceneError: it exists in several.
        """
        if len(self.dimensions) > 1:
            raise SceneError(
                f"{type(self).__name__}.{name}: depends on the dimension; take properties(2) or properties(3)"
            )
        return self.dimensions[0]

    def _set(self, **values: object) -> None:
        """Set fields of the frozen dataclass; only for constructors."""
        for name, value in values.items():
            object.__setattr__(self, name, frozen(value) if isinstance(value, np.ndarray) else value)


class PlanarShape(Shape):
    """Base class of shapes in 2D."""

    @property
    def dimensions(self) -> tuple[int, ...]:
        """The dimension 2."""
        return (2,)


class SpatialShape(Shape):
    """Base class of shapes in 3D."""

    @property
    def dimensions(self) -> tuple[int, ...]:
        """The dimension 3."""
        return (3,)


@dataclass(frozen=True, eq=False, repr=False)
class Disc(PlanarShape):
    """Disc, the shape of a rigid body in 2D.

        wheel = pc.RigidBody(pc.Disc(0.1), (0.0, 0.5), angular_velocity=10.0)
        pc.Disc(0.1).area  # 0.0314 m²

    Args:
        radius: radius [m], above zero.

    Raises:
        SceneError: the radius is not above zero.
    """

    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class Rectangle(PlanarShape):
    """Rectangle about its center, the shape of a rigid body in 2D.

        crates = pc.RigidBodies(pc.Rectangle(0.2, 0.1), [(0.0, 0.05), (0.0, 0.15)], density=600.0)
        pc.Rectangle(0.4, 0.2).area  # 0.08 m²

    Args:
        width: length along x [m], above zero.
        height: length along y [m], above zero.

    Raises:
        SceneError: a length is not above zero.
    """

    width: float
    height: float


@dataclass(frozen=True, eq=False, repr=False)
class Capsule(Shape):
    """Capsule about its center, the shape of a rigid body: all points within `radius` of a segment.

        pc.Capsule(0.4, 0.1).area, pc.Capsule(0.4, 0.1).volume

    The segment is along x in 2D and along z in 3D. The center and the moment are in `properties(2)` and
    `properties(3)`.

    Args:
        length: length of the segment, between the centers of the round ends [m], above zero.
        radius: radius [m], above zero.

    Raises:
        SceneError: a length is not above zero.
    """

    length: float
    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class Ball(SpatialShape):
    """Ball, the shape of a rigid body in 3D.

        marble = pc.RigidBody(pc.Ball(0.01), (0.0, 0.0, 0.2), density=2500.0)
        pc.Ball(0.01).volume  # 4.19e-6 m³

    Args:
        radius: radius [m], above zero.

    Raises:
        SceneError: the radius is not above zero.
    """

    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class Cuboid(SpatialShape):
    """Cuboid about its center, the shape of a rigid body in 3D.

        brick = pc.RigidBody(pc.Cuboid(0.24, 0.115, 0.071), (0.0, 0.0, 1.0), density=1900.0)
        pc.Cuboid(0.4, 0.2, 0.1).moment  # the tensor of inertia per unit density, (3, 3)

    Args:
        a, b, c: lengths along x, y and z [m], above zero.

    Raises:
        SceneError: a length is not above zero.
    """

    a: float
    b: float
    c: float
