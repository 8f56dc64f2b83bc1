"""Motors, which drive joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self, cast

from physcore.checks import number, shown
from physcore.constraints.joint import Joint
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.items import Constraint, Places, SceneItem
from physcore.scene.selection import Selection


@dataclass(frozen=True, eq=False, repr=False)
class Motor(Joint):
    """Motor: drives a Hinge or a Prismatic joint at a speed, with limited torque.

        wheel = pc.RigidBody(pc.Disc(0.2), (0.0, 0.0))
        axle = pc.Hinge(wheel, None, (0.0, 0.0))
        motor = pc.Motor(axle, speed=10.0, torque=5.0)
        recording = pc.simulate(pc.Scene(wheel, axle, motor), 0.5, dt=1 / 240)
        recording[wheel].angular_velocities[-1]  # 10 rad/s

    The speed is that of the joint's `one` relative to its `other`. The motor brakes a joint that is faster. The energy
    that it supplies, or takes, counts as work.

    Args:
        joint: the joint, an item of the scene too.
        speed: speed of the joint, [rad/s] of a Hinge and [m/s] of a Prismatic joint.
        torque: largest torque of a Hinge [N·m], largest force of a Prismatic joint [N]; at least zero.

    Raises:
        SceneError: the joint is neither, or is not in the scene, or a value is out of range.
    """

    naming: ClassVar[tuple[str, ...]] = ()
    linking: ClassVar[tuple[str, ...]] = ("joint",)

    joint: Joint
    speed: float
    torque: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if not getattr(self.joint, "is_driven", False):
            raise SceneError(f"Motor.joint: must be a Hinge or a Prismatic, got {shown(self.joint)}")
        self._set(
            speed=number(self.speed, "Motor.speed"),
            torque=number(self.torque, "Motor.torque", least=0.0),
        )

    @property
    def by_name(self) -> bool:
        """Whether bodies of the joint are given by name."""
        return self.joint.by_name

    def among(self, bodies: Sequence[Body], path: str) -> Self:
        """A copy with the bodies of a scene in place of their names."""
        return replace(self, joint=self.joint.among(bodies, f"{path}.joint")) if self.by_name else self

    def following(self, given: Sequence[Constraint], known: Sequence[Constraint]) -> Self:
        """A copy that drives the joint of a scene: the same object, or an equal one."""
        same = [own for each, own in zip(given, known, strict=True) if each is self.joint]
        same += [own for own in known if own == self.joint]
        return replace(self, joint=cast("Joint", same[0])) if same else self

    def targets(self, field: str = "on") -> tuple[Body | Selection, ...] | None:
        """The ends of the joint."""
        return self.joint.targets(field)

    def named(self) -> Mapping[str, tuple[Body | Selection | SceneItem, ...] | None]:
        """The joint."""
        return {"joint": (self.joint,)}

    def references(self, scene: Places) -> Mapping[str, object]:
        """The joint as its index among the constraints."""
        return {"joint": float(next(place for place, each in enumerate(scene.constraints) if each is self.joint))}
