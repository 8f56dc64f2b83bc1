"""Contact of a surface with itself and with other surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, cast

import numpy as np

from physcore.arithmetic import lengths
from physcore.checks import number, shown
from physcore.errors import SceneError
from physcore.scene.bodies import Body, SpringNetwork
from physcore.scene.items import Constraint
from physcore.scene.selection import Selection
from physcore.scene.surfaces import check_areas
from physcore.scene.targets import chosen


@dataclass(frozen=True)
class SelfContact(Constraint):
    """Contact between the vertices and triangles, and between the edges, of a body and of the bodies `on`.

        cloth = pc.cloth((30, 30), 0.02, 100.0, mass=1e-4, origin=(0.0, 0.0, 0.5), axes=((1, 0, 0), (0, 0, 1)))
        scene = pc.Scene(cloth, pc.Gravity((0, 0, -9.81)), pc.Floor(0.0), pc.SelfContact(cloth, thickness=0.005))

    No vertex passes through a triangle and no edge through an edge. The triangles are the `faces` of a SpringNetwork,
    and the edges are their sides. In a network without faces, such as a rope, the edges are the springs. Elements with
    a common vertex are not in contact; all others can be, however near they are along the surface. A triangle with a
    broken side is removed.

    A contact begins where two elements come nearer than `thickness`. From then on they approach each other no further,
    up to the tolerance of the iterative solver of the impulses. In every case no two paths cross within a step:
    conservative advancement checks all of them. Impulses act between the closest points. They conserve momentum to
    rounding, and angular momentum up to the distance of these points. The kinetic energy that they remove is listed as
    dissipated by "contacts". Simultaneous contacts with restitution add no energy. Particles that contacts press
    against a wall have the friction and the restitution of that wall. Where impulses cannot separate particles, these
    move on with a common velocity; the plan tells in how many steps.

    Contact is of order 1 in the time step. It needs VelocityVerlet, BackwardEuler, BDF2, XPBD or ProjectiveDynamics,
    and space in 3D without a Periodic domain.

    Args:
        body: the SpringNetwork that is in contact with itself, or its name.
        thickness: the distance of the mid-surfaces at which contact begins [m], above zero and below the length of
            the shortest edge of the body. Edges of the networks `on` may be shorter, as those of a fine mesh.
        friction: Coulomb's coefficient, at least zero.
        restitution: ratio of the normal speeds after and before a new contact, from 0 to 1.
        on: further networks that the body can touch, or their names.

    Raises:
        SceneError: a value is out of range, a body has no springs, a triangle has no area, or an edge of the body is
            not longer than the thickness. The simulation raises it if an edge intersects a triangle at the start.

    Source: R. Bridson, R. Fedkiw, J. Anderson, ACM Trans. Graph. 21, 594 (2002); M. Li, D. M. Kaufman, C. Jiang, ACM
    Trans. Graph. 40, 170 (2021) for the advancement.
    """

    body: Body | str
    thickness: float
    friction: float = 0.0
    restitution: float = 0.0

    naming: ClassVar[tuple[str, ...]] = ("on", "body")

    def __post_init__(self) -> None:
        super().__post_init__()
        own = chosen(self.body, "SelfContact.body")
        if own is None or len(own) != 1:
            raise SceneError(f"SelfContact.body: must be one SpringNetwork, got {shown(self.body)}")
        others = self.bodies() or ()
        if own[0] in others:
            raise SceneError("SelfContact.on: must be other bodies; the body meets itself anyway")
        self._set(
            on=others,
            body=own[0],
            thickness=number(self.thickness, "SelfContact.thickness", above=0.0),
            friction=number(self.friction, "SelfContact.friction", least=0.0),
            restitution=number(self.restitution, "SelfContact.restitution", least=0.0, most=1.0),
        )
        if self.by_name:
            return
        _check_surface(own[0], "SelfContact.body", self.thickness)
        for place, other in enumerate(others):
            _check_surface(other, f"SelfContact.on[{place}]", 0.0)

    def thickness_of(self, body: Body) -> float:
        """The thickness of the body that touches itself [m]; 0 of others."""
        return self.thickness if body in (self.bodies("body") or ()) else 0.0

    def targets(self, field: str = "on") -> tuple[Body | Selection, ...] | None:
        """The bodies named in a field."""
        return (cast("Body", self.body),) if field == "body" else super().targets(field)


def _check_surface(body: object, path: str, thickness: float) -> None:
    """Check that the triangles have areas and that the edges are longer than the thickness."""
    if not isinstance(body, SpringNetwork) or body.dimension != 3 or not len(body.pairs):
        raise SceneError(f"{path}: must be a SpringNetwork in 3D with springs, got {shown(body)}")
    if len(body.faces):
        check_areas(body, path)
    ends = body.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2) if len(body.faces) else body.pairs
    sides = np.diff(body.positions[ends], axis=1)
    shortest = float(lengths(sides).min())
    if thickness >= shortest:
        raise SceneError(
            f"SelfContact.thickness: must be below the length of the shortest edge, {shortest:g} m, got {thickness:g}; "
            "neighbors would touch from the start: choose a smaller thickness or a coarser mesh"
        )
