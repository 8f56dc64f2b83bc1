"""Primary fields of the items of a scene, by which studies compare and perturb runs.

All particles are one item, whose primary field is their positions. All rigid bodies are another one: their centers, and
points of each at its radius of gyration, which show how they turn. Further systems name theirs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physcore.arithmetic import lengths
from physcore.checks import BoolArray, FloatArray
from physcore.scene.bodies import Body
from physcore.scene.marks import TURNS, gyrations, mark_velocities, marks
from physcore.scene.scene import Scene
from physcore.scene.system import System
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation


@dataclass(frozen=True)
class Primary:
    """Primary field of an item of a scene, and the field that changes it."""

    scene: Scene
    system: System | None = None
    """The item; None: all bodies of one kind."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the recorded fields from which the values follow."""
        if self.system is None:
            return ("positions",)
        return (f"{self.scene.system(self.system)}.{self.system.primary}",)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the values."""
        return self.scene.fields[self.channels[0]].shape

    @property
    def suffix(self) -> str:
        """The unit as it follows a number."""
        return self.scene.units.suffix(self.scene.fields[self.channels[0]].unit)

    @property
    def components(self) -> int:
        """The number of values that are compared together: the components of a position."""
        return self.scene.dimension if self.system is None else 1

    def values(self, simulation: Simulation) -> FloatArray:
        """The present values."""
        if self.system is None:
            return simulation.positions
        return simulation[self.system].fields[self.system.primary]

    def recorded(self, recording: Recording) -> FloatArray:
        """The values in all frames (F, …)."""
        return recording.channels[self.channels[0]]

    def rates(self, simulation: Simulation) -> FloatArray:
        """The present rates of change of the values; of a system the second field of its state, or the only one."""
        if self.system is None:
            return simulation.velocities
        return simulation[self.system].fields[self.system.changing]

    def nudge(self, simulation: Simulation, size: float, random: np.random.Generator) -> None:
        """Perturb free velocities or rates by normal deviates of standard deviation `size`."""
        values = self.rates(simulation)
        if self.system is not None:
            simulation[self.system].set(**{self.system.changing: values + size * random.normal(size=values.shape)})
            return
        bodies = self.scene.particle_bodies
        _shake(values, _free(bodies), size, random)
        simulation.set(velocities=dict(zip(bodies, _parts(values, bodies), strict=True)))

    def difference(self, one: FloatArray, other: FloatArray) -> FloatArray:
        """The difference one − other; for positions in a periodic domain, the displacement to the nearest image."""
        change: FloatArray = one - other
        domain = self.scene.periodic if self.system is None else None
        return change if domain is None else domain.nearest(change)

    def distances(self, change: FloatArray) -> FloatArray:
        """The largest distance of any point, or of any value, at each time, from differences; shape (F,)."""
        sizes = lengths(change) if self.system is None else np.abs(change)
        largest: FloatArray = sizes.reshape(len(sizes), -1).max(axis=1)
        return largest


class RigidPrimary(Primary):
    """Centers and marks of all rigid bodies of a scene, and their velocities.

    Angular velocities are compared as those of the marks, which differ by the angular velocity times the radius of
    gyration.
    """

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the recorded fields from which the marks follow."""
        return ("rigid_positions", TURNS[self.scene.dimension])

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the marks."""
        bodies, dimension = super().shape
        return (bodies * dimension, dimension)

    def values(self, simulation: Simulation) -> FloatArray:
        """The present marks [m]."""
        return marks(self.scene, self._fields(simulation, self.channels))

    def recorded(self, recording: Recording) -> FloatArray:
        """The marks in all frames [m]."""
        return marks(self.scene, recording.channels)

    def rates(self, simulation: Simulation) -> FloatArray:
        """The present velocities of the marks [m/s]."""
        names = ("rigid_velocities", "angular_velocities")
        return mark_velocities(self.scene, self._fields(simulation, (*self.channels, *names)))

    def nudge(self, simulation: Simulation, size: float, random: np.random.Generator) -> None:
        """Perturb free velocities by normal deviates of standard deviation `size`, and angular velocities by such over
        the radii of gyration.
        """
        bodies = self._bodies
        fields = self._fields(simulation, ("rigid_velocities", "angular_velocities"))
        linear, turning = fields["rigid_velocities"], fields["angular_velocities"]
        free, reach = _free(bodies), gyrations(self.scene)
        _shake(linear, free, size, random)
        _shake(turning, free, size / reach.reshape(-1, *(1,) * (turning.ndim - 1)), random)
        parts = zip(bodies, _parts(linear, bodies), _parts(turning, bodies), strict=True)
        for body, own, turn in parts:
            simulation[body].set(velocities=own, angular_velocities=turn)

    @property
    def _bodies(self) -> tuple[Body, ...]:
        """All rigid bodies."""
        return tuple(body for body in self.scene.bodies if body.is_rigid)

    def _fields(self, simulation: Simulation, names: tuple[str, ...]) -> dict[str, FloatArray]:
        """Fields of all rigid bodies."""
        return {
            name: np.concatenate([simulation[body].fields[self.scene.fields[name].part] for body in self._bodies])
            for name in names
        }


def _free(bodies: tuple[Body, ...]) -> BoolArray:
    """Mask of all bodies or particles that are not fixed."""
    return ~np.concatenate([body.fixed for body in bodies]) if bodies else np.empty(0, dtype=bool)


def _parts(values: FloatArray, bodies: tuple[Body, ...]) -> list[FloatArray]:
    """The rows of values of each body."""
    return np.split(values, np.cumsum([len(body) for body in bodies])[:-1]) if bodies else []


def _shake(values: FloatArray, free: BoolArray, size: float | FloatArray, random: np.random.Generator) -> None:
    """Add normal deviates of standard deviation `size` to free rows, in place."""
    sizes = np.broadcast_to(size, values.shape)
    values[free] += sizes[free] * random.normal(size=values[free].shape)
