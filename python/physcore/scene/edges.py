"""Conditions at the edges of a grid: values, gradients and absorbing layers."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from physcore.checks import array, called, count, frozen, is_word, number, regular, shown
from physcore.errors import SceneError
from physcore.scene.by_value import ByValue

WIDEST = 4096
"""Largest width of an absorbing layer [cells]."""

Timed: TypeAlias = ArrayLike | Callable[[float], ArrayLike]
"""A number, an array along a side, or a function of the time [s] that returns one."""


@dataclass(frozen=True)
class Absorbing:
    """Absorbing layer outside of an edge of a grid, in which waves decay. The layer is not included in totals.

        grid = pc.Grid((100, 60), spacing=0.1)
        pond = pc.Wave(grid, speed=1.0, edges={"x": pc.Absorbing(), "y": "free"})

    The flux across the edge counts as dissipated, or removed, by "edges"; an inward flux counts as negative.

    Args:
        cells: width of the layer [cells]; "auto": a width that suits the system, stated in the plan.
        reflection: ratio of the reflected to the incident amplitude at normal incidence, between 0 and 1.

    Raises:
        SceneError: a value is out of range.
    """

    cells: int | Literal["auto"] = "auto"
    reflection: float = 1e-6

    def __post_init__(self) -> None:
        if not is_word(self.cells, "auto"):
            object.__setattr__(self, "cells", count(self.cells, "Absorbing.cells", least=1, most=WIDEST))
        reflection = number(self.reflection, "Absorbing.reflection", above=0.0)
        if reflection >= 1.0:
            raise SceneError(f"Absorbing.reflection: must be < 1, got {reflection:g}")
        object.__setattr__(self, "reflection", reflection)


@dataclass(frozen=True, eq=False, repr=False)
class Valued(ByValue):
    """Base class of edge conditions with a value."""

    key: ClassVar[str]
    """Name of the value."""

    uniform: bool = field(init=False, repr=False, default=True)
    """Whether the value is one number for the whole side, at each time."""

    def __post_init__(self) -> None:
        path = f"{type(self).__name__}.{self.key}"
        value: Timed = getattr(self, self.key)
        if callable(value):
            shape = array(called(value, path, 0.0), f"{path}: its value").shape
        else:
            shape = regular(value, path).shape
            value = frozen(array(value, path)) if shape else number(value, path)
        object.__setattr__(self, self.key, value)
        object.__setattr__(self, "uniform", shape == ())

    def check(self, side: tuple[int, ...], path: str) -> None:
        """Check that an array fits a side with so many cells along each axis.

        Raises:
            SceneError: the shapes differ.
        """
        value = getattr(self, self.key)
        shape = np.shape(value(0.0) if callable(value) else value)
        if shape not in ((), side):
            expected = f"a number or an array of the shape {side} of the side" if side else "a number, on a grid in 1D"
            raise SceneError(f"{path}.{self.key}: must be {expected}, got the shape {shape}")

    @abstractmethod
    def outer(self, nearest: float, spacing: float) -> float:
        """The value on the face in 1D, from that of the adjacent cell."""


@dataclass(frozen=True, eq=False, repr=False)
class Dirichlet(Valued):
    """Dirichlet condition at an edge of a grid: the field has a given value on the outer face of the outer cells.

        grid = pc.Grid(50, spacing=0.02)
        rod = pc.ReactionDiffusion(grid, pc.Reaction(("T",), lambda T: (0 * T,)), {"T": 1e-2}, {"T": 20.0},
                                   edges={"x-": pc.Dirichlet(100.0), "x+": pc.Dirichlet(20.0)})
        string = pc.Wave(grid, speed=1.0, edges={"x-": pc.Dirichlet(lambda t: 0.1 * np.sin(5.0 * t)), "x+": "fixed"})

    `"fixed"` is `Dirichlet(0.0)`. What flows through the edge is booked: amounts of species as supplied and removed by
    "edges", the energy that a wave is given as work. A constant value does no work.

    Args:
        value: the value on the side, in the unit of the field. A number, or an array with one number for each cell
            along the side: of shape (ny,) at the sides of x in 2D, (nx, nz) at those of y in 3D. Or a function of the
            time [s] that returns either; it is called at least once per stage, and
            must depend on the time alone.

    Raises:
        SceneError: the value is not finite, or the function fails at the time 0.
    """

    value: Timed = 0.0
    key: ClassVar[str] = "value"

    def outer(self, nearest: float, spacing: float) -> float:
        """The value; of a function, that of the adjacent cell."""
        del spacing
        return nearest if callable(self.value) else float(self.value)  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False, repr=False)
class Neumann(Valued):
    """Neumann condition at an edge of a grid: the field has a given outward derivative on the face of the outer cells.

        grid = pc.Grid((40, 30), spacing=0.1)
        plate = pc.ReactionDiffusion(grid, pc.Reaction(("T",), lambda T: (0 * T,)), {"T": 1e-2}, {"T": 20.0},
                                     edges={"x-": pc.Neumann(50.0), "x+": pc.Dirichlet(20.0)})

    `"free"` is `Neumann(0.0)`. A positive gradient is an inflow: D ∂u/∂n per area of the side of a species, the force ρ
    c² ∂u/∂n per area on a wave. It is booked as by `Dirichlet`.

    Args:
        gradient: derivative ∂u/∂n along the outward normal, in the unit of the field per meter. A number, an array or a
            function of the time, as in `Dirichlet`.

    Raises:
        SceneError: the gradient is not finite, or the function fails at the time 0.
    """

    gradient: Timed = 0.0
    key: ClassVar[str] = "gradient"

    def outer(self, nearest: float, spacing: float) -> float:
        """The value of the adjacent cell and half the difference across it; of a function, without the difference."""
        return nearest if callable(self.gradient) else nearest + 0.5 * spacing * float(self.gradient)  # type: ignore[arg-type]


Condition: TypeAlias = str | Dirichlet | Neumann
"""Condition at a side: "fixed", "free", "absorbing" or "periodic", or one with a value."""


def holds_value(condition: Condition) -> bool:
    """Whether a condition prescribes the value of the field."""
    return isinstance(condition, Dirichlet) or condition == "fixed"


class Sides(tuple[Condition, ...]):
    """Edge conditions of the sides of a grid, in the order x−, x+, y−, y+, z−, z+."""

    __slots__ = ()
    names: ClassVar[tuple[str, ...]] = ("x-", "x+", "y-", "y+", "z-", "z+")
    """Names of the sides."""

    def __getitem__(self, side: Any) -> Any:
        """The condition of a side by its name, as `edges["x-"]`, or by its place."""
        return super().__getitem__(self.names.index(side) if isinstance(side, str) else side)


def absorbing_layer(given: object, found: Absorbing | None, conditions: Sides, path: str) -> Absorbing:
    """The layer of absorbing edges: that of the conditions, or the one that is given beside them.

    Raises:
        SceneError: the two differ, or a layer is given and no edge is absorbing.
    """
    if given is None:
        return found or Absorbing()
    if not isinstance(given, Absorbing):
        raise SceneError(f"{path}: must be Absorbing(…), got {shown(given)}")
    if found is not None and found != given:
        raise SceneError(f"{path}: edges have {found} already, got {given}")
    # Records hold a layer always.
    if given != Absorbing() and "absorbing" not in conditions:
        raise SceneError(f'{path}: no edge is absorbing; give edges="absorbing", or some, as {{"x-": "absorbing"}}')
    return given


def condition(
    given: object, periodic: bool, path: str, words: Collection[str], side: tuple[int, ...] | None
) -> Condition:
    """The validated condition of one side.

    Args:
        given: a word, or an edge condition.
        periodic: whether the axis is periodic.
        path: path of the condition.
        words: known words.
        side: number of cells along the axes of the side; None: conditions with values are not valid.
    """
    if periodic:
        return "periodic"
    given = "absorbing" if isinstance(given, Absorbing) else given
    if side is not None and isinstance(given, (Dirichlet, Neumann)):
        given.check(side, path)
        return given
    if not isinstance(given, str) or given not in words:
        hint = "; periodic axes are said by the grid: Grid(…, periodic=True)" if is_word(given, "periodic") else ""
        *others, last = [*map(repr, words), *([] if side is None else ["Dirichlet(…)", "Neumann(…)"])]
        raise SceneError(f"{path}: must be {', '.join(others)} or {last}, got {shown(given)}{hint}")
    return given
