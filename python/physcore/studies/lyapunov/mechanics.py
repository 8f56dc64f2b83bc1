"""Bodies of a scene, with neighbors as separate runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from physcore.arithmetic import lengths, row_space
from physcore.checks import FloatArray
from physcore.errors import SceneError
from physcore.numerics.choices import Options, StepRule, steps_to
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation
from physcore.simulation.step_warnings import unwarned
from physcore.studies.lyapunov.neighbors import APART, TINY, orthonormalized, random_frame

PILOT, LOOKS = 1.0 / 8.0, 32
"""Fraction of the motion that determines its extent, and number of samples in it."""
INTERVALS = 1000
"""Default number of orthonormalizations over the duration."""

SINGULAR = 1e-9
"""Tolerance of independence: a constraint of length 1 is independent if more than this remains after projection."""


class Mechanics:
    """A run of a scene, and one neighboring run for each exponent.

    Offsets are those of the positions and velocities of free particles, relative to the extent and the largest speed of
    the first part of the motion. With rods, they are initially in the tangent space of the constraints, and the
    integrator keeps them there.

    Args:
        scene: a scene of bodies.
        exponents: the number of exponents, the largest ones.
        before: the time before averaging [s].
        average: the averaging time [s].
        interval: the time between two orthonormalizations [s]; None: a thousandth of `average`.
        numerics: as in Simulation.

    Raises:
        SceneError: the scene has further state than positions and velocities, or it has fewer exponents.
    """

    def __init__(
        self, scene: Scene, exponents: int, before: float, average: float, interval: float | None, numerics: Options
    ) -> None:
        _refuse_more_than_places_and_velocities(scene)
        pilot = _pilot(scene, PILOT * (before + average), numerics)
        self._scene, self._pilot = scene, pilot
        self._steps = max(1, round((interval or average / INTERVALS) / pilot.dt))
        self._interval = self._steps * pilot.dt
        self.intervals = steps_to(before, self._interval, 1e-9), max(1, steps_to(average, self._interval, 1e-9))
        options: Options = {**numerics, "dt": pilot.dt}
        with unwarned():  # The pilot run has issued the warnings.
            self._run, *self._neighbors = (Simulation(scene, **options) for _ in range(1 + exponents))
        self._free = ~np.concatenate([body.fixed for body in scene.bodies])
        forbidden = row_space(self._constraints(), SINGULAR)
        self.directions = forbidden.shape[1] - len(forbidden)
        if exponents > self.directions:
            raise SceneError(f"lyapunov.exponents: must be at most {self.directions} in this scene, got {exponents}")
        self._frames = random_frame(exponents, forbidden.shape[1], forbidden)[np.newaxis]

    @property
    def time(self) -> float:
        """The present time [s]."""
        return self._run.time

    def advance(self) -> FloatArray:
        """Advance by an interval, and return the logarithms of the growth along each direction (1, K)."""
        positions, velocities = self._run.positions, self._run.velocities
        # The state of all runs is set, so that multistep methods restart in each.
        self._run.set(positions, velocities)
        for neighbor, frame in zip(self._neighbors, self._frames[0], strict=True):
            places, speeds = positions.copy(), velocities.copy()
            shift, change = APART * frame.reshape(2, -1, self._scene.dimension)
            places[self._free] += self._pilot.extent * shift
            speeds[self._free] += self._pilot.speed * change
            neighbor.set(places, speeds)
        for run in (self._run, *self._neighbors):
            run.step(self._steps)
        offsets = np.array([self._offset(neighbor) for neighbor in self._neighbors]) / APART
        growth, self._frames = orthonormalized(offsets[np.newaxis], self._interval)
        return growth

    def _offset(self, neighbor: Simulation) -> FloatArray:
        """The offset of a neighbor, scaled by the extent and the speed (P,)."""
        apart = neighbor.positions[self._free] - self._run.positions[self._free]
        if self._scene.periodic is not None:
            apart = self._scene.periodic.nearest(apart)
        faster = neighbor.velocities[self._free] - self._run.velocities[self._free]
        return np.concatenate([(apart / self._pilot.extent).ravel(), (faster / self._pilot.speed).ravel()])

    def _constraints(self) -> FloatArray:
        """Equations of the rods for offsets at the start (2 M, P): r·δr = 0 and r·δv + v·δr = 0.

        Here r is the separation of the ends of a rod and v its rate. Rows have the length 1, or 0 where both vanish.
        """
        places, speeds = self._run.positions, self._run.velocities
        rods = [network.pairs[network.rods] + self._scene.slice(network).start for network in self._scene.networks]
        first, second = np.concatenate([np.zeros((0, 2), dtype=np.int64), *rods]).T
        count = len(first)
        at = np.arange(count)
        rows = np.zeros((2, count, 2, *places.shape))
        for end, sign in ((first, -1.0), (second, 1.0)):
            r, v = sign * (places[second] - places[first]), sign * (speeds[second] - speeds[first])
            rows[0, at, 0, end] = r * self._pilot.extent
            rows[1, at, 1, end] = r * self._pilot.speed
            rows[1, at, 0, end] = v * self._pilot.extent
        free = 2 * int(self._free.sum()) * self._scene.dimension
        equations: FloatArray = rows[:, :, :, self._free].reshape(2 * count, free)
        sizes = lengths(equations)[:, np.newaxis]
        return equations / np.where(sizes > 0.0, sizes, 1.0)


@dataclass(frozen=True)
class Pilot:
    """Properties of the first part of a motion."""

    dt: float
    """Time step [s]: the given one, or the smallest of the automatic ones."""
    extent: float
    """Largest distance of a particle from the middle along an axis [m]."""
    speed: float
    """Largest speed along an axis [m/s]."""


def _pilot(scene: Scene, duration: float, numerics: Options) -> Pilot:
    """The properties of a motion, from a part of it."""
    run = Simulation(scene, **numerics)
    given = not isinstance(numerics.get("dt", "auto"), (str, StepRule))
    places, speeds = [run.positions], [run.velocities]
    dt = run.dt
    for _ in range(LOOKS):
        run.run(duration / LOOKS)
        places.append(run.positions)
        speeds.append(run.velocities)
        dt = dt if given else min(dt, run.dt)
    extent, speed = float(np.ptp(np.concatenate(places), axis=0).max()) / 2.0, float(np.abs(speeds).max())
    extent = extent or speed * duration or 1.0
    return Pilot(dt, max(extent, TINY), max(speed, extent / (duration / PILOT), TINY))


def _refuse_more_than_places_and_velocities(scene: Scene) -> None:
    """Check that positions and velocities are the whole state.

    Raises:
        SceneError: there is further state.
    """
    networks = scene.networks
    reasons = {
        "no bodies": not scene.bodies,
        "systems beside bodies": bool(scene.systems),
        "a Fluid, which has densities": bool(scene.fluids),
        "springs that can break": any(body.can_tear for body in networks),
        "springs in a periodic domain, which may reach across its faces": bool(networks) and bool(scene.periodic),
    }
    for reason, found in reasons.items():
        if found:
            raise SceneError(
                f"lyapunov.scene: must be Tracers, or a scene whose state is positions and velocities, got {reason}"
            )
