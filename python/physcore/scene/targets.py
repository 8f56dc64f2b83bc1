"""Targets of an item: bodies, their names, and some of their particles."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from physcore.checks import BoolArray, shown
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.selection import Selection, is_selection
from physcore.spelling import did_you_mean

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


def whole(target: object) -> Any:
    """The body of a target, or its name; another item as it is."""
    return target.body if isinstance(target, Selection) else target


def known(keys: Sequence[Target], bodies: Sequence[Body], path: str) -> tuple[Body | Selection, ...]:
    """The targets with the bodies of a scene in place of their names."""
    where = [f"{path}[{place}]" if len(keys) > 1 else path for place in range(len(keys))]
    named = [found([whole(key)], bodies, path)[0] for key in keys]
    return tuple(
        key.of(body, own) if isinstance(key, Selection) else body
        for key, body, own in zip(keys, named, where, strict=True)
    )


def require_once(targets: Sequence[Target], path: str) -> None:
    """Check that no particle is named twice, as far as the bodies are known.

    Raises:
        SceneError: one is.
    """
    seen: dict[Body, BoolArray] = {}
    for place, target in enumerate(targets):
        body = whole(target)
        if not isinstance(body, str):
            own = target.mask if isinstance(target, Selection) else np.ones(len(body), dtype=np.bool_)
            again = seen.get(body, np.zeros_like(own)) & own
            if again.any():
                raise SceneError(f"{path}[{place}]: names particle {np.argmax(again)} of {body!r} again")
            seen[body] = seen.get(body, own) | own
