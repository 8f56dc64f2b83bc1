"""Aerodynamic forces of wind on the faces of surfaces and on rigid bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, cast

from physcore.checks import PlacedVector, number, placed
from physcore.errors import SceneError
from physcore.scene.bodies import Body, SpringNetwork
from physcore.scene.items import Force
from physcore.scene.selection import Selection
from physcore.scene.surfaces import check_areas
from physcore.units.systems import Default


@dataclass(frozen=True)
class Wind(Force):
    """Aerodynamic force of a wind on the faces of cloth and on rigid bodies: pressure and skin friction.

        flag = pc.cloth((30, 20), 0.02, 60.0, mass=0.0004, axes=((1, 0, 0), (0, 0, 1)), pinned="left")
        scene = pc.Scene(flag, pc.Wind((6.0, 0.0, 0.0), on=flag), pc.Gravity((0.0, 0.0, -9.81)))

    The force on a face of area A and unit normal n, whose centroid has the velocity u, is

        F = ½ density A (normal |q| q n + tangential |t| t),   q = n·r,   t = r − q n,   r = velocity − u.

    Each corner carries a third. The force is that on both sides together, and does not depend on the order of the
    corners. A cloth flutters if the wind is faster than the waves along the cloth. The power F·velocity counts as work,
    and F·r ≥ 0 as dissipated by drag. The model is that of steady flow past each face alone. Wakes, the added mass of
    the air and sheltering are neglected.

    On a rigid body the law holds at each point of its surface, with half of the coefficients: of a thin plate, both
    sides together feel the force of a face. Force and torque act on the body. The drag coefficient of a ball is
    normal/2, that of a cuboid across the wind is `normal`, and that of a disc in 2D is 2/3 normal. In 2D the force is
    per meter of depth. Fixed bodies feel none.

    Args:
        velocity: velocity of the air [m/s], shape (D,). Or a function, called in every evaluation. `velocity(time)`
            returns one velocity: `lambda t: (6.0 + 2.0 * math.sin(3.0 * t), 0.0, 0.0)`. `velocity(time, positions)` has
            the centroids [m] of the faces, shape (F, 3), and returns a velocity for each. Of rigid bodies it has points
            of their surfaces, in a call of its own. A `pc.Flow` is such a function.
        density: density of the air [kg/m³], at least zero; by default 1.225 kg/m³, the value at sea level, in the units
            of the scene.
        normal: coefficient of the force normal to a face, at least zero; 1.17 is the value of a square plate.
        tangential: coefficient of skin friction, at least zero; 0.01 for both sides at Reynolds numbers near 10⁵.
        on: what the force acts on: rigid bodies, and SpringNetworks with faces in 3D; by default all of these. Of a
            selection of particles, faces with all three corners in it.

    Raises:
        SceneError: a value is out of range or not finite, a given body or all bodies of the scene have no faces, or a
            face has no area.

    Source: S. F. Hoerner, "Fluid-Dynamic Drag", 1965, chapters 2 and 3.
    """

    velocity: PlacedVector
    density: float = Default(1.225, "kg/m³")
    normal: float = 1.17
    tangential: float = 0.01
    by_place: bool = field(init=False, repr=False, compare=False)
    """Whether the velocity is a function of time and positions."""

    spares_fluids: ClassVar[bool] = True
    timed: ClassVar[tuple[str, ...]] = ("velocity",)

    @property
    def dissipates(self) -> bool:
        """True."""
        return True

    def __post_init__(self) -> None:
        super().__post_init__()
        velocity, by_place = placed(self.velocity, "Wind.velocity")
        self._set(
            velocity=velocity,
            by_place=by_place,
            density=number(self.density, "Wind.density", least=0.0),
            normal=number(self.normal, "Wind.normal", least=0.0),
            tangential=number(self.tangential, "Wind.tangential", least=0.0),
        )

    def check(self, bodies: Sequence[Body], path: str) -> None:
        """Check that the bodies that the force acts on have faces, or are rigid."""
        named = self.bodies() is not None
        rigid = [body for body in bodies if body.is_rigid]
        surfaces = [cast("SpringNetwork", body) for body in bodies if body.network and len(body.network.faces)]
        bare = next((body for body in bodies if named and body not in [*surfaces, *rigid]), None)
        if bare is not None or not (surfaces or rigid):
            found = f"{bare!r} without any" if bare is not None else "none on any body"
            raise SceneError(
                f"{path}: must act on faces or on rigid bodies, got {found}; say which there are: SpringNetwork(…, "
                "faces=…), or take Drag(…, wind=…) for particles"
            )
        for body in surfaces:
            if body.dimension == 3:
                check_areas(body, path)
            elif named or not rigid:
                raise SceneError(f"{path}: must act on faces in 3D, got {body!r}")
        for target in self.targets() or ():
            if isinstance(target, Selection) and not cast("Body", target.body).is_rigid:
                corners = target.mask[cast("SpringNetwork", target.body).faces]
                if not corners.all(axis=1).any():
                    raise SceneError(
                        f"{path}.on: must have all three corners of some faces, got {target!r}; the wind acts on faces"
                    )
