"""Anchors: particles that are tied to a rigid body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike

from physcore.checks import shown
from physcore.constraints.joint import located
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.by_value import ByValue
from physcore.scene.fields import Element
from physcore.scene.items import Constraint, Places
from physcore.scene.selection import Selection
from physcore.scene.targets import Target, whole


@dataclass(frozen=True, eq=False, repr=False)
class Anchor(ByValue, Constraint):
    """Anchor: particles of a spring network that stay at their places of a rigid body.

        rope = pc.rope(21, 1.0, 1000.0, damping=0.1, mass=0.01, direction=(0.0, -1.0), pinned="start")
        box = pc.RigidBody(pc.Rectangle(0.4, 0.2), (0.0, -1.1), velocity=(0.5, 0.0), mass=0.2)
        anchor = pc.Anchor(rope, -1, box)
        recording = pc.simulate(pc.Scene(rope, box, anchor, pc.Gravity()), 1.0, dt=1 / 2000)
        recording[anchor].force  # (F, n, D), of each particle on the box [N]
        recording[anchor].torque  # (F, n) in 2D, (F, n, 3) in 3D, about its center of mass [N·m]

    The body and its particles move as one rigid body, for any number of particles: places are kept to rounding, as are
    momentum and angular momentum, and a free body does no work on them. The places are those at the start, on the body
    or beside it. The particles begin with the velocities of these places.

    The forces are means over the last step; their sum is the force of the network on the body. A fixed body that moves
    drives its particles, and its energy counts as work. Tied particles touch neither rigid bodies nor boundaries; the
    others of the network do.

    Args:
        network: the SpringNetwork, or Particles, or the name.
        indices: the particles that are tied: an integer, a slice, integer indices or a bool mask.
        body: a RigidBody, (bodies, index), or the name.

    Raises:
        SceneError: the network is a fluid or is rigid, an index is out of range, or the body is not one rigid body. The
            simulation raises it for a particle that is fixed, is tied twice, or is held by a joint, a rod, a strain
            limit, a wire or SelfContact too.
    """

    naming: ClassVar[tuple[str, ...]] = ("network", "body")
    selects: ClassVar[bool] = True
    element: ClassVar[Element | None] = "ties"

    network: Body | str | tuple[Target, ...]
    indices: ArrayLike | slice
    body: Body | str | tuple[Target, ...] | tuple[Body | str, ArrayLike | slice]
    on: None = field(default=None, init=False, repr=False)
    """None: an anchor acts on what it ties."""

    def __post_init__(self) -> None:
        super().__post_init__()
        network, body = (self._one(name) for name in self.naming)
        if isinstance(network, Selection):
            raise SceneError(f"Anchor.network: must be a whole network, with the particles in indices, got {network!r}")
        if not isinstance(network, str) and (network.is_fluid or network.is_rigid):
            raise SceneError(f"Anchor.network: must be a SpringNetwork or Particles, got {shown(network)}")
        self._set(indices=Selection(network, cast("Any", self.indices), "Anchor.indices").index)
        if isinstance(whole(body), str):
            return
        if not whole(body).is_rigid or len(body.mask.nonzero()[0] if isinstance(body, Selection) else body) != 1:
            raise SceneError(
                f"Anchor.body: must be a RigidBody, or one of several as (bodies, index), got {shown(body)}"
            )
        if not isinstance(network, str) and network.dimension != whole(body).dimension:
            raise SceneError(f"Anchor.body: must be in {network.dimension}D like the network, got {shown(body)}")

    @property
    def tied(self) -> Selection:
        """The tied particles; of an anchor whose network is known."""
        return Selection(cast("Body", self._one("network")), cast("Any", self.indices), "Anchor.indices")

    def targets(self, field: str = "on") -> tuple[Body | Selection, ...] | None:
        """The network or the body; in the field "on" the tied particles."""
        return (self.tied,) if field == "on" else super().targets(field)

    def references(self, scene: Places) -> Mapping[str, object]:
        """The tied particles and the body as rows of the scene's particles."""
        network, (body, index) = cast("Body", self._one("network")), located(self._one("body"))
        rows = scene.place(network).start + np.asarray(self.tied.index, dtype=np.int64)
        return {"network": rows[:, np.newaxis], "body": float(scene.place(body).start + index)}

    def _one(self, name: str) -> Target:
        """The body, the name or the selection in a field."""
        targets = self._targets(name) or ()
        if len(targets) != 1:
            raise SceneError(f"Anchor.{name}: must be one body, got {shown(getattr(self, name))}")
        return targets[0]
