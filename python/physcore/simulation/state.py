"""The state of a scene at one time: its fields by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from physcore.checks import BoolArray, FloatArray
from physcore.errors import SceneError
from physcore.scene.channels import OWNERS, body_fields, body_gauges, gauge
from physcore.scene.scene import BodyKey, ItemKey, Scene
from physcore.simulation.energy import Amount, Energy


@dataclass(frozen=True)
class FieldInfo:
    """A quantity that a system of the scene has: of each particle, or of each cell."""

    name: str
    """"positions"; of a system beside the particles after the name of its item."""
    unit: str
    """Its SI unit."""
    shape: tuple[int, ...]
    """The shape of its array."""
    rate: str | None
    """The name of the field that is its rate of change, if there is one."""
    state: bool
    """Whether it is a part of the state, and does not follow from the others."""


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The fields of a scene, or of one body, at one time; the arrays are copies.

        for snapshot in pc.Simulation(scene).frames(duration=0.1):  # a Frame is a Snapshot with its audit
            print(snapshot.time, snapshot["cloth"].positions)

    `SimulationDiverged.last_good` is one, and every Frame.
    """

    time: float
    """[s]"""
    fields: Mapping[str, FloatArray]
    """The fields by name."""
    scene: Scene | None = field(default=None, kw_only=True, repr=False)
    """The scene, where this is the state of all of it."""

    def __getitem__(self, key: ItemKey) -> Any:
        """A field by its name, such as `simulation[item]["u"]`; or of a whole scene the part of an item, a Snapshot."""
        if isinstance(key, str) and key in self.fields:
            return self.fields[key]
        if self.scene is None:
            raise KeyError(f"no field {key!r}: there are {', '.join(self.fields)}")
        path = self.scene.system(key)
        if path is not None:
            own = {name: values for name, values in self.fields.items() if name.startswith(f"{path}.")}
            shown = next(each for each in self.scene.systems if self.scene.system(each) == path).shown
            return Snapshot(self.time, shown({name.removeprefix(f"{path}."): values for name, values in own.items()}))
        measured = gauge(self.scene, key)
        if measured is not None:
            return Snapshot(self.time, {measured[0]: self.fields[measured[1]][measured[2]]})
        body = cast("BodyKey", key)
        own = {
            name: self.fields[name][part] for name, part in body_fields(self.scene, body).items() if name in self.fields
        }
        own |= {name: self.fields[field][row] for name, (field, row) in body_gauges(self.scene, body).items()}
        return Snapshot(self.time, own)

    @property
    def positions(self) -> FloatArray:
        """[m], shape (N, D); within the periodic domain."""
        return self._field("positions")

    @property
    def velocities(self) -> FloatArray:
        """[m/s], shape (N, D)."""
        return self._field("velocities")

    @property
    def densities(self) -> FloatArray:
        """[kg/m³], shape (N,); not a number for particles that are not a fluid's."""
        return self._field("densities")

    @property
    def pressures(self) -> FloatArray:
        """[Pa], shape (N,); not a number for particles that are not a fluid's."""
        return self._field("pressures")

    @property
    def tensions(self) -> FloatArray:
        """Of the springs of networks with rods [N], shape (S,), positive where they pull; in the order of `pairs`."""
        return self._field("tensions")

    @property
    def broken(self) -> BoolArray:
        """Which springs are broken, of networks that can tear, shape (S,); in the order of `pairs`."""
        return np.not_equal(self._field("broken"), 0.0)

    def _field(self, name: str) -> FloatArray:
        if name not in self.fields:
            raise SceneError(f"{name}: only {OWNERS[name]} them")
        return self.fields[name]

    def __getattr__(self, name: str) -> FloatArray:
        """A field of a further system, such as `simulation[wave].displacement`."""
        fields = self.__dict__.get("fields", {})
        if name not in fields:
            raise AttributeError(f"no field {name!r}: there are {', '.join(fields)}")
        values: FloatArray = fields[name]
        return values


@dataclass(frozen=True, eq=False)
class Frame(Snapshot):
    """A snapshot at a frame's time, with the audit of the last step at or before it.

        for frame in pc.Simulation(scene).frames(duration=0.1):  # each is a Frame
            print(frame.time, frame.positions.mean(axis=0))

    `Simulation.frames` gives one after the other.
    """

    dt: float
    """The time step in use [s]."""
    energy: Energy
    """The energy budget; `energy.time` is the time of its step."""
    momentum: FloatArray
    """Total momentum [kg·m/s], shape (D,)."""
    angular_momentum: FloatArray
    """Total angular momentum about the origin [kg·m²/s], shape (D (D − 1)/2,): a number in 2D, three in 3D."""
    budgets: Mapping[str, Amount] = field(default_factory=dict)
    """The budgets of what else is conserved, by name."""


@dataclass(frozen=True, eq=False)
class Part(Snapshot):
    """The present state of one item of a running simulation, which can be changed between two steps.

        simulation = pc.Simulation(scene)
        simulation["cloth"].set(velocities=(0.0, 1.0))  # of a Part

    `simulation[item]` gives it.
    """

    replace: Callable[[Mapping[str, Any]], None]
    """Replaces fields by name."""

    def set(self, **values: Any) -> None:
        """Replace fields of this item; the change of energy counts as work. What this part shows stays as it was.

            simulation[wave].set(displacement=lambda x, y: np.exp(-(x**2) - y**2))

        Args:
            values: by the names of fields: numbers, arrays of their shapes, and on grids functions of the coordinates.

        Raises:
            SceneError: there is no such field, or it follows from others; or the values are none of its shape.
        """
        self.replace(values)
