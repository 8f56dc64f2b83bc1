"""Scene items that act on bodies: their parameters, whom they act on, and the bases of forces and boundaries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import ClassVar, TypeAlias, cast

import numpy as np

from physcore.checks import flag, number, shown
from physcore.errors import SceneError
from physcore.scene.bodies import Body

On: TypeAlias = Body | Sequence[Body] | None


def chosen(on: object, path: str) -> tuple[Body, ...] | None:
    """The bodies that `on=` names, checked; None: all."""
    if on is None:
        return None
    bodies = (on,) if isinstance(on, Body) else on
    if not isinstance(bodies, (tuple, list)) or not all(isinstance(body, Body) for body in bodies):
        raise SceneError(f"{path}: must be a body or several ([one, two]), got {shown(on)}")
    return tuple(bodies)


@dataclass(frozen=True)
class SceneItem:
    """Something that acts on bodies; its fields are plain numbers, tuples of numbers for vectors, or None."""

    on: On = field(default=None, kw_only=True)
    """The body or bodies that it acts on; None: all, but for fluids where it spares them."""

    kind: ClassVar[str]
    """The name of the class in hashes, files and the engine: its own, where it does not say another."""
    spares_fluids: ClassVar[bool] = False
    """Whether it acts on a fluid only where that is named."""
    is_code: ClassVar[bool] = False
    """Whether it is made of functions of the user's, which are not written into files."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if "kind" not in cls.__dict__:
            cls.kind = cls.__name__

    def __post_init__(self) -> None:
        self._set(on=chosen(self.on, f"{type(self).__name__}.on"))

    def _set(self, **values: object) -> None:
        """Replace what the user passed by its checked form; only for `__post_init__`."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def bodies(self) -> tuple[Body, ...] | None:
        """The bodies that it names, or None."""
        return cast("tuple[Body, ...] | None", self.on)  # made so by __post_init__

    def check(self, bodies: Sequence[Body], path: str) -> None:
        """Look at the bodies that it acts on, once they are known; `path` says where it stands in the scene.

        Raises:
            SceneError: it cannot act on them.
        """

    def parameters(self) -> dict[str, object]:
        """Every field but `on`, by name."""
        return {entry.name: getattr(self, entry.name) for entry in fields(self) if entry.name != "on"}

    def mismatch(self, dimension: int) -> str | None:
        """The name of the first vector that has not `dimension` components, or None."""
        return next(
            (name for name, value in self.parameters().items() if isinstance(value, tuple) and len(value) != dimension),
            None,
        )

    def describe(self, dimension: int) -> dict[str, object]:
        """The name of its kind and its parameters, as the engine reads them in a scene of `dimension` dimensions."""
        del dimension
        values = {
            name: np.array(value) if isinstance(value, tuple) else value for name, value in self.parameters().items()
        }
        return {"type": self.kind, **values}


@dataclass(frozen=True)
class Force(SceneItem):
    """A force on the particles of some bodies.

    To add one: a file in `forces`, a line in `FORCES`, and its counterpart in Rust.
    """


@dataclass(frozen=True)
class Boundary(SceneItem):
    """A wall that particles bounce off.

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
