"""Colors of particles chosen by the user: one color, one per body or particle, values on a scale, or a function."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from physcore.checks import FloatArray, frozen, regular, shown
from physcore.errors import SceneError
from physcore.film.colors.themes import Color, color
from physcore.scene.bodies import Body

ColorFunction: TypeAlias = Callable[[float, FloatArray, FloatArray | None], ArrayLike]
"""Function of the time [s], the positions [m] and the velocities [m/s], both of shape (N, D), that returns values (N,)
or colors (N, 3). The velocities are None if they were not recorded.
"""

ColorChoice: TypeAlias = str | Color | Mapping[Body | str, str | Color] | ArrayLike | Sequence[str] | ColorFunction
"""All valid choices of a user."""


class PerParticle:
    """Values (N,) or colors (N, 3), one for each particle; equality compares the contents."""

    def __init__(self, values: NDArray[Any]) -> None:
        self.values: FloatArray = frozen(np.array(values, dtype=float, order="C"))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PerParticle) and np.array_equal(self.values, other.values)

    def __hash__(self) -> int:
        return hash((self.values.shape, self.values.tobytes()))

    def __repr__(self) -> str:
        return f"PerParticle({self.values.shape})"


class PerBody:
    """Colors by body, or by the name of a body."""

    def __init__(self, colors: Mapping[Body | str, Color]) -> None:
        self.colors = dict(colors)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PerBody) and self.colors == other.colors

    def __hash__(self) -> int:
        return hash(tuple(self.colors.values()))

    def __repr__(self) -> str:
        return f"PerBody({self.colors})"

    def of(self, body: Body) -> Color | None:
        """The color of a body; None if no color was chosen for it."""
        return self.colors.get(body, self.colors.get(body.name) if body.name is not None else None)


Chosen: TypeAlias = Color | PerBody | PerParticle | ColorFunction
"""A validated choice."""


def chosen(value: object, path: str, words: Sequence[str]) -> Chosen:
    """Validate a choice that is not one of the style's own words.

    Raises:
        SceneError: the value does not give a color.
    """
    if isinstance(value, (PerBody, PerParticle)):
        return value
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, (Body, str)):
                raise SceneError(f"{path}: keys must be bodies or their names, got {shown(key)}")
        return PerBody({key: color(each, f"{path}[{shown(key)}]") for key, each in value.items()})
    if callable(value):
        return value
    whole = isinstance(value, tuple) and len(value) == 3 and all(isinstance(each, int) for each in value)
    if isinstance(value, str) or whole:
        try:
            return color(value, path)
        except SceneError as error:
            known = ", ".join(map(repr, words))
            raise SceneError(f"{error}; or one of {known}") from None
    if isinstance(value, (list, tuple)) and value and all(isinstance(each, str) for each in value):
        return PerParticle(np.array([color(each, f"{path}[{index}]") for index, each in enumerate(value)]))
    return PerParticle(numbers(value, path))


def numbers(value: object, path: str) -> FloatArray:
    """Values (N,), or colors (N, 3). Integer colors are from 0 to 255, floating-point colors from 0 to 1.

    Raises:
        SceneError: the value is neither.
    """
    given = regular(value, path)
    right = given.ndim == 1 or (given.ndim == 2 and given.shape[1] == 3)
    if not right or given.dtype.kind not in "iufb":
        raise SceneError(
            f"{path}: must be a color, a mapping from bodies to colors, values (N,), colors (N, 3) or a function, "
            f"got {given.dtype} of shape {given.shape}"
        )
    values: FloatArray = given.astype(float)
    if not np.isfinite(values).all():
        raise SceneError(f"{path}: must be finite, got {shown(values[~np.isfinite(values)][0])}")
    if given.ndim == 2:
        values = values * 255.0 if given.dtype.kind == "f" else values
        if values.min(initial=0.0) < 0.0 or values.max(initial=0.0) > 255.0:
            raise SceneError(f"{path}: colors must be integers from 0 to 255, or fractions from 0 to 1")
    return values
