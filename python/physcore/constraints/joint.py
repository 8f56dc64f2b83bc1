"""Base classes of joints: constraints that join rigid bodies to each other, to particles, or to the world."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from physcore.arithmetic import lengths
from physcore.checks import FloatArray, array, number, shown
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.by_value import ByValue
from physcore.scene.fields import Element
from physcore.scene.items import Constraint, Places
from physcore.scene.rotations import normalized
from physcore.scene.selection import Selection
from physcore.scene.targets import Target, whole

End: TypeAlias = Body | str | Selection | tuple[Body | str, ArrayLike | slice] | tuple[Target, ...] | None
"""A body of one rigid body, its name, (body, index), or None for the world."""

APART = 1e-9
"""Tolerance of an anchor at a particle, relative to its coordinates: above their rounding."""


@dataclass(frozen=True, eq=False, repr=False)
class Joint(ByValue, Constraint):
    """Base class of joints and motors."""

    on: None = field(default=None, init=False, repr=False)
    """None: a joint acts on what it joins."""

    is_driven: ClassVar[bool] = False
    """Whether a Motor can drive the joint."""


@dataclass(frozen=True, eq=False, repr=False)
class PairJoint(Joint):
    """Base class of joints between two ends.

    The force of a joint [N] acts on `one`, and its torque [N·m] is that on `one` about the anchor. The opposite ones
    act on `other`. Both are means over the last step, and 0 of a joint that is broken. Joined bodies do not touch each
    other, unless a SpringJoint alone joins them.
    """

    one: End
    """First end: a tuple of one body or selection; None for the world."""
    other: End
    """Second end, likewise."""

    element: ClassVar[Element | None] = "joints"
    naming: ClassVar[tuple[str, ...]] = ("one", "other")
    selects: ClassVar[bool] = True
    turns: ClassVar[bool] = True
    """Whether the joint depends on the orientations of both ends, which particles do not have."""
    keeps_apart: ClassVar[bool] = True
    """Whether the joined bodies do not touch each other."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in self.naming:
            self._check_end(name)
        self._set(breaking_force=self._breaking())
        if not self._ends:
            raise SceneError(f"{self._kind}.one: must be a body, because other=None is the world already")
        if self.by_name:
            return
        if len(self._ends) == 2 and located(self._ends[0]) == located(self._ends[1]):
            raise SceneError(f"{self._kind}.other: must be another body than one, got {shown(self._ends[1])} twice")
        bodies = [whole(end) for end in self._ends]
        if len({body.dimension for body in bodies}) > 1:
            raise SceneError(f"{self._kind}.other: must be in {bodies[0].dimension}D like one, got {bodies[1]!r}")
        if not any(body.is_rigid for body in bodies):
            raise SceneError(
                f"{self._kind}.one: must be a rigid body, or other must be one, got {bodies[0]!r}; particles are "
                "joined to each other by a SpringNetwork"
            )

    @property
    def dimension(self) -> int:
        """The dimension of space; of a joint whose bodies are known."""
        dimension: int = whole(self._ends[0]).dimension
        return dimension

    def targets(self, field: str = "on") -> tuple[Body | Selection, ...] | None:
        """The body or selection of an end, none for the world; or those of both ends."""
        return cast("tuple[Body | Selection, ...]", self._ends if field == "on" else self._end(field))

    def references(self, scene: Places) -> Mapping[str, object]:
        """The ends as rows of the scene's particles; the force at which the joint breaks, if it is finite."""
        rows = dict.fromkeys(self.naming) | {
            name: float(scene.place(body).start + index)
            for name in self.naming
            for body, index in map(located, self._end(name))
        }
        force = self._breaking()
        return rows | {"breaking_force": None if math.isinf(force) else force}

    def mismatch(self, dimension: int) -> tuple[str, int] | None:
        """The name and the number of components of the first vector of another dimension; otherwise None."""
        for name, value in vars(self).items():
            size = value.shape[-1] if isinstance(value, np.ndarray) else dimension
            if size != dimension:
                return name, size
        return super().mismatch(dimension)

    @property
    def _kind(self) -> str:
        """The name of the class, for messages."""
        return type(self).__name__

    @property
    def _ends(self) -> tuple[Target, ...]:
        """The ends that are not the world."""
        return (*self._end("one"), *self._end("other"))

    def _end(self, name: str) -> tuple[Target, ...]:
        """An end; empty for the world."""
        return getattr(self, name) or ()

    def _targets(self, name: str) -> tuple[Target, ...] | None:
        """The validated value of an end; None for the world."""
        return super()._targets(name) or None

    def _breaking(self) -> float:
        """The validated force at which the joint breaks [N], above zero, possibly infinite."""
        force = getattr(self, "breaking_force", math.inf)
        if isinstance(force, float) and force == math.inf:
            return math.inf
        return number(force, f"{self._kind}.breaking_force", above=0.0)

    def _check_end(self, name: str) -> None:
        """Check that an end is one rigid body, one particle or the world, as far as its body is known."""
        path, targets = f"{self._kind}.{name}", self._end(name)
        if len(targets) > 1:
            raise SceneError(f"{path}: must be one body, (body, index), or None for the world, got {shown(targets)}")
        if not targets or isinstance(whole(targets[0]), str):
            return
        body = whole(targets[0])
        if len(_rows(targets[0])) != 1:
            raise SceneError(f"{path}: must be one of them, as (body, index), got {shown(targets[0])}")
        if body.is_fluid:
            raise SceneError(
                f"{path}: must be a rigid body, or a particle of Particles or a SpringNetwork, got {body!r}"
            )
        if self.turns and not body.is_rigid:
            raise SceneError(
                f"{path}: must be a rigid body or None, got {body!r}; particles have no orientation: take a BallJoint, "
                "a Rod or a SpringJoint"
            )

    def _center(self, name: str) -> FloatArray | None:
        """The position of an end at the start [m]; None for the world."""
        end = self._end(name)
        if not end:
            return None
        body, index = located(end[0])
        center: FloatArray = body.positions[index]
        return center

    def _point(self, value: Any, name: str) -> FloatArray:
        """A validated point [m], in the dimension of the bodies."""
        path = f"{self._kind}.{name}"
        point = array(value, path)
        if point.shape != ((self.dimension,) if not self.by_name else point.shape[-1:]) or point.shape not in (
            (2,),
            (3,),
        ):
            wanted = "2 or 3 components" if self.by_name else f"{self.dimension} components like the bodies"
            raise SceneError(f"{path}: must have {wanted}, got {shown(value)}")
        return point

    def _check_anchor(self, point: FloatArray, end: str, path: str) -> None:
        """Check that an anchor on a particle is at its position."""
        center = self._center(end)
        if center is None or whole(self._end(end)[0]).is_rigid:
            return
        if lengths(point - center) > APART * (lengths(point) + lengths(center)):
            raise SceneError(
                f"{path}: must be the position of the particle {shown(self._end(end)[0])}, "
                f"{center.tolist()}, got {point.tolist()}"
            )


