"""Grid of a sweep: the values of each parameter, and which of them are arguments of `build` or numerical choices."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from physcore.checks import items, shown
from physcore.errors import SceneError
from physcore.numerics.choices import Options
from physcore.spelling import did_you_mean

SIMPLE = (bool, int, float, str)
"""Kinds of values that can be compared."""


@dataclass(frozen=True, eq=False)
class ParameterGrid:
    """Values of each parameter by name; the last parameter varies fastest."""

    axes: dict[str, list[Any]]
    built: frozenset[str]
    """Names of the parameters that are arguments of `build`. The others are numerical choices."""

    @classmethod
    def of(cls, build: Callable[..., object], parameters: object, fixed: Mapping[str, object]) -> ParameterGrid:
        """The grid of some parameters.

        Args:
            build: the function that builds a scene.
            parameters: the values of each parameter by name.
            fixed: the numerical choices that all points share.

        Raises:
            SceneError: a parameter has no values, is given twice, or is unknown, or `build` lacks an argument.
        """
        if not callable(build):
            raise SceneError(f"build: must be a function that returns a Scene, got {shown(build)}")
        if not isinstance(parameters, Mapping) or not all(isinstance(name, str) for name in parameters):
            raise SceneError(
                f"parameters: must be a mapping from names to lists of values, such as {{'mass': [1.0, 2.0]}}, got "
                f"{shown(parameters)}"
            )
        if not parameters:
            raise SceneError("parameters: must not be empty")
        axes = {name: _values(each, f"parameters[{name!r}]") for name, each in parameters.items()}
        own = _arguments(build)
        grid = cls(axes, frozenset(_taken(build, own, axes)))
        for name in axes:
            if name not in (*grid.built, *Options.__annotations__):
                hint = did_you_mean(name, (*own, *Options.__annotations__))
                raise SceneError(f"parameters[{name!r}]: is neither an argument of build nor a numerical choice{hint}")
        for name in fixed:
            if name in axes:
                raise SceneError(f"{name}: is a parameter of the sweep too; leave one of them out")
            if name in own:
                raise SceneError(f"{name}: is an argument of build; give it in parameters, with one value or several")
        return grid

    def __len__(self) -> int:
        return int(np.prod([len(values) for values in self.axes.values()]))

    def points(self) -> list[dict[str, Any]]:
        """The parameters of each point, in order."""
        return [dict(zip(self.axes, values, strict=True)) for values in product(*self.axes.values())]


def _values(given: object, path: str) -> list[Any]:
    """The values of a parameter, with the numbers of NumPy as those of Python."""
    values = [each.item() if isinstance(each, np.generic) else each for each in items(given, path, "values")]
    if not values:
        raise SceneError(f"{path}: must have at least one value")
    for index, value in enumerate(values):
        if any(type(value) is type(other) and isinstance(value, SIMPLE) and value == other for other in values[:index]):
            raise SceneError(f"{path}: has the value {shown(value)} twice")
    return values


def _arguments(build: Callable[..., object]) -> Mapping[str, inspect.Parameter]:
    """The arguments of a function by name; none for those functions that have no signature."""
    try:
        return inspect.signature(build).parameters
    except (TypeError, ValueError):
        return {}


def _taken(build: Callable[..., object], own: Mapping[str, inspect.Parameter], names: Collection[str]) -> list[str]:
    """Names that are arguments of a function, among some.

    Raises:
        SceneError: the function has a further argument without a default.
    """
    if not own:
        return [name for name in names if name not in Options.__annotations__]
    kinds = {each.kind for each in own.values()}
    several = (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
    for name, each in own.items():
        if each.default is each.empty and each.kind not in several and name not in names:
            raise SceneError(
                f"build: needs the argument {name!r}; give its values in parameters{did_you_mean(name, names)}"
            )
    return [name for name in names if name in own or inspect.Parameter.VAR_KEYWORD in kinds]
