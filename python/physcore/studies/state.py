"""State of a run, which studies compare, perturb and restore: of the particles, or of the first system if there are
none.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from physcore.checks import FloatArray
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation

State = Mapping[str | None, Mapping[str, FloatArray]]
"""Fields of each system by name, by path of the system; the key None is for the particles."""


def primary(scene: Scene) -> str:
    """The compared channel: the positions of particles, or otherwise the first field of the first system."""
    if scene.bodies:
        return "positions"
    system = scene.systems[0]
    return f"{scene.system(system)}.{next(iter(system.shapes()))}"


def suffix(scene: Scene) -> str:
    """The unit of the compared channel as it follows a number."""
    return scene.units.suffix("m" if scene.bodies else next(iter(scene.systems[0].units.values()), "1"))


def size(scene: Scene) -> int:
    """The number of values in the compared channel."""
    if scene.bodies:
        return scene.particles * scene.dimension
    return int(np.prod(next(iter(scene.systems[0].shapes().values()))))


def place(simulation: Simulation) -> FloatArray:
    """The present values of the compared channel."""
    scene = simulation.scene
    if scene.bodies:
        return simulation.positions
    return next(iter(simulation[scene.systems[0]].fields.values()))


def motion(simulation: Simulation) -> FloatArray:
    """The rate of change of the compared channel: velocities of particles, or otherwise the second field of the first
    system. For an equation of first order with a single field, this field itself.
    """
    scene = simulation.scene
    if scene.bodies:
        return simulation.velocities
    return simulation[scene.systems[0]].fields[_changing(scene)]


def state(simulation: Simulation) -> State:
    """All fields that a run can be set to."""
    scene = simulation.scene
    found: dict[str | None, Mapping[str, FloatArray]] = {
        scene.system(system): {
            name: values for name, values in simulation[system].fields.items() if name not in system.derived
        }
        for system in scene.systems
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


def nudge(simulation: Simulation, size: float, seed: int) -> None:
    """Perturb the free velocities or rates by normal deviates of standard deviation `size`."""
    scene, rng = simulation.scene, np.random.default_rng(seed)
    if scene.bodies:
        velocities = simulation.velocities
        free = np.concatenate([~body.fixed for body in scene.bodies])
        velocities[free] += size * rng.normal(size=velocities[free].shape)
        simulation.set(velocities=velocities)
        return
    values = motion(simulation)
    simulation[scene.systems[0]].set(**{_changing(scene): values + size * rng.normal(size=values.shape)})


def _changing(scene: Scene) -> str:
    """The second field of the state of the first system, or the only one."""
    system = scene.systems[0]
    return [name for name in system.shapes() if name not in system.derived][:2][-1]
