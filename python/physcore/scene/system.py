"""Base class of systems: states with their own laws of motion, in addition to the bodies."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from physcore.checks import BoolArray, FloatArray, broadcast, text
from physcore.scene.bodies import Body
from physcore.scene.fields import Element, Field
from physcore.scene.items import SceneItem
from physcore.scene.selection import Selection
from physcore.units.systems import Default


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
    def ranged(self) -> bool:
        """Whether nothing is known of the values of fields: their color scales go from the smallest to the largest."""
        return False

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
