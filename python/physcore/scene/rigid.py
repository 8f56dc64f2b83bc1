"""Rigid bodies: shapes with mass that move and turn without being deformed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike

from physcore import _core
from physcore.arithmetic import cos, sin
from physcore.checks import BoolArray, FloatArray, array, broadcast, flag, number, require, shown, vector
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.fields import Element
from physcore.scene.records import Record
from physcore.scene.rotations import unit_quaternions
from physcore.scene.solids import Shape
from physcore.units.systems import Default

NONE = (1.0, 0.0, 0.0, 0.0)
"""Quaternion of no rotation."""
WATER = Default(1000.0, "kg/m³")
"""Density of water."""
HALF_A_SECOND = Default(0.5, "s")
"""Time for which bodies are at rest before they fall asleep."""
ONE = {"angles": "angle", "orientations": "orientation", "angular_velocities": "angular_velocity"}
"""Names of arguments of one body that differ from those of several."""


@dataclass(frozen=True, eq=False, init=False, repr=False)
class RigidBodies(Body):
    """Rigid bodies of one shape.

        boxes = pc.RigidBodies(pc.Rectangle(0.2, 0.2), [(0.0, 0.1), (0.0, 0.3)], friction=0.5, name="boxes")
        scene = pc.Scene(boxes, pc.Floor(0.0, restitution=0.0, friction=0.5), pc.Gravity())
        recording = pc.simulate(scene, 0.5, dt=1 / 240)
        recording[boxes].positions  # (F, 2, 2)
        recording[boxes].angles  # (F, 2)

    Rigid bodies meet each other, boundaries, particles and fluids. The coefficient of friction of a contact is
    √(μ₁ μ₂), its restitution is max(e₁, e₂). Particles, and the faces of cloth between them, take both from the body
    that they meet.

    A position is that of the center of mass. In 2D a body has an angle, and all quantities are per meter of depth. In
    3D a body has an orientation, a unit quaternion (w, x, y, z) that turns the axes of the shape into those of the
    world, and its angular velocity is along the axes of the world.

    Results of rigid bodies are those of the item: `recording[boxes].positions`, `.velocities`, `.angular_velocities`,
    and `.angles` in 2D or `.orientations` in 3D. Rigid bodies are no particles: they are not in `recording.positions`,
    in `simulation.velocities`, or in `scene.particles`. Momentum, angular momentum and energy count them.

    Args:
        shape: a shape: Disc, Rectangle, Polygon or Capsule in 2D, Ball, Cuboid, Capsule, Hull or MeshShape in 3D, or
            a Compound.
        positions: positions of the centers of mass [m], shape (B, D) with D = 2 or 3.
        angles: angles in 2D [rad], broadcast to (B,).
        orientations: orientations in 3D, broadcast to (B, 4), normalized; None: (1, 0, 0, 0).
        velocities: velocities of the centers of mass [m/s], broadcast to (B, D).
        angular_velocities: angular velocities [rad/s], broadcast to (B,) in 2D and to (B, 3) in 3D.
        density: mass density [kg/m³], broadcast to (B,), above zero; by default that of water.
        mass: masses [kg], broadcast to (B,), above zero; None: those by the density.
        friction: Coulomb's coefficient μ, broadcast to (B,), at least zero.
        restitution: e, the ratio of the normal speeds after and before a contact, broadcast to (B,), from 0 to 1.
        fixed: a bool mask of shape (B,), or integer indices. A fixed body feels no force and no torque, and keeps its
            velocity and its angular velocity.
        rolling_friction: largest torque against rolling over the normal force [m], broadcast to (B,), at least zero.
        torsional_friction: largest torque against spinning about the normal, over the normal force [m], broadcast to
            (B,), at least zero; in 3D only.
        charge: charges, at the centers of mass [C], broadcast to (B,).
        name: name of the bodies, also a key into results.
        sleep: speed below which a body is at rest [m/s], broadcast to (B,), above zero, such as 0.05: that of its
            fastest point. Bodies that touch or are joined fall asleep together when all of them have been at rest for
            `sleep_after`. They are then held still, and their kinetic energy counts as dissipated_by["sleep"].
            They wake when something that moves comes near, when the forces on them change by sleep / sleep_after as an
            acceleration, and when the user changes the state or the scene. `recording[boxes].asleep` is a mask of
            those who sleep. None: they never sleep.
        sleep_after: time for which bodies are at rest before they fall asleep [s], broadcast to (B,), above zero; by
            default half a second.

    Raises:
        SceneError: the shape is one of another dimension, a quaternion is zero, a shape does not fit, or a value is not
            finite or out of range.
    """

    is_rigid: ClassVar[bool] = True
    is_loose: ClassVar[bool] = False

    shape: Shape
    """Shape of all bodies."""
    angles: FloatArray | None
    """Angles in 2D [rad], shape (B,); None in 3D."""
    orientations: FloatArray | None
    """Unit quaternions (w, x, y, z) in 3D, shape (B, 4); None in 2D."""
    angular_velocities: FloatArray
    """Angular velocities [rad/s], shape (B,) in 2D and (B, 3) in 3D."""
    density: FloatArray
    """Mass density of each body [kg/m³], shape (B,)."""
    friction: FloatArray
    """Coulomb's coefficient of friction of each body, shape (B,)."""
    restitution: FloatArray
    """Coefficient of restitution of each body, shape (B,)."""
    rolling_friction: FloatArray
    """Largest torque against rolling over the normal force [m], shape (B,)."""
    torsional_friction: FloatArray
    """Largest torque against spinning over the normal force [m], shape (B,)."""
    sleep: FloatArray | None
    """Speed of the fastest point below which each body is at rest [m/s], shape (B,); None: they never sleep."""
    sleep_after: FloatArray
    """Time for which each body is at rest before it falls asleep [s], shape (B,)."""

    def __init__(
        self,
        shape: Shape,
        positions: ArrayLike,
        angles: ArrayLike | None = 0.0,
        orientations: ArrayLike | None = None,
        velocities: ArrayLike = 0.0,
        angular_velocities: ArrayLike = 0.0,
        density: ArrayLike = WATER,
        mass: ArrayLike | None = None,
        friction: ArrayLike = 0.5,
        restitution: ArrayLike = 0.0,
        fixed: ArrayLike | None = None,
        rolling_friction: ArrayLike = 0.0,
        torsional_friction: ArrayLike = 0.0,
        charge: ArrayLike = 0.0,
        name: str | None = None,
        sleep: ArrayLike | None = None,
        sleep_after: ArrayLike = HALF_A_SECOND,
    ) -> None:
        self._set_particles(positions, velocities, 1.0, charge, 0.0, fixed, name)
        self._set_shape(shape)
        self._set_mass(density, mass)
        self._set_turns(angles, orientations, angular_velocities)
        self._set_contact(friction, restitution, rolling_friction, torsional_friction)
        self._set_sleep(sleep, sleep_after)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Which bodies sleep, if they may."""
        return ("asleep",) * (self.sleep is not None)

    @property
    def motion(self) -> FloatArray:
        """The velocities and the angular velocities at the start, one after the other, shape (B, K)."""
        return np.column_stack([self.velocities, self.angular_velocities])

    @property
    def defaults(self) -> dict[str, Default]:
        """The default density, if neither density nor mass was given, and the default time before sleep."""
        given: dict[str, Default] = vars(self)["_defaults"]
        return given

    @property
    def elements(self) -> dict[Element, int]:
        """The number of rigid bodies, which are one wall in a fluid."""
        return {"rigid bodies": len(self), "walls": 1}

    def contains(self, points: ArrayLike) -> BoolArray:
        """Whether each point is in one of the bodies at the start.

            box = pc.RigidBody(pc.Rectangle(0.2, 0.2), (0.5, 0.5), density=500.0)
            points = pc.block((0.0, 0.0), (1.0, 0.5), spacing=0.02)
            water = pc.Fluid(points[~box.contains(points)], spacing=0.02)

        Args:
            points: positions [m], shape (N, D).

        Returns:
            A mask of shape (N,).

        Raises:
            SceneError: the shape does not fit, or a value is not finite.
        """
        given = array(points, "contains.points")
        if given.ndim != 2 or given.shape[1] != self.dimension:
            raise SceneError(f"contains.points: must have the shape (N, {self.dimension}), got {given.shape}")
        places, centers = (np.pad(rows, ((0, 0), (0, 3 - self.dimension))) for rows in (given, self.positions))
        turns = self.orientations
        if turns is None:
            half = 0.5 * cast("FloatArray", self.angles)
            turns = np.column_stack([cos(half), *np.zeros((2, len(self))), sin(half)])
        return _core.points_inside(Record.of(self.shape).described(), self.dimension, places, centers, turns)

    def __repr__(self) -> str:
        label = f"{self.name!r}, " if self.name else ""
        return f"{type(self).__name__}({label}{len(self)} of {self.shape!r} in {self.dimension}D)"

    def _path(self, name: str) -> str:
        """The path of an argument in messages."""
        return f"{type(self).__name__}.{name}"

    def _set_shape(self, shape: Shape) -> None:
        """Check and set the shape."""
        if not isinstance(shape, Shape):
            hint = f"; write {shape.__name__}(…)" if isinstance(shape, type) and issubclass(shape, Shape) else ""
            raise SceneError(f"{self._path('shape')}: must be a shape, such as Disc or Ball, got {shown(shape)}{hint}")
        if self.dimension not in shape.dimensions:
            raise SceneError(
                f"{self._path('shape')}: must be a shape in {self.dimension}D like the positions, got {shown(shape)}"
            )
        self._set(shape=shape)

    def _set_mass(self, density: ArrayLike, mass: ArrayLike | None) -> None:
        """Check the density and the mass, and set the mass."""
        number, size = (len(self),), self.shape.properties(self.dimension).size
        densities = broadcast(density, number, self._path("density"))
        require(densities > 0.0, densities, self._path("density"), "> 0")
        path = self._path("density" if mass is None else "mass")
        with np.errstate(over="ignore", under="ignore"):  # Overflow gives infinity, which is refused below.
            masses = densities * size if mass is None else broadcast(mass, number, path)
            require(masses > 0.0, masses, path, "> 0 (to hold a body in place use fixed=)")
            densities = masses / size
        right = np.isfinite(masses) & np.isfinite(densities) & (densities > 0.0)
        require(right, masses if mass is not None else densities, path, "such that mass and density are finite numbers")
        by_default = isinstance(density, Default) and mass is None
        self._set(mass=masses, density=densities, _defaults={"density": density} if by_default else {})

    def _set_turns(self, angles: ArrayLike | None, orientations: ArrayLike | None, rates: ArrayLike) -> None:
        """Check and set the angles or orientations, and the angular velocities."""
        number, planar = len(self), self.dimension == 2
        if planar and orientations is not None:
            raise SceneError(f"{self._path('orientations')}: must be None in 2D, where bodies have angles [rad]")
        if not planar and angles is not None and array(angles, self._path("angles")).any():
            raise SceneError(f"{self._path('angles')}: must be 0 in 3D, where bodies have orientations (w, x, y, z)")
        spins = array(rates, self._path("angular_velocities"))
        if not planar and spins.ndim == 0 and spins != 0.0:
            raise SceneError(f"{self._path('angular_velocities')}: must be vectors in 3D, of shape (3,), got {spins:g}")
        turned = NONE if orientations is None else orientations
        given = 0.0 if angles is None else angles
        self._set(
            angles=broadcast(given, (number,), self._path("angles")) if planar else None,
            orientations=None if planar else unit_quaternions(turned, number, self._path("orientations")),
            angular_velocities=broadcast(spins, (number,) if planar else (number, 3), self._path("angular_velocities")),
        )

    def _set_contact(
        self, friction: ArrayLike, restitution: ArrayLike, rolling_friction: ArrayLike, torsional_friction: ArrayLike
    ) -> None:
        """Check and set the coefficients of contacts."""
        given = {
            "friction": friction,
            "restitution": restitution,
            "rolling_friction": rolling_friction,
            "torsional_friction": torsional_friction,
        }
        for name, value in given.items():
            path = self._path(name)
            values = broadcast(value, (len(self),), path)
            require(values >= 0.0, values, path, "≥ 0")
            if name == "restitution":
                require(values <= 1.0, values, path, "≤ 1")
            self._set(**{name: values})
        if self.dimension == 2 and self.torsional_friction.any():
            raise SceneError(f"{self._path('torsional_friction')}: must be 0 in 2D, where nothing spins about a normal")

    def _set_sleep(self, sleep: ArrayLike | None, sleep_after: ArrayLike) -> None:
        """Check and set when the bodies fall asleep."""
        speeds = None
        if sleep is not None:
            speeds = broadcast(sleep, (len(self),), self._path("sleep"))
            require(speeds > 0.0, speeds, self._path("sleep"), "> 0 (bodies with sleep=None never sleep)")
        times = broadcast(sleep_after, (len(self),), self._path("sleep_after"))
        require(times > 0.0, times, self._path("sleep_after"), "> 0")
        by_default = isinstance(sleep_after, Default) and sleep is not None
        given: dict[str, Any] = {"sleep_after": sleep_after} if by_default else {}
        self._set(sleep=speeds, sleep_after=times, _defaults={**vars(self)["_defaults"], **given})


class RigidBody(RigidBodies):
    """Rigid body.

        wheel = pc.RigidBody(pc.Disc(0.1), (0.0, 0.1), velocity=(1.5, 0.0), angular_velocity=60.0, name="wheel")
        recording = pc.simulate(pc.Scene(wheel, pc.Floor(0.0, friction=0.3), pc.Gravity()), 0.5, dt=1 / 240)
        recording[wheel].positions  # (F, 1, 2)

    RigidBodies of one body; results keep its axis of length 1.

    Args:
        shape: shape, as in RigidBodies.
        position: position of the center of mass [m], shape (D,).
        angle: angle in 2D [rad].
        orientation: orientation in 3D, a quaternion (w, x, y, z), normalized; None: (1, 0, 0, 0).
        velocity: velocity of the center of mass [m/s], shape (D,).
        angular_velocity: angular velocity [rad/s]: a number in 2D, shape (3,) in 3D.
        density, mass, friction, restitution: as in RigidBodies.
        fixed: whether the body feels no force and no torque, and keeps its velocity and its angular velocity.
        rolling_friction, torsional_friction, charge, name, sleep, sleep_after: as in RigidBodies.

    Raises:
        SceneError: as for RigidBodies.
    """

    def __init__(
        self,
        shape: Shape,
        position: ArrayLike,
        angle: float = 0.0,
        orientation: ArrayLike | None = None,
        velocity: ArrayLike = 0.0,
        angular_velocity: ArrayLike = 0.0,
        density: float = WATER,
        mass: float | None = None,
        friction: float = 0.5,
        restitution: float = 0.0,
        fixed: bool = False,
        rolling_friction: float = 0.0,
        torsional_friction: float = 0.0,
        charge: float = 0.0,
        name: str | None = None,
        sleep: float | None = None,
        sleep_after: float = HALF_A_SECOND,
    ) -> None:
        place = vector(position, "RigidBody.position")
        spin = array(angular_velocity, "RigidBody.angular_velocity")
        if spin.shape not in ((), (3,)[: 2 * len(place) - 4]):
            kind = "a number in 2D" if len(place) == 2 else "a vector in 3D"
            raise SceneError(f"RigidBody.angular_velocity: must be {kind}, got the shape {spin.shape}")
        if orientation is not None and np.shape(array(orientation, "RigidBody.orientation")) != (4,):
            raise SceneError(f"RigidBody.orientation: must be a quaternion (w, x, y, z), got {shown(orientation)}")
        super().__init__(
            shape,
            [place],
            number(angle, "RigidBody.angle"),
            orientation,
            broadcast(velocity, (len(place),), "RigidBody.velocity"),
            spin,
            density=number(density, "RigidBody.density", above=0.0),
            mass=None if mass is None else number(mass, "RigidBody.mass", above=0.0),
            friction=number(friction, "RigidBody.friction", least=0.0),
            restitution=number(restitution, "RigidBody.restitution", least=0.0, most=1.0),
            fixed=flag(fixed, "RigidBody.fixed"),
            rolling_friction=number(rolling_friction, "RigidBody.rolling_friction", least=0.0),
            torsional_friction=number(torsional_friction, "RigidBody.torsional_friction", least=0.0),
            charge=number(charge, "RigidBody.charge"),
            name=name,
            sleep=None if sleep is None else number(sleep, "RigidBody.sleep", above=0.0),
            sleep_after=number(sleep_after, "RigidBody.sleep_after", above=0.0),
        )

    def _path(self, name: str) -> str:
        """The path of an argument in messages."""
        return f"RigidBody.{ONE.get(name, name)}"
