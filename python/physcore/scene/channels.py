"""Names of the fields of a scene, and the parts that belong to each body."""

from __future__ import annotations

from physcore.errors import SceneError
from physcore.scene.bodies import SpringNetwork
from physcore.scene.fluid import Fluid
from physcore.scene.items import Boundary
from physcore.scene.probe import Probe
from physcore.scene.scene import BodyKey, Scene

CHANNELS = ("positions", "velocities")
"""Fields of all particles."""
FLUID_CHANNELS = ("densities", "pressures")
"""Additional fields of fluids."""
SPRING_CHANNELS = ("tensions", "broken")
"""Fields of springs: tensions in scenes with rods, broken springs if springs can break."""

GAUGES = {"wall_forces": "wall_impulses", "probe_pressures": "probe_impulses"}
"""Fields of boundaries and bodies that fluids press on, and of probes, with the names of their time integrals."""

OWNERS = {
    **dict.fromkeys(FLUID_CHANNELS, "a Fluid has"),
    "tensions": "networks with rods have",
    "broken": "networks with a breaking_strain have",
}
"""Description of the bodies that have a field, for messages."""


def field_names(scene: Scene) -> tuple[str, ...]:
    """The names of the fields of a scene. Positions and velocities are always included, even without particles."""
    fluids = FLUID_CHANNELS if scene.fluids else ()
    return (*CHANNELS, *fluids, *gauge_shapes(scene), *spring_channels(scene), *system_shapes(scene))


def gauge_shapes(scene: Scene) -> dict[str, tuple[int, ...]]:
    """The shapes of measured fields: forces of fluids on all boundaries and bodies, and pressures at probes."""
    pressed = any(isinstance(body, Fluid) for boundary in scene.boundaries for body in scene.targets(boundary))
    solid = any(len(body) for body in scene.bodies if not isinstance(body, Fluid))
    meets = solid and any(fluid.obstacles for fluid in scene.fluids)
    if not (pressed or meets or scene.probes):
        return {}
    forces = {"wall_forces": (len(scene.boundaries) + len(scene.bodies), scene.dimension)}
    return {**forces, **({"probe_pressures": (len(scene.probes),)} if scene.probes else {})}


def gauge(scene: Scene, key: object) -> tuple[str, str, int] | None:
    """The measurement of a probe or a boundary: its name in results, its field, and its row; None for other keys.

    Raises:
        SceneError: a boundary does not belong to the scene, or no fluid presses on it.
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
    """The measurements of a body, by name in results: the field, and the row."""
    index = scene.index(body)
    if isinstance(scene.bodies[index], Fluid) or "wall_forces" not in gauge_shapes(scene):
        return {}
    return {"force": ("wall_forces", len(scene.boundaries) + index)}


def system_shapes(scene: Scene) -> dict[str, tuple[int, ...]]:
    """The shapes of the fields of systems."""
    shapes = (
        (scene.system(system), name, shape) for system in scene.systems for name, shape in system.shapes().items()
    )
    return {f"{system}.{name}": shape for system, name, shape in shapes}


def body_fields(scene: Scene, body: BodyKey) -> dict[str, slice]:
    """The fields of a body, with the slice of its particles or springs in each."""
    index = scene.index(body)
    found = scene.bodies[index]
    names = (*CHANNELS, *FLUID_CHANNELS) if isinstance(found, Fluid) else CHANNELS
    fields = dict.fromkeys(names, scene.slice(body))
    if isinstance(found, SpringNetwork):
        start = first_spring(scene, found)
        fields |= dict.fromkeys(spring_channels(scene), slice(start, start + len(found.pairs)))
    return fields


def first_spring(scene: Scene, body: SpringNetwork) -> int:
    """The index of a body's first spring among the springs of the scene."""
    return springs(scene, scene.index(body))


def spring_channels(scene: Scene) -> tuple[str, ...]:
    """The names of the fields of the scene's springs."""
    has = {"tensions": has_rods(scene), "broken": can_tear(scene)}
    return tuple(name for name in SPRING_CHANNELS if has[name])


def can_tear(scene: Scene) -> bool:
    """Whether a spring of a scene can break."""
    return any(isinstance(body, SpringNetwork) and body.can_tear for body in scene.bodies)


def has_rods(scene: Scene) -> bool:
    """Whether a spring network of a scene has rods."""
    return any(isinstance(body, SpringNetwork) and body.rods.any() for body in scene.bodies)


def springs(scene: Scene, bodies: int | None = None) -> int:
    """The number of springs of a scene, or of its first bodies."""
    return sum(len(body.pairs) for body in scene.bodies[:bodies] if isinstance(body, SpringNetwork))
