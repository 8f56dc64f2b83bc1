"""What forces and boundaries have in common: parameters, and the bodies that they act on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import ClassVar, TypeAlias, cast

import numpy as np

from physcore.bodies import Body
from physcore.checks import shown
from physcore.errors import SceneError

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
class Influence:
    """Something that acts on bodies; its fields are plain numbers, tuples of numbers for vectors, or None."""

    on: On = field(default=None, kw_only=True)
    """The body or bodies that it acts on; None: all, but for fluids where it spares them."""

    spares_fluids: ClassVar[bool] = False
    """Whether it acts on a fluid only where that is named."""

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
        return {"type": type(self).__name__, **values}
