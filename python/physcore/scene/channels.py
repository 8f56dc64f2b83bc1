"""The fields that a scene has, by name, and the part of each that belongs to a body."""

from __future__ import annotations

from physcore.scene.bodies import SpringNetwork
from physcore.scene.fluid import Fluid
from physcore.scene.scene import BodyKey, Scene

CHANNELS = ("positions", "velocities")
"""The fields of all particles."""
FLUID_CHANNELS = ("densities", "pressures")
"""The fields that fluids have beside."""
SPRING_CHANNELS = ("tensions", "broken")
"""The fields of springs: tensions in scenes with rods, broken springs where springs can break."""

OWNERS = {
    **dict.fromkeys(FLUID_CHANNELS, "a Fluid has"),
    "tensions": "networks with rods have",
    "broken": "networks with a breaking_strain have",
}
"""The bodies that have a field, in words."""


def field_names(scene: Scene) -> tuple[str, ...]:
    """The names of the fields that a scene has; positions and velocities always, if only of no particles."""
    fluids = FLUID_CHANNELS if scene.fluids else ()
    return (*CHANNELS, *fluids, *spring_channels(scene), *system_shapes(scene))


def system_shapes(scene: Scene) -> dict[str, tuple[int, ...]]:
    """The shapes of the fields of further systems."""
    shapes = (
        (scene.system(system), name, shape) for system in scene.systems for name, shape in system.shapes().items()
    )
    return {f"{system}.{name}": shape for system, name, shape in shapes}


def body_fields(scene: Scene, body: BodyKey) -> dict[str, slice]:
    """The fields of one of its bodies, and where in each its elements are: particles, or springs."""
    index = scene.index(body)
    found = scene.bodies[index]
    names = (*CHANNELS, *FLUID_CHANNELS) if isinstance(found, Fluid) else CHANNELS
    fields = dict.fromkeys(names, scene.slice(body))
    if isinstance(found, SpringNetwork):
        start = first_spring(scene, found)
        fields |= dict.fromkeys(spring_channels(scene), slice(start, start + len(found.pairs)))
    return fields


def first_spring(scene: Scene, body: SpringNetwork) -> int:
    """The index of a body's first spring among those of the scene."""
    return springs(scene, scene.index(body))


def spring_channels(scene: Scene) -> tuple[str, ...]:
    """The fields that the springs of a scene have."""
    has = {"tensions": has_rods(scene), "broken": can_tear(scene)}
    return tuple(name for name in SPRING_CHANNELS if has[name])


def can_tear(scene: Scene) -> bool:
    """Whether a spring of a scene can break."""
    return any(isinstance(body, SpringNetwork) and body.can_tear for body in scene.bodies)


def has_rods(scene: Scene) -> bool:
    """Whether a spring network of a scene has rods that are free to move at one end at least."""
    return any(isinstance(body, SpringNetwork) and body.rods.any() for body in scene.bodies)


def springs(scene: Scene, bodies: int | None = None) -> int:
    """The number of springs of a scene, or of its first bodies."""
    return sum(len(body.pairs) for body in scene.bodies[:bodies] if isinstance(body, SpringNetwork))
