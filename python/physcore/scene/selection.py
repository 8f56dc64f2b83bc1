"""Selections: some particles of a body, as the argument `on=` of forces names them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from physcore.checks import BoolArray, IntArray, frozen, regular, shown
from physcore.errors import SceneError
from physcore.scene.bodies import Body

MANY = 8
"""Number of indices that a `repr` shows."""


@dataclass(frozen=True, eq=False, repr=False)
class Selection:
    """Some particles of a body. The indices are in ascending order once the body is known."""

    body: Body | str
    """The body or its name."""
    index: slice | IntArray | BoolArray
    """The indices of the particles; for a name, an index in any form of NumPy's."""
    path: str = field(default="on")
    """Path of the selection, for messages."""

    def __post_init__(self) -> None:
        index = self.index if isinstance(self.index, slice) else _indices(self.index, self.path)
        object.__setattr__(self, "index", index)
        if isinstance(self.body, Body):
            object.__setattr__(self, "index", _resolved(index, self.body, self.path))

    def __setstate__(self, state: dict[str, object]) -> None:
        """Make the indices of a copy or an unpickled selection read-only."""
        for name, value in state.items():
            object.__setattr__(self, name, frozen(value) if isinstance(value, np.ndarray) else value)

    def of(self, body: Body, path: str) -> Selection:
        """The selection from the body that the name stands for.

        Raises:
            SceneError: an index is outside of the body, occurs twice, or there is none.
        """
        return replace(self, body=body, path=path)

    @property
    def is_whole(self) -> bool:
        """Whether all particles of a known body are selected."""
        return isinstance(self.body, Body) and bool(self.mask.all())

    @property
    def mask(self) -> BoolArray:
        """Whether each particle of the body is selected; only for a known body."""
        selected = np.zeros(len(self.body), dtype=np.bool_)
        selected[self.index] = True
        return selected

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Selection) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    def __repr__(self) -> str:
        return f"({self.body!r}, {_written(self.index)})"

    @property
    def _key(self) -> tuple[object, ...]:
        """The body and the index, as values that can be compared."""
        if isinstance(self.index, slice):
            return self.body, self.index.start, self.index.stop, self.index.step
        return self.body, self.index.dtype.kind, self.index.tobytes()


def is_selection(value: object) -> bool:
    """Whether a value is a selection, or a tuple of a body or its name and an index."""
    if isinstance(value, Selection):
        return True
    if not isinstance(value, tuple) or len(value) != 2 or not isinstance(value[0], (Body, str)):
        return False
    return not isinstance(value[1], (Body, str)) and not is_selection(value[1])


def _indices(value: object, path: str) -> IntArray | BoolArray:
    """Integer indices or a mask, one-dimensional; without regard to the number of particles."""
    given = regular(value, path)
    scalar = given.ndim == 0 and given.dtype.kind in "iu"
    if not scalar and (given.ndim != 1 or (given.size and given.dtype.kind not in "biu")):
        raise SceneError(
            f"{path}: must select particles by an integer, a slice, integer indices or a bool mask, got {shown(value)}"
        )
    kind = np.bool_ if given.dtype.kind == "b" else np.int64
    if given.dtype.kind == "u" and given.size and given.max() > np.iinfo(np.int64).max:
        raise SceneError(f"{path}: index {given.max()} is beyond the particles of any body")
    return frozen(np.atleast_1d(given).astype(kind))


def _resolved(index: slice | IntArray | BoolArray, body: Body, path: str) -> IntArray:
    """Ascending indices of the selected particles of a body."""
    count = len(body)
    if isinstance(index, slice):
        try:
            chosen = np.arange(count)[index]
        except (TypeError, ValueError) as error:
            raise SceneError(f"{path}: must be a slice of whole numbers, got {shown(index)} ({error})") from None
    elif index.dtype == np.bool_:
        if len(index) != count:
            raise SceneError(f"{path}: a mask of {body!r} must have {count} entries, got {len(index)}")
        chosen = np.flatnonzero(index)
    else:
        outside = (index < -count) | (index >= count)
        if outside.any():
            raise SceneError(f"{path}: index {index[outside][0]} is outside of {body!r}")
        chosen = np.where(index < 0, index + count, index)
    ascending = np.sort(chosen).astype(np.int64)
    if not len(ascending):
        raise SceneError(f"{path}: must select at least one particle of {body!r}, got {_written(index)}")
    again = ascending[1:][ascending[1:] == ascending[:-1]]
    if len(again):
        raise SceneError(f"{path}: selects particle {again[0]} of {body!r} more than once")
    return frozen(ascending)


def _written(index: slice | IntArray | BoolArray) -> str:
    """An index in a `repr`, shortened if it is long."""
    if isinstance(index, slice):
        return repr(index)
    entries = [*map(repr, index[:MANY].tolist()), *(["…"] if len(index) > MANY else [])]
    return f"[{', '.join(entries)}]"
