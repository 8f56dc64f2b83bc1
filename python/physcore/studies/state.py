"""The state of a run as studies compare, nudge and restore it: of the particles, or of the first system without any."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from physcore.checks import FloatArray
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation

State = Mapping[str | None, Mapping[str, FloatArray]]
"""The fields of each system by name, by its path; None for those of the particles."""


def primary(scene: Scene) -> str:
    """The channel that is compared: the positions of particles, or else the first field of the first system."""
    if scene.bodies:
        return "positions"
    system = scene.systems[0]
    return f"{scene.system(system)}.{next(iter(system.shapes()))}"


def unit(scene: Scene) -> str:
    """The unit of that."""
    return "m" if scene.bodies else next(iter(scene.systems[0].units.values()), "1")


def size(scene: Scene) -> int:
    """How many numbers that has."""
    if scene.bodies:
        return scene.particles * scene.dimension
    return int(np.prod(next(iter(scene.systems[0].shapes().values()))))


def place(simulation: Simulation) -> FloatArray:
    """What is compared, at present."""
    scene = simulation.scene
    if scene.bodies:
        return simulation.positions
    return next(iter(simulation[scene.systems[0]].fields.values()))


def motion(simulation: Simulation) -> FloatArray:
    """How it changes: the velocities of particles, or the second field of the first system; the first where it is the
    only one, as in an equation of first order.
    """
    scene = simulation.scene
    if scene.bodies:
        return simulation.velocities
    return simulation[scene.systems[0]].fields[_changing(scene)]


def state(simulation: Simulation) -> State:
    """Everything that a run can be set to."""
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
    """Add one normal deviate of `size` to each number of what changes, where nothing is fixed."""
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
    """The second field of the state of the first system; the first where it is the only one."""
    system = scene.systems[0]
    return [name for name in system.shapes() if name not in system.derived][:2][-1]
