"""The fields that a scene has, by name, and the part of each that belongs to a body."""

from __future__ import annotations

from physcore.errors import SceneError
from physcore.scene.bodies import SpringNetwork
from physcore.scene.fluid import Fluid
from physcore.scene.items import Boundary
from physcore.scene.probe import Probe
from physcore.scene.scene import BodyKey, Scene

CHANNELS = ("positions", "velocities")
"""The fields of all particles."""
FLUID_CHANNELS = ("densities", "pressures")
"""The fields that fluids have beside."""
SPRING_CHANNELS = ("tensions", "broken")
"""The fields of springs: tensions in scenes with rods, broken springs where springs can break."""

GAUGES = {"wall_forces": "wall_impulses", "probe_pressures": "probe_impulses"}
"""The fields of what fluids press on, boundaries and bodies, and of probes, with those of their integrals over time."""

OWNERS = {
    **dict.fromkeys(FLUID_CHANNELS, "a Fluid has"),
    "tensions": "networks with rods have",
    "broken": "networks with a breaking_strain have",
}
"""The bodies that have a field, in words."""


def field_names(scene: Scene) -> tuple[str, ...]:
    """The names of the fields that a scene has; positions and velocities always, if only of no particles."""
    fluids = FLUID_CHANNELS if scene.fluids else ()
    return (*CHANNELS, *fluids, *gauge_shapes(scene), *spring_channels(scene), *system_shapes(scene))


def gauge_shapes(scene: Scene) -> dict[str, tuple[int, ...]]:
    """The shapes of what is measured where fluids press: forces on all boundaries and bodies, pressures at probes."""
    pressed = any(isinstance(body, Fluid) for boundary in scene.boundaries for body in scene.targets(boundary))
    solid = any(len(body) for body in scene.bodies if not isinstance(body, Fluid))
    meets = solid and any(fluid.obstacles for fluid in scene.fluids)
    if not (pressed or meets or scene.probes):
        return {}
    forces = {"wall_forces": (len(scene.boundaries) + len(scene.bodies), scene.dimension)}
    return {**forces, **({"probe_pressures": (len(scene.probes),)} if scene.probes else {})}


def gauge(scene: Scene, key: object) -> tuple[str, str, int] | None:
    """What is measured of a probe or a boundary: its name in results, its field, and the row there; None of others.

    Raises:
        SceneError: a boundary is none of the scene's, or no fluid presses on it.
    """
    for index, probe in enumerate(scene.probes):
        if key is probe or (isinstance(key, str) and key == probe.name) or (isinstance(key, Probe) and key == probe):
            return "pressure", "probe_pressures", index
    if not isinstance(key, Boundary):
        return None
    own = [index for index, boundary in enumerate(scene.boundaries) if key is boundary]
    resolved = key.among(scene.bodies, "boundary")
    own += [index for index, boundary in enumerate(scene.boundaries) if resolved == boundary]
    if not own:
        raise SceneError(f"{key!r}: is no boundary of this scene")
    if "wall_forces" not in gauge_shapes(scene):
        raise SceneError(f"boundaries[{own[0]}].force: is measured where fluids press, and none does here")
    return "force", "wall_forces", own[0]


def body_gauges(scene: Scene, body: BodyKey) -> dict[str, tuple[str, int]]:
    """What is measured of a body, by its name in results: the field, and the row there."""
    index = scene.index(body)
    if isinstance(scene.bodies[index], Fluid) or "wall_forces" not in gauge_shapes(scene):
        return {}
    return {"force": ("wall_forces", len(scene.boundaries) + index)}


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
