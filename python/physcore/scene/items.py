"""Base classes of scene items other than bodies and systems: forces, constraints and boundaries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import ClassVar, Protocol, Self, cast

import numpy as np

from physcore.checks import FloatArray, Vector, flag, frozen, number
from physcore.scene.bodies import Body
from physcore.scene.fields import Element
from physcore.scene.selection import Selection
from physcore.scene.targets import On, Target, chosen, known, require_once, targeted, whole
from physcore.units.systems import Default, UnitSystem


@dataclass(frozen=True)
class SceneItem:
    """Base class of scene items other than bodies. Fields are plain numbers, tuples of numbers for vectors, or None."""

    section: ClassVar[str]
    """Name of the scene's tuple of such items."""
    acts: ClassVar[bool] = False
    """Whether the item acts on bodies."""
    naming: ClassVar[tuple[str, ...]] = ()
    """The fields that name bodies."""
    linking: ClassVar[tuple[str, ...]] = ()
    """The fields that name another item of the same section."""
    parts: ClassVar[tuple[type, ...]] = ()
    """Classes of the objects in its fields, which files can contain too."""

    def named(self) -> Mapping[str, tuple[Body | Selection | SceneItem, ...] | None]:
        """The other items of the scene that fields name, by field; None: all."""
        return {}

    def _set(self, **values: object) -> None:
        """Replace the user's values by their validated forms; only for `__post_init__`."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __setstate__(self, state: dict[str, object]) -> None:
        """Make the arrays of a copy or an unpickled item read-only."""
        self._set(**{name: frozen(value) if isinstance(value, np.ndarray) else value for name, value in state.items()})

    def mismatch(self, dimension: int) -> tuple[str, int] | None:
        """The name and the size of the first vector that does not have `dimension` components; otherwise None."""
        vectors = {entry.name: getattr(self, entry.name) for entry in fields(self) if entry.name != "on"}
        wrong = (
            (name, len(value))
            for name, value in vectors.items()
            if isinstance(value, tuple) and _is_vector(value) and len(value) != dimension
        )
        return next(wrong, None)

    def resolved(self, dimension: int) -> SceneItem:
        """The form of the item in a scene of `dimension` dimensions, which the engine simulates and films draw."""
        del dimension
        return self

    def in_units(self, units: UnitSystem, dimension: int, path: str) -> Self:
        """The item with the defaults that it was left at in units of a scene.

        Raises:
            SceneError: a default has a dimension, and the scene is without units.
        """
        del dimension
        left = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        converted = {
            name: value.converted(units, f"{path}.{name}") for name, value in left.items() if isinstance(value, Default)
        }
        return replace(self, **converted) if converted else self


def _is_vector(value: tuple[object, ...]) -> bool:
    """Whether a tuple consists of numbers; other tuples hold words or parts of an item."""
    return bool(value) and all(isinstance(each, (int, float)) for each in value)


class Places(Protocol):
    """The places of bodies and constraints in the arrays of the engine."""

    @property
    def constraints(self) -> Sequence[Constraint]:
        """All constraints of the scene."""

    def place(self, key: Body) -> slice:
        """The slice of a body in the engine's fields of particles."""


