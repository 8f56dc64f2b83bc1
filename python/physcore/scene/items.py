"""Scene items beside bodies: their parameters, whom they act on, and the bases of the kinds."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import ClassVar, Literal, Self, TypeAlias, TypeVar, cast

import numpy as np

from physcore.checks import FloatArray, broadcast, flag, frozen, number, shown, text
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.spelling import did_you_mean

On: TypeAlias = Body | str | Sequence[Body | str] | None
"""Bodies, by themselves or by their names; None: all."""
T = TypeVar("T")


def chosen(on: object, path: str, kinds: tuple[type, ...] = (Body,)) -> tuple[Body | str, ...] | None:
    """The bodies, or other kinds of items, that `on=` says, checked, by themselves or by their names; None: all."""
    if on is None:
        return None
    bodies = (on,) if isinstance(on, (*kinds, str)) else on
    if not isinstance(bodies, (tuple, list)) or not all(isinstance(body, (*kinds, str)) for body in bodies):
        raise SceneError(f"{path}: must be a body, its name, or several ([one, two]), got {shown(on)}")
    return tuple(bodies)


def found(keys: Sequence[T | str], items: Iterable[T], path: str) -> tuple[T, ...]:
    """Items, where some are given by their names; all that have a name.

    Raises:
        SceneError: there is none of a name.
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
    """Something in a scene beside bodies; its fields are plain numbers, tuples of numbers for vectors, or None."""

    parts: ClassVar[tuple[type, ...]] = ()
    """The classes of the things that its fields hold, which files have too."""

    def _set(self, **values: object) -> None:
        """Replace what the user passed by its checked form; only for `__post_init__`."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __setstate__(self, state: dict[str, object]) -> None:
        """A copy, or what comes out of a pickle, has read-only arrays too."""
        self._set(**{name: frozen(value) if isinstance(value, np.ndarray) else value for name, value in state.items()})

    def mismatch(self, dimension: int) -> tuple[str, int] | None:
        """The name and the size of the first vector that has not `dimension` components, or None."""
        vectors = {entry.name: getattr(self, entry.name) for entry in fields(self) if entry.name != "on"}
        wrong = (
            (name, len(value))
            for name, value in vectors.items()
            if isinstance(value, tuple) and _is_vector(value) and len(value) != dimension
        )
        return next(wrong, None)

    def resolved(self, dimension: int) -> SceneItem:
        """What stands for it in a scene of `dimension` dimensions: the engine simulates that, and films draw it."""
        del dimension
        return self


def _is_vector(value: tuple[object, ...]) -> bool:
    """Whether a tuple is one of numbers; others hold words or parts of an item."""
    return bool(value) and all(isinstance(each, (int, float)) for each in value)


@dataclass(frozen=True)
class ActingItem(SceneItem):
    """Something that acts on bodies."""

    on: On = field(default=None, kw_only=True)
    """The body or bodies that it acts on, or their names; None: all, but for fluids where it spares them."""

    spares_fluids: ClassVar[bool] = False
    """Whether it acts on a fluid only where that is named."""
    naming: ClassVar[tuple[str, ...]] = ("on",)
    """Its fields that name bodies."""

    def __post_init__(self) -> None:
        self._set(**{name: chosen(getattr(self, name), f"{type(self).__name__}.{name}") for name in self.naming})

    @property
    def by_name(self) -> bool:
        """Whether it says some bodies by their names: until it is in a scene, it does not know them."""
        return any(isinstance(each, str) for keys in self._keys().values() for each in keys)

    def _keys(self) -> dict[str, tuple[Body | str, ...]]:
        """What its fields name, where they do."""
        given = {name: chosen(getattr(self, name), f"{type(self).__name__}.{name}") for name in self.naming}
        return {name: keys for name, keys in given.items() if keys is not None}

    def among(self, bodies: Sequence[Body], path: str) -> Self:
        """The same item, with the bodies of a scene in the place of their names.

        Raises:
            SceneError: there is none of a name, or it cannot be acted on.
        """
        if not self.by_name:
            return self
        return replace(self, **{name: found(keys, bodies, f"{path}.{name}") for name, keys in self._keys().items()})

    def bodies(self, field: str = "on") -> tuple[Body, ...] | None:
        """The bodies that it names in a field, or None; of an item of a scene."""
        return cast("tuple[Body, ...] | None", getattr(self, field))  # made so by __post_init__ and `among`

    def check(self, bodies: Sequence[Body], path: str) -> None:
        """Look at the bodies that it acts on, once they are known; `path` says where it stands in the scene.

        Raises:
            SceneError: it cannot act on them.
        """


@dataclass(frozen=True)
class Force(ActingItem):
    """A force on the particles of some bodies.

        scene.forces  # (Gravity(…),)
        all(isinstance(force, pc.Force) for force in scene.forces)  # True

    To add one: a file in `forces`, a line in `FORCES`, and its counterpart in Rust.
    """

    feels_charges: ClassVar[bool] = False
    """Whether it may act on the charges of bodies."""


Equation = Literal["bodies", "second order", "first order", "schrodinger", "flow"]
"""The kind of an equation of motion, which says what integrators can advance it: x'' = a(x, v, t) of all bodies, and of
a field; x' = f(x, t); iħ ψ' = H ψ; incompressible flow."""


@dataclass(frozen=True)
class System(SceneItem):
    """A state with a law of motion of its own, beside that of the bodies.

    To add one: a file in `systems`, a line in `SYSTEMS`, and its counterpart in Rust.
    """

    equation: ClassVar[Equation] = "second order"
    """The kind of its equation of motion."""
    default_integrator: ClassVar[str] = "VelocityVerlet"
    """The name of the integrator that advances it where nothing is said."""
    naming: ClassVar[tuple[str, ...]] = ()
    """Its fields that may name another system of the scene."""
    derived: ClassVar[tuple[str, ...]] = ()
    """The names of its results that follow from the others."""

    name: str | None = field(default=None, kw_only=True)
    """A name by which results can be asked for."""

    def named(self) -> dict[str, System]:
        """The systems that it names, by field."""
        return {name: value for name in self.naming if isinstance(value := getattr(self, name), System)}

    @property
    def units(self) -> Mapping[str, str]:
        """Its fields by name, with their units; the first one is that which is shown, and compared between runs."""
        return {}

    @property
    def signed(self) -> bool:
        """Whether that field is as often below zero as above: its colors are then symmetric about zero."""
        return True

    @property
    @abstractmethod
    def dimension(self) -> int:
        """The number of dimensions of space."""

    @abstractmethod
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """The shapes of its fields by name, as the engine has them."""

    def values(self, field: str, value: object, path: str) -> FloatArray:
        """New values of one of its fields, checked.

        Raises:
            SceneError: they are no array of finite numbers of its shape.
        """
        return broadcast(value, self.shapes()[field], path)  # type: ignore[arg-type]

    def shown(self, fields: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """The fields as results have them, of fields as the engine has them; over time or not."""
        return fields

    def __post_init__(self) -> None:
        self._set(name=None if self.name is None else text(self.name, f"{type(self).__name__}.name"))


@dataclass(frozen=True)
class Constraint(ActingItem):
    """A condition on the motion of bodies, such as that they do not pass through each other.

    To add one: a file in `constraints`, a line in `CONSTRAINTS`, and its counterpart in Rust.
    """


@dataclass(frozen=True)
class Boundary(ActingItem):
    """A wall that particles bounce off.

        floor = pc.Floor(restitution=0.5, friction=0.3)
        isinstance(floor, pc.Boundary)  # True

    To add one: a file in `boundaries`, a line in `BOUNDARIES`, and its counterpart in Rust.

    A contact happens at center ± radius. It turns the normal velocity v_n into −restitution · v_n, and the tangential
    impulse follows Coulomb: at most friction times the normal impulse, and never more than what stops the sliding.
    What a contact takes counts as dissipated.
    """

    restitution: float = field(default=1.0, kw_only=True)
    """Ratio of the normal speeds after and before a contact, from 0 (no bounce) to 1 (no loss)."""
    friction: float = field(default=0.0, kw_only=True)
    """Coulomb's coefficient of friction, at least zero."""
    no_slip: bool = field(default=False, kw_only=True)
    """Whether fluids stick to it; by default they slip along it freely."""

    def __post_init__(self) -> None:
        super().__post_init__()
        kind = type(self).__name__
        self._set(
            restitution=number(self.restitution, f"{kind}.restitution", least=0.0, most=1.0),
            friction=number(self.friction, f"{kind}.friction", least=0.0),
            no_slip=flag(self.no_slip, f"{kind}.no_slip"),
        )
