"""Contact forces of soft spheres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from physcore.checks import number
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.items import Force

LINEAR, HERTZIAN = 1.0, 1.5


@dataclass(frozen=True)
class SoftSpheres(Force):
    """Contact of soft spheres: overlapping particles repel each other.

        grains = pc.Particles(pc.block((0.0, 0.0), (1.0, 1.0), 0.1), radius=0.05, mass=0.01)
        scene = pc.Scene(grains, pc.Gravity(), pc.Floor(), pc.SoftSpheres(1000.0, damping=0.1, friction=0.3))
        bouncing = pc.SoftSpheres(1000.0, restitution=0.8)

    Two particles at a distance d overlap by δ = r_i + r_j − |d|. While δ > 0, the normal force is

        F_n = max(0, k δ^exponent + damping · u_n),     u_n the speed of their approach.

    The normal force is never attractive. A coefficient of restitution e gives the damping for each pair instead, from
    the reduced mass m = m_i m_j/(m_i + m_j); fixed particles have infinite mass. Two particles that meet head-on at any
    speed then part at e times that speed. With the damping ratio ζ,

        damping = 2 ζ √(k m)            if linear,      −ln e = 2 ζ acos(ζ)/√(1 − ζ²),  ζ < 1,
        damping = √5 ζ √(k m) δ^¼       if Hertzian,    −ln e = 2 ζ acosh(ζ)/√(ζ² − 1), ζ > 1.

    The tangential force (friction) is

        F_t = −min(γ_t |v_t|, μ F_n) v_t/|v_t|,         v_t the tangential relative velocity.

    There is no contact between the two ends of a spring or a rod, so that neighbors in a network may overlap.

    Particles have no spin, and friction acts on their centers. A grain therefore slides instead of rolling. Angular
    momentum is conserved only without friction.

    Args:
        stiffness: k [N/m] if linear, [N/m^1.5] if Hertzian; above zero.
        damping: damping coefficient along the normal [N·s/m], at least zero.
        friction: Coulomb's coefficient μ, at least zero.
        tangential_damping: γ_t [N·s/m], at least zero; None: as along the normal. Without friction it has no effect.
        exponent: 1 for a linear contact, 1.5 for Hertz's contact of elastic spheres.
        restitution: e, above 0 and at most 1, in place of `damping`.
        on: the body or bodies that the force acts on, within and between them; all except fluids by default.

    Raises:
        SceneError: a value is out of range or not finite, there is friction without damping, or `restitution` with
            `damping`. Scene raises it if no particle that the force acts on has a radius.

    Source: P. A. Cundall, O. D. L. Strack, Géotechnique 29, 47 (1979); H. Hertz, J. reine angew. Math. 92, 156 (1881);
    the friction of P. K. Haff, B. T. Werner, Powder Technol. 48, 239 (1986); restitution by T. Schwager, T. Pöschel,
    Granul. Matter 9, 465 (2007), and D. Antypov, J. A. Elliott, EPL 94, 50004 (2011).
    """

    stiffness: float
    damping: float = 0.0
    friction: float = 0.0
    tangential_damping: float | None = None
    exponent: float = LINEAR
    restitution: float | None = None

    spares_fluids: ClassVar[bool] = True
    spares_rigid_bodies: ClassVar[bool] = True
    is_shown: ClassVar[bool] = False
    has_kink: ClassVar[bool] = True
    is_contact: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        damping = number(self.damping, "SoftSpheres.damping", least=0.0)
        restitution, tangential = self.restitution, self.tangential_damping
        if restitution is not None:
            restitution = number(restitution, "SoftSpheres.restitution", above=0.0, most=1.0)
            if damping != 0.0:
                raise SceneError("SoftSpheres.restitution: gives the damping; leave out one of the two")
        elif tangential is None:
            tangential = damping
        if tangential is not None:
            tangential = number(tangential, "SoftSpheres.tangential_damping", least=0.0)
        self._set(
            stiffness=number(self.stiffness, "SoftSpheres.stiffness", above=0.0),
            damping=damping,
            friction=number(self.friction, "SoftSpheres.friction", least=0.0),
            tangential_damping=tangential,
            exponent=number(self.exponent, "SoftSpheres.exponent"),
            restitution=restitution,
        )
        if self.exponent not in (LINEAR, HERTZIAN):
            raise SceneError(f"SoftSpheres.exponent: must be 1 (linear) or 1.5 (Hertzian), got {self.exponent:g}")
        slippery = self.restitution == 1.0 if self.tangential_damping is None else self.tangential_damping == 0.0
        if self.friction > 0.0 and slippery:
            raise SceneError(
                "SoftSpheres.tangential_damping: must be > 0 where there is friction, got 0; friction grows with the "
                "sliding speed, by this coefficient [N·s/m], up to μ F_n"
            )

    def check(self, bodies: Sequence[Body], path: str) -> None:
        """Raise a SceneError if no particle has a radius, because points never overlap."""
        if any(len(body) for body in bodies) and not any(body.radius.any() for body in bodies):
            raise SceneError(
                f"{path}: SoftSpheres acts between particles that overlap, and all that it acts on have the radius 0; "
                "give them a size: Particles(…, radius=…)"
            )