@dataclass(frozen=True)
class ActingItem(SceneItem):
    """Base class of items that act on bodies."""

    on: On = field(default=None, kw_only=True)
    """The body or bodies that the item acts on, or their names; None: all, or all except fluids (`spares_fluids`)."""

    acts: ClassVar[bool] = True
    spares_fluids: ClassVar[bool] = False
    """Whether the item acts on a fluid only if the fluid is named."""
    spares_rigid_bodies: ClassVar[bool] = False
    """Whether the item never acts on rigid bodies."""
    naming: ClassVar[tuple[str, ...]] = ("on",)
    selects: ClassVar[bool] = False
    """Whether the item can act on some particles of a body."""

    def __post_init__(self) -> None:
        self._set(**{name: self._targets(name) for name in self.naming})
        for name, targets in self._keys().items():
            require_once(targets, f"{type(self).__name__}.{name}")

    @property
    def by_name(self) -> bool:
        """Whether some bodies are given by name. These are not known until the item is in a scene."""
        return any(isinstance(whole(each), str) for keys in self._keys().values() for each in keys)

    def _targets(self, name: str) -> tuple[Target, ...] | None:
        """The validated value of a field that names bodies."""
        value, path = getattr(self, name), f"{type(self).__name__}.{name}"
        return targeted(value, path) if self.selects else chosen(value, path)

    def _keys(self) -> dict[str, tuple[Target, ...]]:
        """The bodies, names and selections in each field; fields that are None are omitted."""
        given = {name: self._targets(name) for name in self.naming}
        return {name: keys for name, keys in given.items() if keys is not None}

    def among(self, bodies: Sequence[Body], path: str) -> Self:
        """A copy of the item in which names are replaced by the bodies of a scene.

        Raises:
            SceneError: no body has such a name, or the item cannot act on it.
        """
        if not self.by_name:
            return self
        return replace(self, **{name: known(keys, bodies, f"{path}.{name}") for name, keys in self._keys().items()})

    def bodies(self, field: str = "on") -> tuple[Body, ...] | None:
        """The bodies that a field names, in whole or in part, each once; None: all. For an item of a scene."""
        targets = self.targets(field)
        return None if targets is None else tuple(dict.fromkeys(whole(each) for each in targets))

    def targets(self, field: str = "on") -> tuple[Body | Selection, ...] | None:
        """The bodies that a field names, and the selections from bodies; None: all. For an item of a scene."""
        return cast("tuple[Body | Selection, ...] | None", getattr(self, field))  # converted by `among`

    def named(self) -> Mapping[str, tuple[Body | Selection | SceneItem, ...] | None]:
        """The bodies and selections that fields name, by field; None: all. For an item of a scene."""
        return {name: self.targets(name) for name in self.naming}

    @property
    def partial(self) -> tuple[str, ...]:
        """The fields that name some particles of a body."""
        return tuple(name for name, keys in self._keys().items() if any(isinstance(key, Selection) for key in keys))

    def references(self, scene: Places) -> Mapping[str, object]:
        """Values in the form of the engine that depend on the scene, such as indices of other items."""
        del scene
        return {}

    def check(self, bodies: Sequence[Body], path: str) -> None:
        """Check the bodies that the item acts on, after names are replaced; `path` is the item's path in the scene.

        Raises:
            SceneError: the item cannot act on them.
        """


# To add a force: a module in `forces`, a line in `FORCES`, and its counterpart in Rust.
@dataclass(frozen=True)
class Force(ActingItem):
    """Base class of forces on the particles of bodies.

        scene.forces  # (Gravity(…),)
        all(isinstance(force, pc.Force) for force in scene.forces)  # True

    `Scene.forces` has all forces of a scene. A force acts on the bodies that `on=` names, and on some particles of a
    body by `on=(body, indices)`. The indices are an integer, a slice, integer indices or a bool mask:

        pc.Gravity(on=(cloth, slice(0, 40)))
        pc.Drag(0.1, on=[ball, ("cloth", cloth.positions[:, 1] > 0.5)])

    A force between particles acts between those that are named. On rigid bodies forces act at their centers of mass,
    and a Wind on their surfaces; those of short range between particles do not act on them.
    """

    section: ClassVar[str] = "forces"
    selects: ClassVar[bool] = True
    feels_charges: ClassVar[bool] = False
    """Whether the force may act on the charges of bodies."""
    needs_charges: ClassVar[bool] = False
    """Whether the force acts on charges alone."""
    is_distant: ClassVar[bool] = False
    """Whether the force acts between all pairs of particles, at any distance."""
    is_shown: ClassVar[bool] = True
    """Whether a test particle shows the force: not a force of short range between particles, nor user code."""
    has_kink: ClassVar[bool] = False
    """Whether the force has a kink or a jump at its range, which is reached at any time within a step."""
    is_contact: ClassVar[bool] = False
    """Whether the force is that of contacts between particles."""
    timed: ClassVar[tuple[str, ...]] = ()
    """The fields that may be functions of time."""
    binds: ClassVar[bool] = False
    """Whether the force binds atoms. Its limit of accuracy resolves their bonds."""

    @property
    def dissipates(self) -> bool:
        """Whether the force may depend on velocities, or on time, which splittings do not resolve in steps without
        limit.
        """
        return False

    @property
    def is_magnetic(self) -> bool:
        """Whether there is a magnetic field."""
        return False

    @property
    def is_electric(self) -> bool:
        """Whether there is an electric field that is not due to charges."""
        return False

    @property
    def changes(self) -> bool:
        """Whether an electric or magnetic field may depend on time."""
        return False

    def finer(self) -> Force:
        """The force with a fraction of the error of its sums; itself if they are exact."""
        return self

    def fall(self, dimension: int) -> FloatArray | None:
        """The constant acceleration that the force gives to all particles of a falling body [m/s²]: zero for forces
        that keep a flat body flat, None for those that may bend it or push it sideways.
        """
        del dimension
        return None


