"""Base classes of scene items other than bodies: forces, systems, constraints and boundaries."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, Protocol, Self, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from physcore.checks import BoolArray, FloatArray, Vector, broadcast, flag, frozen, number, shown, text
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.fields import Element, Field
from physcore.scene.selection import Selection, is_selection
from physcore.spelling import did_you_mean
from physcore.units.systems import Default, UnitSystem

Target: TypeAlias = Body | str | Selection
"""A body, its name, or some particles of a body."""
On: TypeAlias = Target | tuple[Body | str, ArrayLike | slice] | Sequence[object] | None
"""Bodies, as objects or by name; `(body, indices)`: some particles of a body; or several of these. None: all."""
T = TypeVar("T")


def chosen(on: object, path: str, kinds: tuple[type, ...] = (Body,)) -> tuple[Body | str, ...] | None:
    """The validated value of `on=`: bodies, or items of other kinds, as objects or names; None: all."""
    if on is None:
        return None
    bodies = (on,) if isinstance(on, (*kinds, str)) else on
    if not isinstance(bodies, (tuple, list)) or not all(isinstance(body, (*kinds, str)) for body in bodies):
        raise SceneError(f"{path}: must be a body, its name, or several ([one, two]), got {shown(on)}")
    return tuple(bodies)


def targeted(on: object, path: str) -> tuple[Target, ...] | None:
    """The validated value of `on=` of a force: bodies, names and selections of particles; None: all."""
    if on is None:
        return None
    one = isinstance(on, (Body, str)) or is_selection(on)
    several = (on,) if one else on
    if not isinstance(several, (tuple, list)) or not all(
        isinstance(each, (Body, str)) or is_selection(each) for each in several
    ):
        raise SceneError(
            f"{path}: must be a body, its name, or several ([one, two]), or some particles of a body "
            f"((body, [0, 1])), got {shown(on)}"
        )
    paths = [path if one else f"{path}[{place}]" for place in range(len(several))]
    return tuple(_target(each, own) for each, own in zip(several, paths, strict=True))


def _target(value: Target | tuple[Body | str, Any], path: str) -> Target:
    """A body, a name or a selection. A selection of all particles of a body is the body."""
    if isinstance(value, tuple):
        value = Selection(*value, path)
    return value.body if isinstance(value, Selection) and value.is_whole else value


def found(keys: Sequence[T | str], items: Iterable[T], path: str) -> tuple[T, ...]:
    """Items from a list of items and names. A name stands for all items that have it.

    Raises:
        SceneError: no item has such a name.
    """
    named: dict[str, list[T]] = {}
    for item in items:
        if getattr(item, "name", None) is not None:
            named.setdefault(item.name, []).append(item)  # type: ignore[attr-defined]
    for key in keys:
        if isinstance(key, str) and key not in named:
            names = ", ".join(map(repr, named)) or "none that has a name"
            raise SceneError(f"{path}: nothing is called {shown(key)}; there are {names}{did_you_mean(key, named)}")
    return tuple(item for key in keys for item in (named[key] if isinstance(key, str) else [key]))


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
            _check_once(targets, f"{type(self).__name__}.{name}")

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
        return replace(self, **{name: _known(keys, bodies, f"{path}.{name}") for name, keys in self._keys().items()})

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


def whole(target: Target | SceneItem) -> Any:
    """The body of a target, or its name; another item as it is."""
    return target.body if isinstance(target, Selection) else target


def _known(keys: Sequence[Target], bodies: Sequence[Body], path: str) -> tuple[Body | Selection, ...]:
    """The targets with the bodies of a scene in place of their names."""
    where = [f"{path}[{place}]" if len(keys) > 1 else path for place in range(len(keys))]
    named = [found([whole(key)], bodies, path)[0] for key in keys]
    return tuple(
        key.of(body, own) if isinstance(key, Selection) else body
        for key, body, own in zip(keys, named, where, strict=True)
    )


def _check_once(targets: Sequence[Target], path: str) -> None:
    """Check that no particle is named twice, as far as the bodies are known."""
    seen: dict[Body, BoolArray] = {}
    for place, target in enumerate(targets):
        body = whole(target)
        if not isinstance(body, str):
            own = target.mask if isinstance(target, Selection) else np.ones(len(body), dtype=np.bool_)
            again = seen.get(body, np.zeros_like(own)) & own
            if again.any():
                raise SceneError(f"{path}[{place}]: names particle {np.argmax(again)} of {body!r} again")
            seen[body] = seen.get(body, own) | own


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

    A force between particles acts between those that are named. On rigid bodies forces act at their centers of mass;
    those of short range between particles, and those on faces, do not act on them.
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


# To add a system: a module in `systems`, a line in `SYSTEMS`, and its counterpart in Rust.
@dataclass(frozen=True)
class System(SceneItem):
    """Base class of systems: a state with its own law of motion, in addition to the bodies."""

    section: ClassVar[str] = "systems"
    default_integrator: ClassVar[str] = "VelocityVerlet"
    """Name of the default integrator."""
    derived: ClassVar[tuple[str, ...]] = ()
    """Names of results that are computed from the others."""
    has_varying_limit: ClassVar[bool] = False
    """Whether the limit of stability depends on the values of the fields."""

    name: str | None = field(default=None, kw_only=True)
    """Name of the system, also a key into results."""

    @property
    def defaults(self) -> dict[str, Default]:
        """Arguments with a dimension that were left at their defaults, by name."""
        return {name: value for name, value in vars(self).items() if isinstance(value, Default)}

    def named(self) -> Mapping[str, tuple[Body | Selection | SceneItem, ...] | None]:
        """The systems that fields name, by field."""
        named = {name: getattr(self, name) for name in self.linking}
        return {name: (value,) for name, value in named.items() if getattr(value, "section", None) == self.section}

    @property
    @abstractmethod
    def elements(self) -> Mapping[Element, int]:
        """The kind of elements that have values, with their number."""

    def fields(self, path: str) -> Iterator[Field]:
        """The fields of the system in a scene, where its path is `path`."""
        (element,) = self.elements
        for name, shape in self.shapes().items():
            yield Field(f"{path}.{name}", self.units.get(name, "1"), element, shape, name)

    @property
    def primary(self) -> str:
        """Name of the field that films show and studies compare."""
        return next(iter(self.shapes()))

    @property
    def changing(self) -> str:
        """Name of the field that studies perturb: the second of the state, or the only one."""
        return [name for name in self.shapes() if name not in self.derived][:2][-1]

    @property
    def units(self) -> Mapping[str, str]:
        """The units of the fields by name; the primary field is first."""
        return {}

    @property
    def signed(self) -> bool:
        """Whether the first field has both signs, so that its color scale is symmetric about zero."""
        return True

    @property
    def solid(self) -> BoolArray | None:
        """Mask of the solid cells that are excluded from the fields; None if there are none."""
        return None

    @property
    @abstractmethod
    def dimension(self) -> int:
        """The number of dimensions of space."""

    @abstractmethod
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """The shapes of the fields by name, as in the engine."""

    def timed(self) -> Iterator[tuple[str, Callable[[float], object]]]:
        """The functions of time that the system depends on, with their paths within it."""
        return iter(())

    def unresolved(self, integrator: str) -> list[str]:
        """Notes on waves and fronts that the system does not resolve with an integrator of this name."""
        del integrator
        return []

    def values(self, field: str, value: object, path: str) -> FloatArray:
        """Validated new values of a field.

        Raises:
            SceneError: the value is not an array of finite numbers of the field's shape.
        """
        return broadcast(value, self.shapes()[field], path)  # type: ignore[arg-type]

    def shown(self, fields: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """The fields in the form of results, from the form of the engine; with or without a time axis."""
        return fields

    def __post_init__(self) -> None:
        self._set(name=None if self.name is None else text(self.name, f"{type(self).__name__}.name"))


# To add a constraint: a module in `constraints`, a line in `CONSTRAINTS`, and its counterpart in Rust.
@dataclass(frozen=True)
class Constraint(ActingItem):
    """Base class of constraints: conditions on the motion of bodies, such as mutual impenetrability."""

    section: ClassVar[str] = "constraints"
    element: ClassVar[Element | None] = None
    """Kind of the elements that have values: beads, one for each particle that it acts on, or joints, one for each
    constraint; None: there are none.
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
