"""Uniform grids: geometry, fields, edges, and the base class of systems on a grid."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from physcore import memory
from physcore.checks import (
    LONGEST,
    BoolArray,
    FloatArray,
    array,
    called,
    count,
    flag,
    frozen,
    is_word,
    items,
    number,
    regular,
    shown,
    span,
)
from physcore.errors import SceneError
from physcore.scene.edges import Absorbing, Condition, Sides, Valued, condition
from physcore.scene.fields import Element
from physcore.scene.system import System

AXES = "xyz"
"""Names of the axes."""
MOST_CELLS = 2**31
"""Largest number of cells along an axis."""

Field: TypeAlias = ArrayLike | Callable[..., ArrayLike]
"""A field on a grid: a number, an array of its shape, or a function of the coordinate arrays."""


@dataclass(frozen=True)
class Grid:
    """Uniform grid of cells in 1D, 2D or 3D.

    Fields are arrays of shape `cells`, indexed [i, j, k] along x, y, z. Their values are at the centers of the cells,
    origin + (i + ½) h:

        grid = pc.Grid((64, 32), spacing=0.1)
        x, y = np.moveaxis(grid.centers, -1, 0)

    Args:
        cells: number of cells along each axis: (nx,), (nx, ny) or (nx, ny, nz); in 1D also an integer.
        spacing: the edge h of a cell [m], the same along all axes.
        origin: the lower corner [m]; a single number is used for all axes.
        periodic: whether the axes are periodic, one flag for all or one for each axis.

    Raises:
        SceneError: a value is out of range, or the number of values differs from the number of axes.
    """

    cells: tuple[int, ...]
    spacing: float
    origin: tuple[float, ...] = 0.0  # type: ignore[assignment]  # converted to a tuple below
    periodic: tuple[bool, ...] = False  # type: ignore[assignment]

    def __post_init__(self) -> None:
        given: object = self.cells
        if isinstance(given, (int, np.integer)):
            given = (given,)
        each = items(given, "Grid.cells", "whole numbers, one for each axis")
        if not 1 <= len(each) <= len(AXES):
            raise SceneError(f"Grid.cells: must be 1, 2 or 3 numbers, one for each axis, got {shown(self.cells)}")
        cells = tuple(count(entry, f"Grid.cells[{axis}]", least=1, most=MOST_CELLS) for axis, entry in enumerate(each))
        memory.require(8.0 * math.prod(cells), f"{math.prod(cells):.4g} cells", "Grid.cells", "make the spacing larger")
        origin = _per_axis(self.origin, len(cells), "Grid.origin", _place)
        values = {
            "cells": cells,
            "spacing": span(self.spacing, "Grid.spacing"),
            "origin": origin,
            "periodic": _per_axis(self.periodic, len(cells), "Grid.periodic", flag),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @classmethod
    def over(
        cls, lower: ArrayLike, upper: ArrayLike, spacing: float, periodic: bool | tuple[bool, ...] = False
    ) -> Grid:
        """The grid that covers a box, with round((upper − lower) / spacing) cells along each axis, starting at `lower`.

        Args:
            lower, upper: corners [m], one number for each axis; a number in 1D.
            spacing: the edge of a cell [m]. If an extent is not a multiple of it, the end of the last cell differs from
                `upper` by less than half a cell.
            periodic: as in Grid.

        Raises:
            SceneError: an extent is less than one cell, or a value is not finite.
        """
        low, high = (
            np.atleast_1d(array(value, f"Grid.{name}")) for name, value in {"lower": lower, "upper": upper}.items()
        )
        step = span(spacing, "Grid.spacing")
        if low.shape != high.shape or low.ndim != 1:
            raise SceneError(
                f"Grid.upper: must have as many numbers as the lower corner, {low.shape}, got {high.shape}"
            )
        cells = np.rint((high - low) / step)
        for axis, extent in enumerate((high - low).tolist()):
            if not 1.0 <= cells[axis] <= MOST_CELLS:
                raise SceneError(
                    f"Grid.upper[{axis}]: must be 1 to {MOST_CELLS} spacings of {step:g} m above the lower corner, "
                    f"got {extent:g} m"
                )
        return cls(tuple(cells.astype(int).tolist()), step, tuple(low.tolist()), periodic)  # type: ignore[arg-type]

    @property
    def dimension(self) -> int:
        """The dimension: 1, 2 or 3."""
        return len(self.cells)

    @property
    def sides(self) -> tuple[str, ...]:
        """The names of the sides, "x-", "x+", and so on."""
        return Sides.names[: 2 * self.dimension]

    @property
    def size(self) -> int:
        """The number of cells."""
        return math.prod(self.cells)

    @property
    def upper(self) -> tuple[float, ...]:
        """The upper corner [m]."""
        return tuple(start + n * self.spacing for start, n in zip(self.origin, self.cells, strict=True))

    @property
    def centers(self) -> FloatArray:
        """The centers of all cells [m], shape (*cells, D)."""
        return np.stack(self.coordinates, axis=-1)

    @property
    def coordinates(self) -> tuple[FloatArray, ...]:
        """The coordinates x, y, z of the centers [m], one read-only array of shape `cells` for each axis."""
        axes = [start + self.spacing * (np.arange(n) + 0.5) for start, n in zip(self.origin, self.cells, strict=True)]
        return tuple(np.broadcast_to(axis, self.cells) for axis in np.meshgrid(*axes, indexing="ij", sparse=True))

    def field(self, value: Field, path: str) -> FloatArray:
        """A field as a new array of shape `cells`.

        Raises:
            SceneError: a function fails, a shape is not that of the grid, or a number is complex or not finite.
        """
        given = array(called(value, path, *self.coordinates) if callable(value) else value, path)
        if given.shape == self.cells:
            return given
        # The result of a function may broadcast to the grid's shape; an array must have this shape.
        if given.ndim == 0 or (callable(value) and _broadcasts(given.shape, self.cells)):
            return np.array(np.broadcast_to(given, self.cells))
        what = (
            "the function must give an array of" if callable(value) else "must be a number, a function or an array of"
        )
        raise SceneError(f"{path}: {what} the shape {self.cells} of the grid, got the shape {given.shape}")

    def uniform_or_field(self, value: Field, path: str) -> float | FloatArray:
        """A read-only field. A number is returned unchanged, so that a system can distinguish uniform fields."""
        if not callable(value) and np.ndim(regular(value, path)) == 0:
            return number(value, path)
        return frozen(self.field(value, path))

    def mask(self, value: object, path: str) -> BoolArray:
        """A mask of shape `cells`, from a mask or a function that returns one.

        Raises:
            SceneError: the value is not such a mask.
        """
        given = regular(called(value, path, *self.coordinates) if callable(value) else value, path)
        if given.dtype.kind != "b":
            raise SceneError(f"{path}: must be a mask, True in the cells that are meant, got {given.dtype} numbers")
        if given.shape == self.cells or (callable(value) and _broadcasts(given.shape, self.cells)):
            return np.array(np.broadcast_to(given, self.cells))
        raise SceneError(f"{path}: must be a mask of the shape {self.cells} of the grid, got the shape {given.shape}")

    def edges(
        self, value: object, path: str, words: Collection[str], default: str, valued: bool = False
    ) -> tuple[Sides, Absorbing | None]:
        """The edge conditions, one for each side in the order x−, x+, y−, y+, z−, z+, and the absorbing layer.

        Args:
            value: one condition for all sides, conditions for all 2·D sides, or a mapping from axes ("x") and sides
                ("x-", "x+") to conditions. Sides without one have the default. An `Absorbing` is used as the word
                "absorbing".
            path: path of the argument.
            words: the known words. A periodic axis has the word "periodic", and takes no other.
            default: the default word.
            valued: whether conditions with values are valid too.

        Raises:
            SceneError: there is no such axis or word, a condition is given for a periodic axis, or layers differ. One
                condition for all sides is valid beside periodic axes; if all axes are, only "fixed" and "free" are.
        """
        sides = self.sides
        closed = dict(zip(sides, np.repeat(self.periodic, 2).tolist(), strict=True))
        found: dict[str, object] = dict.fromkeys(sides, default)
        if isinstance(value, Mapping):
            for key, word in sorted(value.items(), key=lambda entry: len(str(entry[0]))):  # "x-" precedes "x"
                named = [side for side in sides if is_word(key, side) or is_word(key, side[0])]
                if not named:
                    known = ", ".join(map(repr, (*AXES[: self.dimension], *sides)))
                    raise SceneError(f"{path}: must name some of {known}, got {shown(key)}")
                if any(closed[side] for side in named) and not is_word(word, "periodic"):
                    raise SceneError(f"{path}[{key!r}]: the grid is periodic there, and has no edge")
                found |= dict.fromkeys(named, word)
        elif isinstance(value, (tuple, list)):
            if len(value) != len(sides):
                raise SceneError(f"{path}: must be one word for each of {', '.join(sides)}, got {shown(value)}")
            found |= dict(zip(sides, value, strict=True))
            for side, word in found.items():
                if closed[side] and not is_word(word, "periodic"):
                    raise SceneError(f"{path}[{side!r}]: the grid is periodic there, and has no edge")
        else:
            if all(self.periodic) and (isinstance(value, (Valued, Absorbing)) or is_word(value, "absorbing")):
                raise SceneError(f"{path}: the grid is periodic along all axes, and has no edge")
            found |= dict.fromkeys(sides, value)
        layers = {word for word in found.values() if isinstance(word, Absorbing)}
        if len(layers) > 1:
            raise SceneError(
                f"{path}: all absorbing edges must have one kind of layer, got {shown(sorted(layers, key=repr))}"
            )
        around = [self.cells[:axis] + self.cells[axis + 1 :] for axis in np.repeat(range(self.dimension), 2)]
        conditions = Sides(
            condition(each, closed[side], f"{path}[{side!r}]", words, cells if valued else None)
            for (side, each), cells in zip(found.items(), around, strict=True)
        )
        return conditions, next(iter(layers), None)


# To add a system on a grid: a module in `systems`, a line in `SYSTEMS`, and its counterpart in Rust.
@dataclass(frozen=True, eq=False)
class GridSystem(System):
    """Base class of systems of fields on a grid, all of the grid's shape; equal only to themselves, as bodies are."""

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    grid: Grid
    """The grid."""
    edges: tuple[Condition, ...]
    """Edge condition of each side, in the order x−, x+, y−, y+, z−, z+."""

    def conditions(self, field: str) -> tuple[Condition, ...]:
        """The edge conditions of a field, in the order x−, x+, y−, y+, z−, z+."""
        del field
        return self.edges

    @property
    def shut(self) -> tuple[bool, ...]:
        """Mask of the sides that have a wall, as opposed to absorbing and periodic ones."""
        first = next(iter(self.units))
        return tuple(each not in ("absorbing", "periodic") for each in self.conditions(first))

    def outer(self, field: str, values: FloatArray) -> tuple[float, float]:
        """The values of a field on both outer faces in 1D: as prescribed, otherwise the value of the adjacent cell."""
        low, high = (
            0.0 if each == "fixed" else each.outer(nearest, self.grid.spacing) if isinstance(each, Valued) else nearest
            for each, nearest in zip(self.conditions(field), (float(values[0]), float(values[-1])), strict=True)
        )
        return low, high

    @property
    def landscape(self) -> FloatArray | None:
        """A constant field that films show beneath the others, from 0 to 1; None if it is uniform or there is none."""
        return None

    @property
    def is_open(self) -> bool:
        """Whether an edge absorbs."""
        return any("absorbing" in self.conditions(field) for field in self.units)

    @property
    def elements(self) -> Mapping[Element, int]:
        """The number of cells."""
        return {"cells": self.grid.size}

    @property
    def dimension(self) -> int:
        """The number of dimensions of space."""
        return self.grid.dimension

    def timed(self) -> Iterator[tuple[str, Callable[[float], object]]]:
        """The functions of edge conditions; those that several species share have the path of the first."""
        seen: set[int] = set()
        for field in self.units:
            species = f"[{field!r}]" if isinstance(self.edges, Mapping) else ""
            for side, each in zip(self.grid.sides, self.conditions(field), strict=True):
                if not isinstance(each, Valued):
                    continue
                value = getattr(each, each.key)
                if callable(value) and id(value) not in seen:
                    seen.add(id(value))
                    yield f"edges{species}[{side!r}].{each.key}", value

    def unit(self, field: str) -> str:
        """The unit of a field, for the dimension of the grid."""
        return self.units[field].replace("D", str(self.grid.dimension))

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """The shapes of the fields by name."""
        return dict.fromkeys(self.units, self.grid.cells)

    def values(self, field: str, value: object, path: str) -> FloatArray:
        """New values of a field, from a number, an array or a function of the coordinates."""
        del field
        return self.grid.field(value, path)  # type: ignore[arg-type]


def _per_axis(value: object, axes: int, path: str, check: Callable[[object, str], object]) -> tuple[object, ...]:
    """One validated value for each axis, from one value for all axes or one for each."""
    if not isinstance(value, (tuple, list)) and not (isinstance(value, np.ndarray) and value.ndim > 0):
        return (check(value, path),) * axes
    each = items(value, path, "values, one for each axis")
    if len(each) != axes:
        raise SceneError(f"{path}: must be one value, or {axes}, one for each axis, got {shown(value)}")
    return tuple(check(entry, f"{path}[{axis}]") for axis, entry in enumerate(each))


def _place(value: object, path: str) -> float:
    return number(value, path, least=-LONGEST, most=LONGEST)


def _broadcasts(shape: tuple[int, ...], cells: tuple[int, ...]) -> bool:
    """Whether an array of a shape broadcasts to the cells."""
    return len(shape) == len(cells) and all(own in (1, n) for own, n in zip(shape, cells, strict=True))