# To add a constraint: a module in `constraints`, a line in `CONSTRAINTS`, and its counterpart in Rust.
@dataclass(frozen=True)
class Constraint(ActingItem):
    """Base class of constraints: conditions on the motion of bodies, such as mutual impenetrability."""

    section: ClassVar[str] = "constraints"
    element: ClassVar[Element | None] = None
    """Kind of the elements that have values: beads or ties, one for each particle that it acts on, or joints, one for
    each constraint; None: there are none.
    """

    @property
    def is_smooth(self) -> bool:
        """Whether the motion under the constraint is smooth, and costs little to resolve."""
        return False

    def thickness_of(self, body: Body) -> float:
        """The thickness that the constraint gives to a body [m]."""
        del body
        return 0.0

    def following(self, given: Sequence[Constraint], known: Sequence[Constraint]) -> Self:
        """A copy that names the constraints of a scene, `known`, in place of those that the user has given."""
        del given, known
        return self


# To add a boundary: a module in `boundaries`, a line in `BOUNDARIES`, and its counterpart in Rust.
@dataclass(frozen=True)
class Boundary(ActingItem):
    """Base class of boundaries, which reflect particles.

        floor = pc.Floor(restitution=0.5, friction=0.3)
        isinstance(floor, pc.Boundary)  # True

    A contact happens at center ± radius. The normal velocity v_n becomes −restitution · v_n. The tangential impulse
    follows Coulomb's law: at most friction times the normal impulse, and never more than is needed to stop the sliding.
    The energy loss of a contact counts as dissipated.
    """

    section: ClassVar[str] = "boundaries"

    restitution: float = field(default=1.0, kw_only=True)
    """Ratio of the normal speeds after and before a contact, from 0 (no bounce) to 1 (no loss)."""
    friction: float = field(default=0.0, kw_only=True)
    """Coulomb's coefficient of friction, at least zero."""
    no_slip: bool = field(default=False, kw_only=True)
    """Whether fluids stick to the boundary; by default they slip along it freely."""

    @property
    def flat(self) -> tuple[Vector, Vector] | None:
        """A point of the boundary and its unit normal, if it is a plane; of a resolved one."""
        return None

    @property
    def room(self) -> tuple[Vector, Vector] | None:
        """The lower and the upper corner of the space that the boundary encloses; None for others than boxes."""
        return None

    @property
    def ball(self) -> tuple[Vector, float] | None:
        """The center and the radius of a ball that particles cannot enter; None for others."""
        return None

    def is_symmetric(self, middle: FloatArray, normal: FloatArray, tolerance: float) -> bool:
        """Whether the boundary is symmetric about a plane through `middle`, in the part that a body falling within this
        plane can touch.
        """
        del middle, normal, tolerance
        return False

    def __post_init__(self) -> None:
        super().__post_init__()
        kind = type(self).__name__
        self._set(
            restitution=number(self.restitution, f"{kind}.restitution", least=0.0, most=1.0),
            friction=number(self.friction, f"{kind}.friction", least=0.0),
            no_slip=flag(self.no_slip, f"{kind}.no_slip"),
        )
