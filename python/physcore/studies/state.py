"""State of a run, which studies compare, perturb and restore."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from physcore.checks import FloatArray
from physcore.scene.bodies import Body
from physcore.scene.fields import RIGID
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation
from physcore.studies.primary import Primary, RigidPrimary

State = Mapping[str | Body | None, Mapping[str, FloatArray]]
"""Fields of each system by name, by path of the system; likewise of each body of rigid bodies; the key None is for the
particles.
"""


def compared(scene: Scene) -> tuple[Primary, ...]:
    """The primary fields of all items. Bodies without a free particle, and empty systems, are left out if there are
    others.
    """
    systems = [system for system in scene.systems if sum(system.elements.values())] or scene.systems
    bodies: list[Primary] = [
        RigidPrimary(scene) if rigid else Primary(scene)
        for rigid in (False, True)
        if any(body.is_rigid == rigid and not body.fixed.all() for body in scene.bodies)
    ]
    if not (bodies or systems):
        bodies = [RigidPrimary(scene) if scene.has_rigid_bodies and not scene.particles else Primary(scene)]
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


def can_touch(scene: Scene) -> bool:
    """Whether rigid bodies can touch each other or a particle, or reach the limit of a joint, so that their velocities
    jump. Two bodies that are joined do not touch.
    """
    rigid = sum(len(body) for body in scene.bodies if body.is_rigid)
    joints = [each for each in scene.constraints if each.element == "joints"]
    bounded = any(getattr(each, name, None) is not None for each in joints for name in ("lower", "upper"))
    joined = any(getattr(each, "keeps_apart", False) and len(each.targets() or ()) == 2 for each in joints)
    return rigid > 0 and (bounded or rigid + scene.particles > (2 if joined else 1))


def is_whole(scene: Scene) -> bool:
    """Whether `state` is the whole state of a scene. Fluids have densities too, and what can break remembers it.

    The loads of contacts and joints are not in it: they are a first guess of the solver.
    """
    breaks = any(math.isfinite(getattr(each, "breaking_force", math.inf)) for each in scene.constraints)
    return not (scene.fluids or breaks or any(network.can_tear for network in scene.networks))
