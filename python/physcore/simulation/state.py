"""State of a scene at one time: its fields by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from physcore.checks import BoolArray, FloatArray
from physcore.errors import SceneError
from physcore.scene.contents import ItemKey
from physcore.scene.fields import FIELDS
from physcore.scene.scene import Scene
from physcore.simulation.energy import Amount, Energy
from physcore.spelling import UnknownKey, did_you_mean


@dataclass(frozen=True)
class FieldInfo:
    """Description of a field: a quantity of each particle or of each cell."""

    name: str
    """Name, such as "positions"; for a system it begins with the path of the system."""
    unit: str
    """Unit, in those of the scene."""
    shape: tuple[int, ...]
    """Shape of the array."""
    rate: str | None
    """Name of the field that is its rate of change, or None."""
    state: bool
    """Whether the field is part of the state, as opposed to derived fields."""


@dataclass(frozen=True, eq=False, repr=False)
class Snapshot:
    """Snapshot of the fields of a scene, or of one item, at one time. The arrays are copies.

        for snapshot in pc.Simulation(scene).frames(duration=0.1):  # a Frame is a Snapshot with its audit
            print(snapshot.time, snapshot["cloth"].positions)

    `SimulationDiverged.last_good` is a Snapshot, and so is every Frame.
    """

    time: float
    """Time [s]."""
    fields: Mapping[str, FloatArray]
    """Fields by name."""
    scene: Scene | None = field(default=None, kw_only=True, repr=False)
    """Scene, if the snapshot is of the whole scene."""

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {np.shape(values)}" for name, values in self.fields.items())
        return f"{type(self).__name__}({self.time:g} s: {shapes})"

    def __getitem__(self, key: ItemKey) -> Any:
        """A field by its name, such as `simulation[item]["u"]`; for a whole scene also the Snapshot of an item."""
        if isinstance(key, str) and key in self.fields:
            return self.fields[key]
        if self.scene is None:
            hint = did_you_mean(key, self.fields)
            raise UnknownKey(f"no field {key!r}: there are {', '.join(self.fields)}{hint}")
        parts = self.scene.parts(key).items()
        own = {name: self.fields[field][rows] for name, (field, rows) in parts if field in self.fields}
        return Snapshot(self.time, self.scene.results(key, own))

    @property
    def positions(self) -> FloatArray:
        """Positions [m], shape (N, D); within the periodic domain. Of a whole scene: of all particles, without rigid
        bodies.
        """
        return self._field("positions")

    @property
    def velocities(self) -> FloatArray:
        """Velocities [m/s], shape (N, D)."""
        return self._field("velocities")

    @property
    def angles(self) -> FloatArray:
        """Angles of rigid bodies in 2D [rad], shape (B,)."""
        return self._field("angles")

    @property
    def orientations(self) -> FloatArray:
        """Orientations of rigid bodies in 3D, unit quaternions (w, x, y, z), shape (B, 4)."""
        return self._field("orientations")

    @property
    def angular_velocities(self) -> FloatArray:
        """Angular velocities of rigid bodies [rad/s], shape (B,) in 2D and (B, 3) in 3D."""
        return self._field("angular_velocities")

    @property
    def asleep(self) -> BoolArray:
        """Mask of the rigid bodies that sleep, shape (B,); only with `sleep=`."""
        return np.not_equal(self._field("asleep"), 0.0)

    @property
    def densities(self) -> FloatArray:
        """Mass densities [kg/m³], shape (N,); NaN for particles that do not belong to a fluid."""
        return self._field("densities")

    @property
    def pressures(self) -> FloatArray:
        """Pressures [Pa], shape (N,); NaN for particles that do not belong to a fluid."""
        return self._field("pressures")

    @property
    def tensions(self) -> FloatArray:
        """Tensions of the springs of networks with rods [N], shape (S,), in the order of `pairs`; positive is
        attractive.
        """
        return self._field("tensions")

    @property
    def broken(self) -> BoolArray:
        """Mask of the broken springs of networks that can tear, shape (S,), in the order of `pairs`."""
        return np.not_equal(self._field("broken"), 0.0)

    def _field(self, name: str) -> FloatArray:
        if name not in self.fields:
            raise SceneError(f"{name}: only {FIELDS[name].owner} them")
        return self.fields[name]

    def __getattr__(self, name: str) -> FloatArray:
        """A field of a system, such as `simulation[wave].displacement`."""
        fields = self.__dict__.get("fields", {})
        if name not in fields:
            known = () if name.startswith("_") else (*fields, *(each for each in dir(self) if each[0] != "_"))
            raise AttributeError(f"no field {name!r}: there are {', '.join(fields)}{did_you_mean(name, known)}")
        values: FloatArray = fields[name]
        return values


@dataclass(frozen=True, eq=False, repr=False)
class Frame(Snapshot):
    """Snapshot at the time of a frame, with the budgets of the last step at or before it.

        for frame in pc.Simulation(scene).frames(duration=0.1):  # each is a Frame
            print(frame.time, frame.positions.mean(axis=0))

    `Simulation.frames` yields the frames in order.
    """

    dt: float
    """Present time step [s]."""
    energy: Energy
    """Energy budget; `energy.time` is the time of its step."""
    momentum: FloatArray
    """Total momentum [kg·m/s], shape (D,)."""
    angular_momentum: FloatArray
    """Total angular momentum about the origin [kg·m²/s], shape (D (D − 1)/2,): a number in 2D, three in 3D."""
    budgets: Mapping[str, Amount] = field(default_factory=dict)
    """Budgets of other conserved quantities, by name."""


@dataclass(frozen=True, eq=False, repr=False)
class Part(Snapshot):
    """Present state of one item of a simulation, which can be modified between two steps.

        simulation = pc.Simulation(scene)
        simulation["cloth"].set(velocities=(0.0, 1.0))  # of a Part

    `simulation[item]` returns it.
    """

    replace: Callable[[Mapping[str, Any]], None]
    """Function that replaces fields by name."""

    def set(self, **values: Any) -> None:
        """Replace fields of this item. The change of energy counts as work. This Part itself remains unchanged.

            simulation[wave].set(displacement=lambda x, y: np.exp(-(x**2) - y**2))

        Args:
            values: new values by field: numbers, arrays of the field's shape, or on grids functions of the coordinates.

        Raises:
            SceneError: there is no such field, the field is derived from others, or the values do not have its shape.
        """
        self.replace(values)

    def __getstate__(self) -> dict[str, Any]:
        """The state without its simulation, which is not copied."""
        return {**self.__dict__, "replace": _detached}


def _detached(values: Mapping[str, Any]) -> None:
    """Refuse to modify a copied or unpickled part."""
    del values
    raise SceneError("set: this Part is a copy and belongs to no simulation; take simulation[item]")
