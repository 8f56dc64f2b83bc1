"""Joints that leave some of the relative motion of two rigid bodies free: hinges, ball joints, welds and sliders."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from numpy.typing import ArrayLike

from physcore.checks import Vector
from physcore.constraints.joint import PairJoint, direction, limits
from physcore.errors import SceneError


@dataclass(frozen=True, eq=False, repr=False)
class AnchoredJoint(PairJoint):
    """Base class of joints with one anchor."""

    def _set_anchor(self, anchor: ArrayLike | None) -> None:
        """Check and set the anchor; None: the center of the first end that is not the world."""
        if anchor is None and not self.by_name:
            one = self._center("one")
            anchor = self._center("other") if one is None else one
        if anchor is not None:
            point = self._point(anchor, "anchor")
            if not self.by_name:
                for end in self.naming:
                    self._check_anchor(point, end, f"{type(self).__name__}.anchor")
            self._set(anchor=tuple(point.tolist()))


@dataclass(frozen=True, eq=False, repr=False)
class Hinge(AnchoredJoint):
    """Hinge: two bodies turn about a common axis.

        door = pc.RigidBody(pc.Cuboid(0.8, 0.04, 2.0), (0.4, 0.0, 1.0), angular_velocity=(0.0, 0.0, 1.0))
        hinge = pc.Hinge(door, None, (0.0, 0.0, 1.0), axis=(0.0, 0.0, 1.0), lower=0.0, upper=1.5)
        recording = pc.simulate(pc.Scene(door, hinge), 0.5, dt=1 / 240)
        recording[hinge].force  # (F, 3), on the door [N]

    In 2D a hinge is a pin, about which both bodies turn. Its angle is that of `one` relative to `other`, zero at the
    start, positive counterclockwise about the axis. A Motor drives it.

    The force of a joint [N] acts on `one`, and its torque [N·m] is that on `one` about the anchor. The opposite ones
    act on `other`. Both are means over the last step.

    Args:
        one, other: what is joined: a RigidBody, (bodies, index), their names, or None for the world.
        anchor: a point of the axis at the start [m], shape (D,).
        axis: direction of the axis at the start, shape (3,), of any length; None in 2D.
        lower, upper: limits of the angle [rad], at most 0 and at least 0; None: no limit.
        breaking_force: size of the force at which the joint breaks and is gone [N].

    Raises:
        SceneError: both ends are the same body or the world, an index is out of range, an end has no orientation, the
            axis is zero, is missing in 3D or given in 2D, or a limit is out of range.
    """

    is_driven: ClassVar[bool] = True

    anchor: Vector
    axis: Vector | None = None
    lower: float | None = None
    upper: float | None = None
    breaking_force: float = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set_anchor(self.anchor)
        self._set(
            axis=None if self.axis is None else direction(self.axis, "Hinge.axis"),
            **limits(self.lower, self.upper, "Hinge", "angle"),
        )
        if self.by_name:
            return
        if self.dimension == 2 and self.axis is not None:
            raise SceneError("Hinge.axis: must be None in 2D, where a hinge is a pin across the plane")
        if self.dimension == 3 and (self.axis is None or len(self.axis) != 3):
            raise SceneError(f"Hinge.axis: must be a vector of 3 components in 3D, got {self.axis}")


@dataclass(frozen=True, eq=False, repr=False)
class BallJoint(AnchoredJoint):
    """Ball joint: a point of one body stays at a point of another.

        top = pc.RigidBody(pc.Cuboid(0.2, 0.2, 0.04), (0.0, 0.0, 0.15), angular_velocity=(0.0, 0.0, 60.0))
        joint = pc.BallJoint(top, None, (0.0, 0.0, 0.0))
        recording = pc.simulate(pc.Scene(top, joint, pc.Gravity()), 0.2, dt=1e-3)
        recording[joint].force  # (F, 3), on the top [N]

    In 2D it is a pin, like a Hinge without limits. Particles can be joined too, at their positions.

    Args:
        one, other: what is joined: a RigidBody, (bodies, index), (particles, index), their names, or None for the
            world.
        anchor: the common point at the start [m], shape (D,).
        breaking_force: size of the force at which the joint breaks and is gone [N].

    Raises:
        SceneError: both ends are the same body or the world, an index is out of range, neither is a rigid body, or the
            anchor is not at the particle.
    """

    turns: ClassVar[bool] = False

    anchor: Vector
    breaking_force: float = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set_anchor(self.anchor)


@dataclass(frozen=True, eq=False, repr=False)
class Weld(AnchoredJoint):
    """Weld: two bodies keep their relative position and orientation.

        planks = pc.RigidBodies(pc.Rectangle(1.0, 0.1), [(0.5, 0.0), (1.5, 0.0)])
        welds = [pc.Weld((planks, 0), None, (0.0, 0.0)), pc.Weld((planks, 0), (planks, 1), (1.0, 0.0))]
        recording = pc.simulate(pc.Scene(planks, *welds, pc.Gravity()), 0.2, dt=1 / 240)
        recording[welds[1]].torque  # (F,), on the first plank [N·m]

    A weld with a breaking force is a seam that tears. Parts that never part are a Compound, which costs nothing.

    Args:
        one, other: what is joined: a RigidBody, (bodies, index), their names, or None for the world.
        anchor: the point about which torques are measured [m], shape (D,); None: the center of `one`, or of `other` if
            `one` is the world.
        breaking_force: size of the force at which the joint breaks and is gone [N].

    Raises:
        SceneError: both ends are the same body or the world, an index is out of range, or an end has no orientation.
    """

    anchor: Vector | None = None
    breaking_force: float = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set_anchor(self.anchor)


@dataclass(frozen=True, eq=False, repr=False)
class Prismatic(AnchoredJoint):
    """Prismatic joint, a slider: two bodies move along a common axis, and do not turn against each other.

        piston = pc.RigidBody(pc.Rectangle(0.2, 0.1), (0.0, 0.0), velocity=(1.0, 0.0))
        slider = pc.Prismatic(piston, None, (1.0, 0.0), upper=0.3)
        recording = pc.simulate(pc.Scene(piston, slider, pc.Gravity()), 0.5, dt=1 / 240)
        recording[piston].positions[:, 0, 0].max()  # 0.3

    Its way is that of `one` relative to `other` along the axis, zero at the start. A Motor drives it.

    Args:
        one, other: what is joined: a RigidBody, (bodies, index), their names, or None for the world.
        axis: direction of the axis at the start, shape (D,), of any length. It turns with `other`.
        anchor: the point about which torques are measured [m], shape (D,); None: the center of `one`, or of `other` if
            `one` is the world.
        lower, upper: limits of the way [m], at most 0 and at least 0; None: no limit.
        breaking_force: size of the force at which the joint breaks and is gone [N].

    Raises:
        SceneError: both ends are the same body or the world, an index is out of range, an end has no orientation, the
            axis is zero, or a limit is out of range.
    """

    is_driven: ClassVar[bool] = True

    axis: Vector
    anchor: Vector | None = None
    lower: float | None = None
    upper: float | None = None
    breaking_force: float = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set_anchor(self.anchor)
        self._set(
            axis=direction(self.axis, "Prismatic.axis"),
            **limits(self.lower, self.upper, "Prismatic", "way"),
        )
        if not self.by_name and len(self.axis) != self.dimension:
            raise SceneError(f"Prismatic.axis: must have {self.dimension} components like the bodies, got {self.axis}")
