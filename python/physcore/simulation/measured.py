"""Quantities of the present state of a simulation: budgets, and fields in space."""

from __future__ import annotations

from numpy.typing import ArrayLike

from physcore._core import World
from physcore.checks import FloatArray, array
from physcore.errors import SceneError
from physcore.scene.contents import BodyKey
from physcore.scene.scene import Scene
from physcore.simulation import frames as sampling
from physcore.simulation.energy import Amount, Energy
from physcore.simulation.stepper import Stepper


class Measured:
    """Base class of simulations: budgets of the present state, and fields at points in space."""

    _scene: Scene
    _world: World
    _stepper: Stepper

    def energy(self) -> Energy:
        """The energy budget of the present state.

        Raises:
            SimulationDiverged: the last step has sent particles that interact so far away that it cannot be told who is
                near whom.

        Warns:
            StabilityWarning: it is not finite: particles coincide, or the run has diverged, which
                on_divergence="ignore" leaves to you.
        """
        return sampling.audit(self._world, self._scene.units, self._stepper.earlier)[0]

    def budgets(self) -> dict[str, Amount]:
        """The budgets of what is conserved beside energy, by name; none where nothing is."""
        return sampling.audit(self._world, self._scene.units, self._stepper.earlier)[1]

    def momentum(self) -> FloatArray:
        """Total momentum of all particles that are not fixed [kg·m/s], shape (D,).

        Warns:
            StabilityWarning: it is not finite, as for `energy`.
        """
        return sampling.momentum(self._world, self._scene.units)

    def angular_momentum(self) -> FloatArray:
        """Total angular momentum about the origin [kg·m²/s], shape (D (D − 1)/2,): a number in 2D, three in
        3D.

        Warns:
            StabilityWarning: it is not finite, as for `energy`.
        """
        return sampling.angular_momentum(self._world, self._scene.units)

    def acceleration(self, points: ArrayLike, on: BodyKey | None = None) -> FloatArray:
        """The acceleration field of the scene at the present time:

            simulation.acceleration([[0.0, 1.0], [2.0, 0.0]])

        This is what a test particle of 1 kg, without charge and radius, would feel at rest: the accelerations of
        Gravity, and the forces of CentralForce, Drag (in wind) and CustomForce, whose function is called with the
        points and with velocities of 0. Forces that pass between particles are no fields in space and are left out:
        those of springs, of pairs, near or at a distance, and within fluids; so are boundaries. The positions of the
        bodies do not matter, and the precision is double.

        Args:
            points: where [m], shape (M, D). In a periodic domain they are taken as they are given.
            on: a body, its index or its name: of the forces only those that act on it, or on some of its particles,
                count; None: all of them.

        Returns:
            Accelerations [m/s²], shape (M, D).

        Raises:
            SceneError: a shape does not fit; there is no such body; an acceleration is not finite; or the function of a
                CustomForce fails, or gives no force for each of the points.
        """
        try:
            body = None if on is None else self._scene.index(on)
        except KeyError as error:
            raise SceneError(f"acceleration.on: {error.args[0]}") from None
        return self._sample("acceleration", points, body)

    def electric_field(self, points: ArrayLike) -> FloatArray:
        """The electric field at the present time, of every ElectromagneticField and of the charges under Coulomb:

            simulation.electric_field([[0.0, 1.0], [2.0, 0.0]])

        Args:
            points: where [m], shape (M, D).

        Returns:
            E [V/m], shape (M, D).

        Raises:
            SceneError: a shape does not fit; a point is at a charge without softening, or where a field is not finite;
                or the function of a field fails.
        """
        return self._sample("electric_field", points)

    def magnetic_field(self, points: ArrayLike) -> FloatArray:
        """The magnetic field at the present time, of every ElectromagneticField.

        Args:
            points: where [m], shape (M, D).

        Returns:
            B [T], shape (M, 3); in 2D its component along z, shape (M,).

        Raises:
            SceneError: as for `electric_field`.
        """
        field = self._sample("magnetic_field", points)
        return field if self._scene.dimension == 3 else field[:, 2]

    def electric_potential(self, points: ArrayLike) -> FloatArray:
        """The potential V of the electric field at the present time, E = −∇V.

        Args:
            points: where [m], shape (M, D).

        Returns:
            V [V], shape (M,).

        Raises:
            SceneError: as for `electric_field`; or a field has no potential, as functions and fields that change in
                time.
        """
        return self._sample("electric_potential", points)[:, 0]

    def _sample(self, kind: str, points: ArrayLike, body: int | None = None) -> FloatArray:
        """The values of a field at points."""
        places = self._places(points, kind)
        with self._scene.units.worded():
            return self._world.sample(kind, places, body)

    def _places(self, points: ArrayLike, path: str) -> FloatArray:
        """Points (M, D)."""
        places = array(points, f"{path}.points")
        if places.ndim != 2 or places.shape[1] != self._scene.dimension:
            raise SceneError(
                f"{path}.points: must have the shape (M, {self._scene.dimension}), got {places.shape}; "
                "one point is [[x, y]] in 2D"
            )
        return places
