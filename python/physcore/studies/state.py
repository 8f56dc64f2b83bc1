"""State of a run, which studies compare, perturb and restore: the primary field of every item of a scene.

All bodies are one item, whose primary field is their positions; further systems name theirs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from physcore.arithmetic import lengths
from physcore.checks import FloatArray
from physcore.scene.items import System
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation

State = Mapping[str | None, Mapping[str, FloatArray]]
"""Fields of each system by name, by path of the system; the key None is for the particles."""


@dataclass(frozen=True)
class Primary:
    """Primary field of an item of a scene, and the field that changes it."""

    scene: Scene
    system: System | None
    """The item; None: all bodies."""

    @property
    def channel(self) -> str:
        """Name of the field in recordings."""
        return "positions" if self.system is None else f"{self.scene.system(self.system)}.{self.system.primary}"

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the field."""
        return self.scene.fields[self.channel].shape

    @property
    def suffix(self) -> str:
        """The unit as it follows a number."""
        return self.scene.units.suffix(self.scene.fields[self.channel].unit)

    @property
    def components(self) -> int:
        """The number of values that are compared together: the components of a particle's position."""
        return self.scene.dimension if self.system is None else 1

    def values(self, simulation: Simulation) -> FloatArray:
        """The present values."""
        if self.system is None:
            return simulation.positions
        return simulation[self.system].fields[self.system.primary]

    def rates(self, simulation: Simulation) -> FloatArray:
        """The present velocities of particles; of a system the second field of its state, or the only one."""
        if self.system is None:
            return simulation.velocities
        return simulation[self.system].fields[self.system.changing]

    def nudge(self, simulation: Simulation, size: float, random: np.random.Generator) -> None:
        """Perturb free velocities or rates by normal deviates of standard deviation `size`."""
        values = self.rates(simulation)
        if self.system is None:
            free = np.concatenate([~body.fixed for body in self.scene.bodies])
            values[free] += size * random.normal(size=values[free].shape)
            simulation.set(velocities=values)
        else:
            simulation[self.system].set(**{self.system.changing: values + size * random.normal(size=values.shape)})

    def difference(self, one: FloatArray, other: FloatArray) -> FloatArray:
        """The difference one − other; for positions in a periodic domain, the displacement to the nearest image."""
        change: FloatArray = one - other
        domain = self.scene.periodic if self.system is None else None
        return change if domain is None else domain.nearest(change)

    def distances(self, change: FloatArray) -> FloatArray:
        """The largest distance of any particle, or of any value, at each time, from differences; shape (F,)."""
        sizes = lengths(change) if self.system is None else np.abs(change)
        largest: FloatArray = sizes.reshape(len(sizes), -1).max(axis=1)
        return largest


def compared(scene: Scene) -> tuple[Primary, ...]:
    """The primary fields of all items. Bodies without a free particle, and empty systems, are left out if there are
    others.
    """
    systems = [system for system in scene.systems if sum(system.elements.values())] or scene.systems
    free = any(not body.fixed.all() for body in scene.bodies)
    bodies = [Primary(scene, None)] if free or not systems else []
    return (*bodies, *(Primary(scene, system) for system in systems))


def size(scene: Scene) -> int:
    """The number of compared values."""
    return sum(int(np.prod(each.shape)) for each in compared(scene))


def nudge(simulation: Simulation, sizes: Sequence[float], seed: int) -> None:
    """Perturb every compared item by deviates of the given size each."""
    random = np.random.default_rng(seed)
    for each, own in zip(compared(simulation.scene), sizes, strict=True):
        each.nudge(simulation, own, random)


def state(simulation: Simulation) -> State:
    """All fields that a run can be set to."""
    scene = simulation.scene
    found: dict[str | None, Mapping[str, FloatArray]] = {
        path: {name: simulation[path].fields[name] for name in system.shapes() if name not in system.derived}
        for path, system in scene.systems_by_path.items()
    }
    if scene.bodies:
        found[None] = {"positions": simulation.positions, "velocities": simulation.velocities}
    return found


def restore(simulation: Simulation, wanted: State) -> None:
    """Set a run to a state."""
    for path, fields in wanted.items():
        values: Mapping[str, Any] = fields
        if path is None:
            simulation.set(**values)
        else:
            simulation[path].set(**values)