def limits(lower: object, upper: object, kind: str, what: str) -> dict[str, float | None]:
    """Validated limits of a coordinate that is zero at the start; None: no limit."""
    known = {
        "lower": None if lower is None else number(lower, f"{kind}.lower"),
        "upper": None if upper is None else number(upper, f"{kind}.upper"),
    }
    low, high = known["lower"], known["upper"]
    if low is not None and high is not None and low > high:
        raise SceneError(f"{kind}.lower: must be ≤ upper, got {low:g} and {high:g}")
    for name, value, wrong in (("lower", low, low is not None and low > 0.0), ("upper", high, (high or 0.0) < 0.0)):
        if wrong:
            rule = "≤ 0" if name == "lower" else "≥ 0"
            raise SceneError(f"{kind}.{name}: must be {rule}, because the {what} at the start is 0, got {value:g}")
    return known


def direction(value: object, path: str) -> tuple[float, ...]:
    """A vector of length 1 in the direction of one that is not zero. Vectors of unit length, up to rounding, keep their
    bits.
    """
    given = array(value, path)
    largest = np.abs(given).max(initial=0.0)
    if given.shape not in ((2,), (3,)) or largest == 0.0:
        raise SceneError(f"{path}: must be a vector that is not zero, with 2 or 3 components, got {shown(value)}")
    return tuple(normalized(given).tolist())


def located(end: Target) -> tuple[Any, int]:
    """The body of an end and the index in it."""
    return whole(end), _rows(end)[0]


def _rows(end: Target) -> list[int]:
    """The indices of an end in its body, which is known."""
    rows: list[int] = np.arange(len(whole(end)))[end.index if isinstance(end, Selection) else slice(None)].tolist()
    return rows
