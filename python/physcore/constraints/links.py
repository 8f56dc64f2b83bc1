"""Joints between two anchors: rods and springs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from numpy.typing import ArrayLike

from physcore.arithmetic import lengths
from physcore.checks import FloatArray, array, frozen, number
from physcore.constraints.joint import PairJoint
from physcore.errors import SceneError


@dataclass(frozen=True, eq=False, repr=False)
class Link(PairJoint):
    """Base class of joints between two anchors, one on each end."""

    turns: ClassVar[bool] = False

    def _anchored(self, anchors: ArrayLike | None) -> FloatArray | None:
        """The validated anchors [m], shape (2, D); None: the centers of the ends, if they are known."""
        kind = type(self).__name__
        if anchors is None:
            if self.by_name:
                return None
            centers = [self._center(end) for end in self.naming]
            if any(center is None for center in centers):
                raise SceneError(f"{kind}.anchors: must be given, because an end is the world")
            anchors = [center.tolist() for center in centers if center is not None]
        points = array(anchors, f"{kind}.anchors")
        if points.shape not in ((2, 2), (2, 3)):
            raise SceneError(f"{kind}.anchors: must be two points, one on each end, got the shape {points.shape}")
        for point, end, index in zip(points, self.naming, (0, 1), strict=True):
            self._point(point, f"anchors[{index}]")
            if not self.by_name:
                self._check_anchor(point, end, f"{kind}.anchors[{index}]")
        return frozen(points)


@dataclass(frozen=True, eq=False, repr=False)
class Rod(Link):
    """Rod: two anchors keep their distance.

        ball = pc.RigidBody(pc.Disc(0.1), (1.0, 0.0))
        rod = pc.Rod(ball, None, [(1.0, 0.0), (0.0, 0.0)])
        recording = pc.simulate(pc.Scene(ball, rod, pc.Gravity()), 0.5, dt=1 / 240)
        recording[rod].force  # (F, 2), on the ball [N]

    Args:
        one, other: what is joined: a RigidBody, (bodies, index), (particles, index), their names, or None for the
            world.
        anchors: the ends of the rod at the start, the first on `one` and the second on `other` [m], shape (2, D);
            None: the centers of both.
        breaking_force: size of the force at which the rod breaks and is gone [N].

    Raises:
        SceneError: both ends are the same body or the world, an index is out of range, neither is a rigid body, an
            anchor is not at the particle, or the anchors coincide.
    """

    anchors: ArrayLike | None = None
    breaking_force: float = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        points = self._anchored(self.anchors)
        self._set(anchors=points)
        if points is not None and (points[0] == points[1]).all():
            raise SceneError("Rod.anchors: must differ; a rod without length is a BallJoint")


@dataclass(frozen=True, eq=False, repr=False)
class SpringJoint(Link):
    """Damped linear spring between two anchors.

        box = pc.RigidBody(pc.Rectangle(0.2, 0.2), (0.0, -1.0), mass=1.0)
        spring = pc.SpringJoint(box, None, [(0.1, -0.9), (0.1, 0.0)], stiffness=100.0, damping=0.5, rest_length=0.8)
        recording = pc.simulate(pc.Scene(box, spring, pc.Gravity()), 0.5, dt=1 / 240)
        recording[spring].force  # (F, 2), on the box [N]

    A spring of length l and direction n between its anchors pulls with k (l − l₀) + c dl/dt along n [N]. Its energy is
    by_term["joints"], and its damping counts as dissipated_by["damping"]. Bodies on a spring may touch each other.
    Anchors that coincide exert no force, because they have no direction.

    Args:
        one, other: what is joined: a RigidBody, (bodies, index), (particles, index), their names, or None for the
            world.
        anchors: the ends of the spring at the start, the first on `one` and the second on `other` [m], shape (2, D);
            None: the centers of both.
        stiffness: k [N/m], at least zero.
        damping: c [N·s/m], at least zero.
        rest_length: l₀ [m], at least zero; None: the distance of the anchors.
        breaking_force: size of the force at which the spring breaks and is gone [N].

    Raises:
        SceneError: both ends are the same body or the world, an index is out of range, neither is a rigid body, an
            anchor is not at the particle, or a value is out of range.
    """

    keeps_apart: ClassVar[bool] = False

    anchors: ArrayLike | None
    stiffness: float
    damping: float = 0.0
    rest_length: float | None = None
    breaking_force: float = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        points, length = self._anchored(self.anchors), self.rest_length
        if length is not None:
            length = number(length, "SpringJoint.rest_length", least=0.0)
        elif points is not None:
            length = float(lengths(points[1] - points[0]))
        self._set(
            anchors=points,
            stiffness=number(self.stiffness, "SpringJoint.stiffness", least=0.0),
            damping=number(self.damping, "SpringJoint.damping", least=0.0),
            rest_length=length,
        )
