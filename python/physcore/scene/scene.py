"""Scene: the description of a system, without its numerics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias, cast

import numpy as np

from physcore.checks import shown, text
from physcore.errors import FileError, SceneError
from physcore.scene.bodies import Body
from physcore.scene.contents import Contents
from physcore.scene.fluid import CLOSEST, describe_pair
from physcore.scene.items import ActingItem, Boundary, Constraint, Force, SceneItem
from physcore.scene.mistakes import warn_of_mistakes
from physcore.scene.overlaps import closer_than
from physcore.scene.periodic import Periodic
from physcore.scene.probe import Probe
from physcore.scene.records import Named, Record, pack
from physcore.scene.selection import Selection
from physcore.scene.system import System
from physcore.scene.targets import whole
from physcore.storage.archive import Tree, digest
from physcore.units.systems import SI, UnitSystem

Item: TypeAlias = Body | Force | Boundary | Constraint | System | Probe | Periodic
SECTIONS = ("bodies", "forces", "boundaries", "constraints", "systems", "probes")
"""Names of the tuples of items in a scene."""


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Scene(Contents):
    """Scene: bodies, forces, boundaries, constraints and systems in 2D or 3D; in 1D, systems only.

        ball = pc.Particles([[0.0, 1.0]], radius=0.1, name="ball")
        scene = pc.Scene(ball, pc.Gravity(), pc.Floor(restitution=0.8), pc.Drag(linear=0.01, on="ball"))

    Scenes are immutable. The dimension follows from the positions and grids.

    Args:
        items: bodies (Particles, SpringNetwork, Fluid, RigidBodies), forces, boundaries, constraints and joints,
            systems, probes and at most one Periodic domain, in any order. Results have the particles in the order of
            the bodies.
        units: the units in which all numbers of the scene are, times and time steps of its runs included; None: the SI.
            `pc.units.system` makes such units, and `pc.units.dimensionless` is for models without any. They change no
            bit of a result. Labels, tables, messages and files have them. Defaults with a dimension, such as G, are
            converted; those of a Fluid have to be given.

    Raises:
        SceneError: there is neither a body nor a system, the dimensions differ, a body or a name occurs twice, a force
            acts on a body that is not in the scene or has nothing to act on, fluids overlap, or a default has no value
            in `units`.
    """

    units: UnitSystem
    """Units of all numbers."""

    def __init__(self, *items: Item, units: UnitSystem | None = None) -> None:
        if not isinstance(units, (UnitSystem, type(None))):
            raise SceneError(f"units: must be a system of units, as of pc.units.system(…), got {shown(units)}")
        object.__setattr__(self, "units", units or SI)
        with self.units.worded():
            self._set(items)

    def _set(self, items: Sequence[object]) -> None:
        """Sort the items, and check them."""
        for position, item in enumerate(items):
            if not isinstance(item, (Body, Force, Boundary, Constraint, System, Probe, Periodic)):
                raise SceneError(
                    f"items[{position}]: must be a body, a force, a boundary, a constraint, a system, a "
                    f"Probe or a Periodic domain, got {shown(item)}{_advice(item)}"
                )
        given = cast("Sequence[Item]", items)
        for section in SECTIONS:
            object.__setattr__(self, section, tuple(item for item in given if item.section == section))
        self._check_bodies()
        for field in ("forces", "boundaries", "constraints"):
            known = (item.among(self.bodies, f"{field}[{place}]") for place, item in enumerate(getattr(self, field)))
            object.__setattr__(self, field, tuple(known))
        own, before = self.constraints, [item for item in given if item.section == "constraints"]
        linked = (each.following(cast("list[Constraint]", before), own) for each in own)
        object.__setattr__(self, "constraints", tuple(linked))
        self._set_domain([cast("Periodic", item) for item in given if item.section == "domains"])
        if not self.units.is_si:
            self._convert_defaults()
        self._check_fluids()
        self._check_items("forces", self.forces)
        self._check_items("boundaries", self.boundaries)
        self._check_items("constraints", self.constraints)
        self._check_items("systems", self.systems)
        self._check_probes()
        self._check_sizes()
        warn_of_mistakes(self.bodies, self.forces, self.path)

    def hash(self, key: str | None = None) -> str:
        """Hash of all items of the scene: the same for equal scenes, in every process and on every machine.

        A version of physcore whose classes have additional arguments gives a different hash.

        Args:
            key: a text that stands for the user functions of the scene, and is part of the hash. None: none.

        Raises:
            FileError: the scene has a user function, such as that of a CustomForce, which is code, and no key is given.
            SceneError: the key is not a text.
        """
        if key is None:
            return digest(self.packed())
        return digest({"key": text(key, "hash.key"), "scene": self.packed(code=False)})

    def packed(self, *, code: bool = True) -> Tree:
        """The scene as a tree of plain values, for files and hashes. Without `code`, user functions are left out.

        Raises:
            FileError: the scene has a user function, such as that of a CustomForce, which is code.
        """
        return {
            "bodies": [pack(body) for body in self.bodies],
            "forces": self._packed_items("forces", self.forces, code),
            "boundaries": self._packed_items("boundaries", self.boundaries, code),
            "constraints": self._packed_items("constraints", self.constraints, code),
            "systems": self._packed_items("systems", self.systems, code),
            "probes": self._packed_items("probes", self.probes, code),
            "periodic": pack(self.periodic),
            **({} if self.units.is_si else {"units": asdict(self.units)}),
        }

    def _packed_items(self, path: str, items: Sequence[SceneItem], code: bool) -> list[Tree]:
        """Items in packed form; the bodies and systems that they name are indices, because each is saved once."""
        trees = []
        for position, item in enumerate(items):
            record = Record.of(item)
            if record.code and code:
                other = ", or express the force by the ones that physcore has" if path == "forces" else ""
                raise FileError(
                    f"{path}[{position}]{record.code}: a {type(item).__name__} cannot be saved, because this function "
                    f"is code; save the arrays that you need with numpy.savez{other}"
                )
            tree = record.packed(indices(self, item))
            trees.append(_without_code(tree) if record.code else tree)
        return trees

    def __repr__(self) -> str:
        domain = () if self.periodic is None else (self.periodic,)
        parts = [
            repr(item)
            for item in (
                *self.bodies,
                *self.forces,
                *self.boundaries,
                *self.constraints,
                *self.systems,
                *self.probes,
                *domain,
            )
        ]
        own = [] if self.units.is_si else [f"units={self.units!r}"]
        return f"Scene({', '.join([*parts, *own])})"

    def _convert_defaults(self) -> None:
        """Convert defaults that items were left at to the scene's units. Bodies and systems are keys to results, and
        are not replaced.

        Raises:
            SceneError: a default cannot be converted; with its value in the scene's units.
        """
        for section in ("forces", "boundaries", "constraints"):
            items = (
                item.in_units(self.units, self.dimension, f"{section}[{place}]")
                for place, item in enumerate(getattr(self, section))
            )
            object.__setattr__(self, section, tuple(items))
        left: dict[str, tuple[Body | System, ...]] = {"bodies": self.bodies, "systems": self.systems}
        for section, kept in left.items():
            for place, item in enumerate(kept):
                for name, value in item.defaults.items():
                    path = f"{self.path(place) if section == 'bodies' else f'systems[{place}]'}.{name}"
                    own, unit = value.converted(self.units, path), self.units.suffix(value.unit)
                    raise SceneError(
                        f"{path}: must be given in the units of this scene; the default is {name}={own:.6g}{unit}"
                    )

    def _check_bodies(self) -> None:
        """Check that there is at least one body or system, that each occurs once, and that dimensions and names are
        consistent.
        """
        if not self.bodies and not self.systems:
            raise SceneError(
                "Scene: must have at least one body, such as Particles, SpringNetwork or Fluid, or a system"
            )
        names: set[str] = set()
        for position, system in enumerate(self.systems):
            if any(system is other for other in self.systems[:position]):
                raise SceneError(f"systems[{position}]: the same item is in the scene twice; build a second one")
            if system.name is not None and system.name in names:
                raise SceneError(f"systems[{position}].name: {system.name!r} is already the name of another item")
            names |= {system.name} if system.name is not None else set()
            if system.dimension != self.dimension:
                raise SceneError(f"systems[{position}]: {system.dimension}D, but the scene is {self.dimension}D")
        for position, body in enumerate(self.bodies):
            if body in self.bodies[:position]:
                raise SceneError(f"bodies[{position}]: the same body is in the scene twice; build a second one")
            if body.name is not None and body.name in names:
                raise SceneError(f"bodies[{position}].name: {body.name!r} is already the name of another body")
            if body.name is not None:
                names.add(body.name)
            if body.dimension != self.dimension:
                raise SceneError(
                    f"{self.path(position)}.positions: {body.dimension}D, but the first body is {self.dimension}D"
                )

    def _set_domain(self, domains: list[Periodic]) -> None:
        """Check that there is at most one domain, of the scene's dimension."""
        if len(domains) > 1:
            raise SceneError(f"periodic: there must be at most one Periodic domain, got {len(domains)}")
        if domains and domains[0].dimension != self.dimension:
            raise SceneError(
                f"periodic.lower: Periodic must have {self.dimension} components in this {self.dimension}D scene, "
                f"got {domains[0].dimension}"
            )
        object.__setattr__(self, "periodic", domains[0] if domains else None)

    def _check_fluids(self) -> None:
        """Check that no particles of different fluids overlap; each fluid has checked its own particles."""
        fluids = self.fluids
        if not fluids or (len(fluids) == 1 and self.periodic is None):
            return
        spacing = min(fluid.spacing for fluid in fluids)
        points = np.concatenate([fluid.positions for fluid in fluids])
        origins = np.arange(len(points))
        if self.periodic is not None:
            points, origins = self.periodic.with_images(points, CLOSEST * spacing)
        pair = closer_than(points, CLOSEST * spacing)
        if pair is None:
            return
        starts = np.cumsum([0, *(len(fluid) for fluid in fluids)])
        owners = [fluids[int(np.searchsorted(starts, origins[end], side="right")) - 1] for end in pair]
        first, second = (self.path(self.index(owner)) for owner in owners)
        where = f"particles of {first} and {second}" if first != second else f"particles of {first}, across the domain"
        raise SceneError(f"{second}.positions: overlapping bodies: {where}, {describe_pair(points, pair, spacing)}")

    def _check_probes(self) -> None:
        """Check that there is a fluid at the probes."""
        self._check_items("probes", self.probes)
        named = [*(body.name for body in self.bodies), *(system.name for system in self.systems)]
        names = [*named, *(probe.name for probe in self.probes)]
        for index, probe in enumerate(self.probes):
            path = f"probes[{index}]"
            if not self.fluids:
                raise SceneError(f"{path}: measures the pressure of fluids, and there is none in this scene")
            if probe.name is not None and names.count(probe.name) > 1:
                raise SceneError(f"{path}.name: {probe.name!r} is already the name of another item")
            if self.periodic is not None and not self.periodic.holds(probe.position):
                raise SceneError(f"{path}.position: must be in the periodic domain, got {shown(probe.position)}")

    def _check_sizes(self) -> None:
        """Check that no particle in a fluid is larger than a particle of the fluid, whose volume it displaces."""
        spacing = min((fluid.spacing for fluid in self.fluids if fluid.obstacles), default=math.inf)
        for index, body in enumerate(self.bodies):
            largest = float(body.radius.max(initial=0.0))
            if not body.is_fluid and largest > spacing:
                raise SceneError(
                    f"{self.path(index)}.radius: a particle displaces as much fluid as one of its particles, of a "
                    f"spacing of {spacing:g} m, and its radius is {largest:g} m; fill the body with particles, as "
                    "pc.ball does, leave the radius out, or let it pass by Fluid(…, obstacles=False)"
                )

    def _check_items(self, section: str, items: Sequence[SceneItem]) -> None:
        for position, item in enumerate(items):
            self._check_item(f"{section}[{position}]", item)

    def _check_item(self, path: str, item: SceneItem) -> None:
        """Check that vectors have the scene's dimension, and that `on` names bodies of the scene."""
        mismatch = item.mismatch(self.dimension)
        if mismatch is not None:
            name, size = mismatch
            raise SceneError(
                f"{path}.{name}: {type(item).__name__} must have {self.dimension} components "
                f"in this {self.dimension}D scene, got {size}"
            )
        for field, others in item.named().items():
            for other in others or ():
                if not any(whole(other) is each for each in (*self.bodies, *self.systems, *self.constraints)):
                    raise SceneError(f"{path}.{field}: {whole(other)!r} is not in the scene; add it as an item too")
        if not item.acts:
            return
        acting = cast("ActingItem", item)
        targets = self.targets(acting)
        if not targets and acting.on is None and self.bodies:
            kind, fluids = type(item).__name__, acting.spares_fluids and self.fluids
            rule = (
                "acts on fluids only where they are named: on=fluid"
                if fluids
                else "acts on particles, not on rigid bodies"
            )
            raise SceneError(f"{path}.on: {kind} {rule}")
        if acting.spares_rigid_bodies:
            self._refuse_rigid_bodies(acting, path)
        acting.check(targets, path)

    def _refuse_rigid_bodies(self, item: ActingItem, path: str) -> None:
        """Check that an item that acts on particles alone names no rigid bodies."""
        for field in item.naming:
            rigid = next((body for body in item.bodies(field) or () if body.is_rigid), None)
            if rigid is not None:
                raise SceneError(f"{path}.{field}: {type(item).__name__} acts on particles, not on {rigid!r}")


def indices(scene: Scene, item: SceneItem) -> Named:
    """The indices of the bodies, and of other items of its section, that an item names, by field.

    A selection of particles is the index of its body and the indices of the particles.
    """
    return {
        field: None if others is None else [_place(scene, other) for other in others]
        for field, others in item.named().items()
    }


def _without_code(tree: Tree) -> Tree:
    """A tree with None in place of functions."""
    if isinstance(tree, dict):
        return {name: _without_code(each) for name, each in tree.items()}
    if isinstance(tree, (list, tuple)):
        return [_without_code(each) for each in tree]
    return None if callable(tree) else tree


def _place(scene: Scene, named: Body | Selection | SceneItem) -> int | list[Any]:
    """The index of a body or another item; with the indices of the selected particles of a body, if not of all."""
    item = whole(named)
    index = next(place for place, each in enumerate(getattr(scene, item.section)) if each is item)
    return [index, named.index] if isinstance(named, Selection) else index


def _advice(item: object) -> str:
    """A hint about common mistakes."""
    if isinstance(item, type):
        return f"; write {item.__name__}(…)"
    if isinstance(item, (list, tuple)):
        return "; unpack it: Scene(*items)"
    return ""
