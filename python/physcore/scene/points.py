"""Base class of systems of massless points in a flow."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from numpy.typing import ArrayLike

from physcore.checks import DIMENSIONS, BoolArray, FloatArray, array, frozen
from physcore.errors import SceneError
from physcore.scene.fields import Element
from physcore.scene.system import System


# To add a system of points: a module in `systems`, a line in `SYSTEMS`, and its counterpart in Rust.
@dataclass(frozen=True)
class PointSystem(System):
    """Base class of systems of N points in D dimensions in a velocity field, x' = v(x, t)."""

    default_integrator: ClassVar[str] = "RungeKutta4"
    derived: ClassVar[tuple[str, ...]] = ("velocities",)

    @property
    @abstractmethod
    def start(self) -> FloatArray:
        """The initial positions [m], shape (N, D)."""

    @property
    def units(self) -> Mapping[str, str]:
        """The units of positions and velocities."""
        return {"positions": "m", "velocities": "m/s"}

    @property
    def elements(self) -> Mapping[Element, int]:
        """The number of points."""
        return {"points": len(self)}

    @property
    def dimension(self) -> int:
        """The dimension of space, 2 or 3."""
        return int(self.start.shape[1])

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """The shapes of the fields by name."""
        return dict.fromkeys(self.units, self.start.shape)

    @property
    def signs(self) -> BoolArray | None:
        """Which points are positive; None if they have no sign."""
        return None

    def __len__(self) -> int:
        return len(self.start)

    def __repr__(self) -> str:
        label = f"{self.name!r}, " if self.name else ""
        return f"{type(self).__name__}({label}{len(self)} points in {self.dimension}D)"


def points(value: ArrayLike, path: str, dimensions: tuple[int, ...] = DIMENSIONS) -> FloatArray:
    """Validated points, shape (N, D), read-only.

    Raises:
        SceneError: the value has another shape, or is not finite.
    """
    given = array(value, path)
    if given.ndim != 2 or given.shape[1] not in dimensions:
        shapes = " or ".join(f"(N, {dimension})" for dimension in dimensions)
        raise SceneError(f"{path}: must have the shape {shapes}, got {given.shape}; one point is [[x, y]] in 2D")
    return frozen(given)
