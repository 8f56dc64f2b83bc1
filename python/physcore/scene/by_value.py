"""Frozen dataclasses with arrays, compared by value."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from physcore.checks import frozen


@dataclass(frozen=True, eq=False, repr=False)
class ByValue:
    """Base class of frozen dataclasses whose fields may be arrays; equal if all fields are.

    Subclasses are dataclasses with `eq=False` and `repr=False`.
    """

    def _key(self) -> tuple[object, ...]:
        """All values, with arrays as their shapes and bytes."""
        values = (getattr(self, entry.name) for entry in fields(self))
        return tuple((each.shape, each.tobytes()) if isinstance(each, np.ndarray) else each for each in values)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ByValue) and type(self) is type(other) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash((type(self), self._key()))

    def __repr__(self) -> str:
        """The call that makes it, with arrays as their shapes."""
        values = {entry.name: getattr(self, entry.name) for entry in fields(self) if entry.repr}
        return f"{type(self).__name__}({', '.join(f'{name}={_brief(value)}' for name, value in values.items())})"

    def __setstate__(self, state: dict[str, object]) -> None:
        """Make the arrays of a copy or an unpickled object read-only."""
        for name, value in state.items():
            object.__setattr__(self, name, frozen(value) if isinstance(value, np.ndarray) else value)


def _brief(value: object) -> str:
    """A value as text, an array as its shape."""
    return f"array {value.shape}" if isinstance(value, np.ndarray) else repr(value)
