"""Items of a scene by key, and the fields and rows that belong to each."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, TypeAlias, cast, get_args

import numpy as np
from numpy.typing import NDArray

from physcore.checks import BoolArray, FloatArray, shown, word
from physcore.errors import SceneError
from physcore.scene.bodies import Body, SpringNetwork
from physcore.scene.fields import MATTER, Element, Field, Rows
from physcore.scene.fluid import Fluid
from physcore.scene.grid import GridSystem
from physcore.scene.items import ActingItem, Boundary, Constraint, Force
from physcore.scene.periodic import Periodic
from physcore.scene.points import PointSystem
from physcore.scene.probe import Probe
from physcore.scene.selection import Selection
from physcore.scene.system import System
from physcore.spelling import UnknownKey, did_you_mean

BodyKey: TypeAlias = Body | int | str
"""Key of a body: the object, its index in the scene, or its name."""
GATHERED = ("positions", "velocities", "mass", "charge", "radius", "fixed")
"""Quantities of all particles."""
ItemKey: TypeAlias = BodyKey | System | Boundary | Constraint | Probe
"""Key of a body or another item with results: a system or a probe by object or name, a boundary or a constraint by
object.
"""


class Contents:
    """Items of a scene, with the fields of each."""

    bodies: tuple[Body, ...]
    forces: tuple[Force, ...]
    boundaries: tuple[Boundary, ...]
    constraints: tuple[Constraint, ...]
    systems: tuple[System, ...]
    probes: tuple[Probe, ...]
    periodic: Periodic | None
    """Periodic domain, or None."""

    @property
    def dimension(self) -> int:
        """The dimension of space: 2 or 3; 1 if there are only systems in 1D."""
        return self.bodies[0].dimension if self.bodies else self.systems[0].dimension

    @property
    def particles(self) -> int:
        """The total number of particles. Rigid bodies are no particles."""
        return sum(map(len, self.particle_bodies))

    @property
    def particle_bodies(self) -> tuple[Body, ...]:
        """The bodies that consist of particles: all but rigid bodies."""
        return tuple(body for body in self.bodies if not body.is_rigid)

    def gather(self, name: str) -> NDArray[Any]:
        """A quantity of all particles, in the order of results, shape (N,) or (N, D).

            scene.gather("mass")

        Args:
            name: "positions", "velocities", "mass", "charge", "radius" or "fixed".

        Raises:
            SceneError: there is no such quantity.
        """
        name = word(name, "gather.name", GATHERED)
        parts = [getattr(body, name) for body in self.particle_bodies]
        return np.concatenate(parts) if parts else getattr(self.bodies[0], name)[:0] if self.bodies else np.empty(0)

    @property
    def has_rigid_bodies(self) -> bool:
        """Whether there are rigid bodies."""
        return any(body.is_rigid for body in self.bodies)

    @property
    def are_particles(self) -> BoolArray:
        """Whether each row of the engine's fields of particles is a particle, not a rigid body."""
        return np.repeat([not body.is_rigid for body in self.bodies], [len(body) for body in self.bodies]).astype(bool)

    @property
    def fluids(self) -> tuple[Fluid, ...]:
        """The bodies that are fluids."""
        return tuple(cast("Fluid", body) for body in self.bodies if body.is_fluid)

    @property
    def networks(self) -> tuple[SpringNetwork, ...]:
        """The bodies that are spring networks."""
        return tuple(body.network for body in self.bodies if body.network is not None)

    @property
    def has_rods(self) -> bool:
        """Whether a spring network has rods."""
        return any(network.rods.any() for network in self.networks)

    @property
    def grids(self) -> tuple[GridSystem, ...]:
        """The systems on grids."""
        return tuple(cast("GridSystem", system) for system in self.systems if "cells" in system.elements)

    @property
    def clouds(self) -> tuple[PointSystem, ...]:
        """The systems of points."""
        return tuple(cast("PointSystem", system) for system in self.systems if "points" in system.elements)

    def count(self, element: Element) -> int:
        """The number of elements of a kind; of walls, that of boundaries and bodies.

        Raises:
            SceneError: there is no such kind of elements.
        """
        if word(element, "count.element", get_args(Element)) == "walls":
            return len(self.boundaries) + len(self.bodies)
        if element == "fluid particles":
            return self.particles  # a row each
        if element in ("beads", "joints", "ties"):
            return self._held(self.constraints, element)
        items: tuple[Body | System | Probe, ...] = (*self.bodies, *self.systems, *self.probes)
        return sum(item.elements.get(element, 0) for item in items)

    @property
    def fields(self) -> dict[str, Field]:
        """The fields by name: those of matter, without particles too, then those of systems."""
        return dict(self._fields)

    @cached_property
    def _fields(self) -> dict[str, Field]:
        own = {each.name: each.sized(self.count(each.element), self.dimension) for each in MATTER if self._has(each)}
        return own | {
            field.name: field for path, system in self.systems_by_path.items() for field in system.fields(path)
        }

    def _has(self, field: Field) -> bool:
        """Whether a field of matter exists in the scene."""
        if self.dimension not in field.dimensions:
            return False
        match field.element:
            case "particles":
                return True
            case "rigid bodies" if field.settable:
                return self.has_rigid_bodies
            case "fluid particles":
                return bool(self.fluids)
            case "walls":
                return self._presses
            case "probes" | "beads" | "joints" | "ties":
                return self.count(field.element) > 0
            case _:
                return any(field.name in body.quantities for body in self.bodies)

    @property
    def _presses(self) -> bool:
        """Whether fluids press on boundaries or bodies, or there are probes."""
        pressed = any(body.is_fluid for boundary in self.boundaries for body in self.targets(boundary))
        solid = any(len(body) for body in self.bodies if not body.is_fluid)
        return pressed or (solid and any(fluid.obstacles for fluid in self.fluids)) or bool(self.probes)

    def targets(self, item: ActingItem) -> tuple[Body, ...]:
        """The bodies that a force, a boundary or a constraint of this scene acts on.

        Raises:
            SceneError: the item is neither.
        """
        if not isinstance(item, ActingItem):
            raise SceneError(f"targets.item: must be a force or a boundary, got {shown(item)}")
        named = item.among(self.bodies, "targets.item").bodies()
        if named is not None:
            return named
        return tuple(body for body in self.bodies if not _is_spared(item, body))

    def members(self, item: ActingItem, field: str = "on") -> BoolArray:
        """Whether a force, a boundary or a constraint of this scene acts on each particle, shape (N,).

            scene.members(scene.forces[0])

        Rigid bodies are no particles: `targets` has those that an item acts on.

        Args:
            item: the force, the boundary or the constraint.
            field: "on", or another field of the item that names bodies, such as "sources".

        Raises:
            SceneError: the item is neither, or has no such field.
        """
        self.targets(item)  # raises the error
        name = word(field, "members.field", tuple(dict.fromkeys(("on", *item.naming))))
        return self.rows(item, name)[self.are_particles]

    def rows(self, item: ActingItem, field: str) -> BoolArray:
        """Whether an item acts on each row of the engine's fields of particles, which have rigid bodies too.

            scene.rows(scene.forces[0], "on")

        Args:
            item: a force, a boundary or a constraint.
            field: "on", or another field of the item that names bodies.

        Raises:
            SceneError: the item is neither, or has no such field.
        """
        self.targets(item)  # raises the error
        word(field, "rows.field", ("on", *item.naming))
        named = item.among(self.bodies, "members.item").targets(field)
        if named is None:
            named = self.targets(item) if field == "on" else self.bodies
        result = np.zeros(sum(map(len, self.bodies)), dtype=np.bool_)
        for each in named:
            if isinstance(each, Selection):
                result[self.place(cast("Body", each.body))] |= each.mask
            else:
                result[self.place(each)] = True
        return result

    def index(self, key: BodyKey) -> int:
        """The position of a body among the bodies of this scene.

        Raises:
            KeyError: there is no such body.
        """
        for position, body in enumerate(self.bodies):
            if key is body or (isinstance(key, str) and key == body.name):
                return position
        whole = isinstance(key, (int, np.integer)) and not isinstance(key, (bool, np.timedelta64))
        number = int(key) if whole else len(self.bodies)  # type: ignore[arg-type]
        if -len(self.bodies) <= number < len(self.bodies):
            return number % len(self.bodies)
        known = [body.name for body in self.bodies if body.name is not None]
        names = ", ".join(map(repr, known)) or "none"
        raise UnknownKey(
            f"no body {shown(key)}: this scene has {len(self.bodies)}, and of names {names}{did_you_mean(key, known)}"
        )

    def path(self, key: BodyKey) -> str:
        """The name of a body in messages: bodies['water'], or bodies[0] if it has no name."""
        index = self.index(key)
        name = self.bodies[index].name
        return f"bodies[{index if name is None else repr(name)}]"

    def place(self, key: BodyKey) -> slice:
        """The slice of a body in the engine's fields of particles, which have a row for each rigid body too.

            scene.place(scene.bodies[0])

        Raises:
            KeyError: there is no such body.
        """
        index = self.index(key)
        start = sum(map(len, self.bodies[:index]))
        return slice(start, start + len(self.bodies[index]))

    def slice(self, key: BodyKey) -> slice:
        """The slice of a body's particles in results; an empty one for rigid bodies, which are no particles."""
        index = self.index(key)
        start = self._before(index, "particles")
        return slice(start, start + self.bodies[index].elements.get("particles", 0))

    def _before(self, index: int, element: Element) -> int:
        """The number of elements of the bodies before one."""
        return sum(body.elements.get(element, 0) for body in self.bodies[:index])

    def first_spring(self, key: BodyKey) -> int:
        """The index of a body's first spring among those of the scene."""
        return self._before(self.index(key), "springs")

    @property
    def systems_by_path(self) -> dict[str, System]:
        """The systems by their paths, which precede the names of their fields."""
        return {system.name or f"systems[{position}]": system for position, system in enumerate(self.systems)}

    def system(self, key: object) -> str | None:
        """The path of a system, given itself or its path; None if the key is no system of the scene."""
        for path, system in self.systems_by_path.items():
            if key is system or (isinstance(key, str) and key == path):
                return path
        return None

    def parts(self, key: ItemKey) -> dict[str, tuple[str, Rows]]:
        """The fields of an item: names in its results, with the name of the scene's field and the item's rows in it.

        Raises:
            KeyError: there is no such item.
            SceneError: a boundary does not belong to the scene, or no fluid presses on it.
        """
        path = self.system(key)
        if path is not None:
            rows: dict[Element, Rows] = dict.fromkeys(("cells", "points"), slice(None))
            own = (field for name, field in self._fields.items() if name.startswith(f"{path}."))
        else:
            rows = self._gauge(key) or self._beads(key) or self._rows(self.index(cast("BodyKey", key)))
            own = (field for field in self._fields.values())
        return {field.part: (field.name, rows[field.element]) for field in own if field.element in rows}

    def _gauge(self, key: object) -> dict[Element, Rows] | None:
        """The row of a probe or a boundary; None for other keys."""
        section = getattr(key, "section", None)
        for index, probe in enumerate(self.probes):
            if key is probe or (isinstance(key, str) and key == probe.name) or (section == "probes" and key == probe):
                return {"probes": index}
        if section != "boundaries":
            return None
        boundary = cast("Boundary", key)
        own = [index for index, other in enumerate(self.boundaries) if boundary is other]
        resolved = boundary.among(self.bodies, "boundary")
        own += [index for index, other in enumerate(self.boundaries) if resolved == other]
        if not own:
            raise SceneError(f"{key!r}: is no boundary of this scene")
        if not self._presses:
            raise SceneError(f"boundaries[{own[0]}].force: is measured where fluids press, and none does here")
        return {"walls": own[0]}

    def _held(self, constraints: Sequence[Constraint], element: Element) -> int:
        """The number of values that constraints have: one for each joint, or for each particle that they act on."""
        own = [each for each in constraints if each.element == element]
        return len(own) if element == "joints" else sum(int(self.members(each).sum()) for each in own)

    def _beads(self, key: object) -> dict[Element, Rows] | None:
        """The rows of a constraint with values for its particles, or the row of a joint; None for other keys."""
        element = getattr(key, "element", None)
        if getattr(key, "section", None) != "constraints" or element is None:
            return None
        constraint = cast("Constraint", key).among(self.bodies, "constraint")
        for index, other in enumerate(self.constraints):
            if constraint == other:
                first = self._held(self.constraints[:index], element)
                return {element: first if element == "joints" else slice(first, first + self._held([other], element))}
        raise SceneError(f"{key!r}: is no constraint of this scene")

    def _rows(self, index: int) -> dict[Element, Rows]:
        """The rows of a body in the fields of each kind of element that it has."""
        counts = self.bodies[index].elements
        starts: dict[Element, int] = {element: self._before(index, element) for element in counts}
        starts["fluid particles"] = starts.get("particles", 0)  # a row for every particle
        rows: dict[Element, Rows] = {each: slice(starts[each], starts[each] + count) for each, count in counts.items()}
        return rows | {"walls": len(self.boundaries) + index} if "walls" in rows else rows

    def results(self, key: object, values: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """Fields of an item in the form of results, from the form of the engine; with or without a time axis."""
        path = self.system(key)
        return values if path is None else self.systems_by_path[path].shown(values)


def _is_spared(item: ActingItem, body: Body) -> bool:
    """Whether an item does not act on a body that is not named."""
    return (item.spares_fluids and body.is_fluid) or (item.spares_rigid_bodies and body.is_rigid)
