"""State of a run, which studies compare, perturb and restore: the primary field of every item of a scene.

All particles are one item, and all rigid bodies are another one. The primary field of both is their positions; further
systems name theirs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from physcore.arithmetic import lengths
from physcore.checks import FloatArray
from physcore.scene.bodies import Body
from physcore.scene.fields import RIGID
from physcore.scene.scene import Scene
from physcore.scene.system import System
from physcore.simulation.simulation import Simulation

State = Mapping[str | Body | None, Mapping[str, FloatArray]]
"""Fields of each system by name, by path of the system; likewise of each body of rigid bodies; the key None is for the
particles.
"""


@dataclass(frozen=True)
class Primary:
    """Primary field of an item of a scene, and the field that changes it."""

    scene: Scene
    system: System | None
    """The item; None: all particles, or all rigid bodies."""
    rigid: bool = False
    """Whether the item is all rigid bodies."""

    @property
    def channel(self) -> str:
        """Name of the field in recordings."""
        if self.system is None:
            return "rigid_positions" if self.rigid else "positions"
        return f"{self.scene.system(self.system)}.{self.system.primary}"

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
            return self._gathered(simulation, "positions") if self.rigid else simulation.positions
        return simulation[self.system].fields[self.system.primary]

    def rates(self, simulation: Simulation) -> FloatArray:
        """The present velocities of bodies; of a system the second field of its state, or the only one."""
        if self.system is None:
            return self._gathered(simulation, "velocities") if self.rigid else simulation.velocities
        return simulation[self.system].fields[self.system.changing]

    def nudge(self, simulation: Simulation, size: float, random: np.random.Generator) -> None:
        """Perturb free velocities or rates by normal deviates of standard deviation `size`."""
        values = self.rates(simulation)
        if self.system is None:
            bodies = self._bodies
            free = ~np.concatenate([body.fixed for body in bodies]) if bodies else np.empty(0, dtype=bool)
            values[free] += size * random.normal(size=values[free].shape)
            parts = np.split(values, np.cumsum([len(body) for body in bodies])[:-1])
            simulation.set(velocities=dict(zip(bodies, parts, strict=False)))
        else:
            simulation[self.system].set(**{self.system.changing: values + size * random.normal(size=values.shape)})

    @property
    def _bodies(self) -> tuple[Body, ...]:
        """The bodies of the item, if it is no system."""
        return tuple(body for body in self.scene.bodies if body.is_rigid == self.rigid)

    def _gathered(self, simulation: Simulation, name: str) -> FloatArray:
        """A field of all bodies of the item."""
        return np.concatenate([simulation[body].fields[name] for body in self._bodies])

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
    bodies = [
        Primary(scene, None, rigid)
        for rigid in (False, True)
        if any(body.is_rigid == rigid and not body.fixed.all() for body in scene.bodies)
    ]
    if not (bodies or systems):
        bodies = [Primary(scene, None, scene.has_rigid_bodies and not scene.particles)]
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
    found: dict[str | Body | None, Mapping[str, FloatArray]] = {
        path: {name: simulation[path].fields[name] for name in system.shapes() if name not in system.derived}
        for path, system in scene.systems_by_path.items()
    }
    if scene.bodies:
        found[None] = {"positions": simulation.positions, "velocities": simulation.velocities}
    for body in scene.bodies:
        if body.is_rigid:
            parts = scene.parts(body).items()
            found[body] = {part: simulation[body].fields[part] for part, (field, _) in parts if field in RIGID}
    return found


def restore(simulation: Simulation, wanted: State) -> None:
    """Set a run to a state."""
    for path, fields in wanted.items():
        values: Mapping[str, Any] = fields
        if path is None:
            simulation.set(**values)
        else:
            simulation[path].set(**values)
