"""Table of the fields of bodies, probes and boundaries, and the description of a field."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, Self, TypeAlias

Element: TypeAlias = Literal[
    "particles",
    "fluid particles",
    "rigid bodies",
    "springs",
    "beads",
    "joints",
    "ties",
    "walls",
    "probes",
    "cells",
    "points",
]
"""Elements that have a value each. Arrays over "fluid particles" have a row for every particle; walls are all
boundaries, followed by all bodies. Rigid bodies are no particles, although the engine has a row for each in the fields
of particles.
"""
Value: TypeAlias = Literal["number", "vector", "rotation", "quaternion"]
"""Kind of a value: a vector has a component for each axis, a rotation for each plane: one in 2D, three in 3D."""
Rows: TypeAlias = slice | int
"""Rows of a field that belong to an item; an integer for a single element."""


@dataclass(frozen=True)
class Field:
    """Description of a field of a scene."""

    name: str
    """Name in the scene, such as "positions"; for a system it begins with the path of the system."""
    unit: str
    """Unit of the SI."""
    element: Element
    """Element that has a value."""
    shape: tuple[int, ...] = ()
    """Shape of the array in a scene."""
    part: str = ""
    """Name in the results of one item."""
    value: Value = "number"
    """Kind of a value."""
    integral: str | None = None
    """Name of the engine's time integral of the field, or None. Frames have the mean since the frame before."""
    owner: str | None = None
    """Description of the bodies that have the field, for messages; None: any body."""
    settable: bool = False
    """Whether users may replace the field."""
    source: str = ""
    """Name in the engine."""
    dimensions: tuple[int, ...] = (1, 2, 3)
    """Dimensions of space in which the field exists."""

    def __post_init__(self) -> None:
        for name in ("part", "source"):
            if not getattr(self, name):
                object.__setattr__(self, name, self.name)

    def sized(self, count: int, dimension: int) -> Self:
        """The field of a scene with `count` elements, in so many dimensions."""
        rotation = () if dimension == 2 else (3,)
        components = {"number": (), "vector": (dimension,), "rotation": rotation, "quaternion": (4,)}
        return replace(self, shape=(count, *components[self.value]))


# To add a field of matter: a line here, and its counterpart in Rust. Fields of a system stand in its class.
MATTER = (
    Field("positions", "m", "particles", value="vector", settable=True),
    Field("velocities", "m/s", "particles", value="vector", settable=True),
    Field(
        "rigid_positions",
        "m",
        "rigid bodies",
        part="positions",
        value="vector",
        settable=True,
        source="positions",
    ),
    Field(
        "rigid_velocities",
        "m/s",
        "rigid bodies",
        part="velocities",
        value="vector",
        settable=True,
        source="velocities",
    ),
    Field("angles", "rad", "rigid bodies", settable=True, owner="rigid bodies in 2D have", dimensions=(2,)),
    Field(
        "orientations",
        "1",
        "rigid bodies",
        value="quaternion",
        settable=True,
        owner="rigid bodies in 3D have",
        dimensions=(3,),
    ),
    Field("angular_velocities", "rad/s", "rigid bodies", value="rotation", settable=True, owner="rigid bodies have"),
    Field("asleep", "1", "rigid bodies", owner="rigid bodies with sleep= have"),
    Field("joint_forces", "N", "joints", part="force", value="vector"),
    Field("joint_torques", "N·m", "joints", part="torque", value="rotation"),
    Field("tie_forces", "N", "ties", part="force", value="vector"),
    Field("tie_torques", "N·m", "ties", part="torque", value="rotation"),
    Field("densities", "kg/m³", "fluid particles", owner="a Fluid has"),
    Field("pressures", "Pa", "fluid particles", owner="a Fluid has"),
    Field("wall_forces", "N", "walls", part="force", value="vector", integral="wall_impulses"),
    Field("probe_pressures", "Pa", "probes", part="pressure", integral="probe_impulses"),
    Field("tensions", "N", "springs", owner="networks with rods under RATTLE() have"),
    Field("broken", "1", "springs", owner="networks with a breaking_strain have"),
    Field("wire_forces", "N", "beads", part="force", value="vector"),
)
"""All fields of matter, in the order of results."""

FIELDS = {field.name: field for field in MATTER}
"""Fields of bodies, probes and boundaries by name."""
GAUGES = {field.name: field.integral for field in MATTER if field.integral is not None}
"""Fields of boundaries and bodies that fluids press on, and of probes, with the names of their time integrals."""
MOTION = tuple(field.name for field in MATTER if field.element == "particles")
"""Names of the fields of all particles."""
RIGID = tuple(field.name for field in MATTER if field.element == "rigid bodies" and field.settable)
"""Names of the fields of the state of rigid bodies."""
FLOW = tuple(field.name for field in MATTER if field.element == "fluid particles")
"""Names of the additional fields of fluids."""
