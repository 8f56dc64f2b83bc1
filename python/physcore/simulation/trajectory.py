"""Trajectories: recorded fields of a whole scene, or of one item, over time."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from physcore.checks import BoolArray, FloatArray, word
from physcore.errors import SceneError
from physcore.scene.contents import ItemKey
from physcore.scene.fields import FIELDS, MATTER, MOTION, RIGID
from physcore.scene.scene import Scene
from physcore.simulation.diagrams import over_time
from physcore.simulation.tables import data_frame
from physcore.spelling import UnknownKey, did_you_mean
from physcore.storage.schema import Rule, Sizes
from physcore.units.systems import SI, UnitSystem

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

UNITS = {field.part: field.unit for field in MATTER if field.unit != "1"}
"""Units of channels, as they are called in the results of an item."""
COMPONENTS = dict.fromkeys((*MOTION, *RIGID), "xyz") | {"orientations": "wxyz"}
"""Names of the components of a value, by channel."""


def channel_rules(scene: Scene, sizes: Sizes, over: str) -> dict[str, Rule]:
    """The rules for the recorded fields of a scene in a file, by name; their first axis is `over`."""
    rules: dict[str, Rule] = {}
    for name, each in scene.fields.items():
        axes = tuple(f"{name}, axis {axis}" for axis in range(len(each.shape)))
        sizes.update(zip(axes, each.shape, strict=True))
        # Particles of other bodies have the density NaN.
        rules[name] = sizes.array(over, *axes, finite=each.element != "fluid particles")
    return rules


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """Recorded fields of a whole scene or of one item over time."""

    times: FloatArray
    """Time of each frame [s], shape (F,)."""
    channels: dict[str, FloatArray]
    """Channels by name: vectors have the shape (F, N, D), numbers (F, N)."""
    units: UnitSystem = field(default=SI, kw_only=True)
    """Units of all numbers."""

    @property
    def positions(self) -> FloatArray:
        """Positions [m], shape (F, N, D); within the periodic domain. Of a whole recording: of all particles, without
        rigid bodies.
        """
        return self._channel("positions")

    @property
    def velocities(self) -> FloatArray:
        """Velocities [m/s], shape (F, N, D)."""
        return self._channel("velocities")

    @property
    def angles(self) -> FloatArray:
        """Angles of rigid bodies in 2D [rad], shape (F, B)."""
        return self._channel("angles")

    @property
    def orientations(self) -> FloatArray:
        """Orientations of rigid bodies in 3D, unit quaternions (w, x, y, z), shape (F, B, 4)."""
        return self._channel("orientations")

    @property
    def angular_velocities(self) -> FloatArray:
        """Angular velocities of rigid bodies [rad/s], shape (F, B) in 2D and (F, B, 3) in 3D."""
        return self._channel("angular_velocities")

    @property
    def asleep(self) -> BoolArray:
        """Mask of the rigid bodies that sleep, shape (F, B); only with `sleep=`."""
        return np.not_equal(self._channel("asleep"), 0.0)

    @property
    def densities(self) -> FloatArray:
        """Mass densities [kg/m³], shape (F, N); NaN for particles that do not belong to a fluid."""
        return self._channel("densities")

    @property
    def pressures(self) -> FloatArray:
        """Pressures [Pa], shape (F, N); NaN for particles that do not belong to a fluid."""
        return self._channel("pressures")

    @property
    def tensions(self) -> FloatArray:
        """Tensions of the springs of networks with rods [N], shape (F, S), in the order of `pairs`; positive is
        attractive.
        """
        return self._channel("tensions")

    @property
    def broken(self) -> BoolArray:
        """Mask of the broken springs of networks that can tear, shape (F, S), in the order of `pairs`."""
        return np.not_equal(self._channel("broken"), 0.0)

    def to_dataframe(self) -> DataFrame:
        """Convert to a pandas data frame (`pip install "physcore[pandas]"`), with a row for each particle at each time.

            table = recording["balls"].to_dataframe()
            table[table.particle == 0].plot("time", "y")

        Returns:
            DataFrame: the columns are time [s], particle (its index), x, y and z [m], vx, vy and vz [m/s], and the
                other
            channels of particles, as far as they were recorded. For a whole recording there is also body, its name or
            its index.

        Raises:
            PhyscoreError: pandas is not installed.
            SceneError: there are no particles, or the table would not fit into memory.
        """
        return data_frame(self.times, self.channels)

    def plot(self, channel: str = "positions", axes: Axes | None = None) -> Axes:
        """Plot a channel over time with Matplotlib (`pip install "physcore[plot]"`).

        The plot has the mean of each component, and a band from the smallest to the largest value.

        Args:
            channel: the channel, such as "positions" or "velocities".
            axes: the axes to draw into; a new figure by default.

        Raises:
            PhyscoreError: Matplotlib is not installed.
            SceneError: there is no such channel.
        """
        name = word(channel, "plot.channel", self.channels)
        values = self.channels[name]
        flat = values if values.ndim == 3 and name in COMPONENTS else values.reshape(len(values), -1, 1)
        label = self.units.label(name, UNITS[name]) if name in UNITS else name
        components = COMPONENTS.get(name, "x")[: flat.shape[2]]
        return over_time(self.times, flat, components, label, axes, self.units)

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in self.channels.items())
        return f"{type(self).__name__}({len(self)} frames: {shapes or 'nothing'})"

    def __getattr__(self, name: str) -> FloatArray:
        """A field of a system over time, such as `recording[wave].displacement`."""
        channels = self.__dict__.get("channels", {})
        if name not in channels:
            known = () if name.startswith("_") else (*channels, *(each for each in dir(self) if each[0] != "_"))
            raise AttributeError(f"no field {name!r}: there are {', '.join(channels)}{did_you_mean(name, known)}")
        values: FloatArray = channels[name]
        return values

    def __getitem__(self, name: str) -> FloatArray:
        """A field over time by name, such as `recording[item]["u"]`."""
        if name not in self.channels:
            hint = did_you_mean(name, self.channels)
            raise UnknownKey(f"no field {name!r}: there are {', '.join(self.channels)}{hint}")
        return self.channels[name]

    def _channel(self, name: str) -> FloatArray:
        if name not in self.channels:
            owner = FIELDS[name].owner if name in FIELDS else None
            whose = "" if owner is None else f"; only {owner} them"
            raise SceneError(f"channels: {name} were not recorded; ask for them with channels=({name!r}, …){whose}")
        return self.channels[name]

    def _part(self, scene: Scene, item: ItemKey) -> Trajectory:
        """The part of one item, in the trajectory of a whole scene.

        Raises:
            KeyError: there is no such item.
        """
        return Trajectory(self.times, self._fields(scene, item), units=self.units)

    def _fields(self, scene: Scene, item: ItemKey) -> dict[str, FloatArray]:
        """The channels of one item by name."""
        parts = scene.parts(item)
        for channel, rows in parts.values():
            if len(parts) == 1 and isinstance(rows, int):
                self._channel(channel)  # A gauge has nothing else.
        own = {name: self.channels[each][:, rows] for name, (each, rows) in parts.items() if each in self.channels}
        return scene.results(item, own)
