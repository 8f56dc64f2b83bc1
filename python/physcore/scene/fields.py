"""Table of the fields of bodies, probes and boundaries, and the description of a field."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, Self, TypeAlias

Element: TypeAlias = Literal["particles", "fluid particles", "springs", "beads", "walls", "probes", "cells", "points"]
"""Elements that have a value each. Arrays over "fluid particles" have a row for every particle; walls are all
boundaries, followed by all bodies.
"""
Rows: TypeAlias = slice | int
"""Rows of a field that belong to an item; an integer for a single element."""


@dataclass(frozen=True)
class Field:
    """Description of a field of a scene."""

    name: str
    """Name in the engine, such as "positions"; for a system it begins with the path of the system."""
    unit: str
    """Unit of the SI."""
    element: Element
    """Element that has a value."""
    shape: tuple[int, ...] = ()
    """Shape of the array in a scene."""
    part: str = ""
    """Name in the results of one item."""
    vector: bool = False
    """Whether a value has a component for each dimension of space."""
    integral: str | None = None
    """Name of the engine's time integral of the field, or None. Frames have the mean since the frame before."""
    owner: str | None = None
    """Description of the bodies that have the field, for messages; None: any body."""
    settable: bool = False
    """Whether users may replace the field."""

    def __post_init__(self) -> None:
        if not self.part:
            object.__setattr__(self, "part", self.name)

    def sized(self, count: int, dimension: int) -> Self:
        """The field of a scene with `count` elements, in so many dimensions."""
        return replace(self, shape=(count, dimension) if self.vector else (count,))


# To add a field of matter: a line here, and its counterpart in Rust. Fields of a system stand in its class.
MATTER = (
    Field("positions", "m", "particles", vector=True, settable=True),
    Field("velocities", "m/s", "particles", vector=True, settable=True),
    Field("densities", "kg/m³", "fluid particles", owner="a Fluid has"),
    Field("pressures", "Pa", "fluid particles", owner="a Fluid has"),
    Field("wall_forces", "N", "walls", part="force", vector=True, integral="wall_impulses"),
    Field("probe_pressures", "Pa", "probes", part="pressure", integral="probe_impulses"),
    Field("tensions", "N", "springs", owner="networks with rods have"),
    Field("broken", "1", "springs", owner="networks with a breaking_strain have"),
    Field("wire_forces", "N", "beads", part="force", vector=True),
)
"""All fields of matter, in the order of results."""

FIELDS = {field.name: field for field in MATTER}
"""Fields of bodies, probes and boundaries by name."""
GAUGES = {field.name: field.integral for field in MATTER if field.integral is not None}
"""Fields of boundaries and bodies that fluids press on, and of probes, with the names of their time integrals."""
MOTION = tuple(field.name for field in MATTER if field.element == "particles")
"""Names of the fields of all particles."""
FLOW = tuple(field.name for field in MATTER if field.element == "fluid particles")
"""Names of the additional fields of fluids."""
