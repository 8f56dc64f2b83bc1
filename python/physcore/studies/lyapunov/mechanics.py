"""Items of a scene, with neighbors as separate runs."""

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
from physcore.studies.lyapunov.neighbors import APART, orthonormalized, random_frame
from physcore.studies.lyapunov.offsets import shares

PILOT, LOOKS = 1.0 / 8.0, 32
"""Fraction of the motion that determines its extent, and number of samples in it."""
INTERVALS = 1000
"""Default number of orthonormalizations over the duration."""

SINGULAR = 1e-9
"""Tolerance of independence: a constraint of length 1 is independent if more than this remains after projection."""


class Mechanics:
    """A run of a scene, and one neighboring run for each exponent.

    Offsets are those of the positions and velocities of free particles, relative to the extent and the largest speed of
    the first part of the motion, and of the fields of further systems, relative to half of their ranges. With rods,
    they are initially in the tangent space of the constraints, and the integrator keeps them there.

    Args:
        scene: the scene.
        exponents: the number of exponents, the largest ones.
        before: the time before averaging [s].
        average: the averaging time [s].
        interval: the time between two orthonormalizations [s]; None: a thousandth of `average`.
        numerics: as in Simulation.

    Raises:
        SceneError: the scene has further state than positions, velocities and fields, or it has fewer exponents.
    """

    def __init__(
        self, scene: Scene, exponents: int, before: float, average: float, interval: float | None, numerics: Options
    ) -> None:
        _refuse_further_state(scene)
        pilot = _pilot(scene, PILOT * (before + average), numerics)
        self._scene, self._pilot = scene, pilot
        self._steps = max(1, round((interval or average / INTERVALS) / pilot.dt))
        self._interval = self._steps * pilot.dt
        self.intervals = steps_to(before, self._interval, 1e-9), max(1, steps_to(average, self._interval, 1e-9))
        options: Options = {**numerics, "dt": pilot.dt}
        with unwarned():  # The pilot run has issued the warnings.
            self._run, *self._neighbors = (Simulation(scene, **options) for _ in range(1 + exponents))
        self._shares = shares(scene)
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
        present = [share.read(self._run) for share in self._shares]
        ends = np.cumsum([share.size(own) for share, own in zip(self._shares, present, strict=True)])[:-1]
        for share, own in zip(self._shares, present, strict=True):
            # The state of all runs is set, so that multistep methods restart in each.
            share.write(self._run, own)
        for neighbor, frame in zip(self._neighbors, self._frames[0], strict=True):
            parts = zip(self._shares, present, self._pilot.scales, np.split(APART * frame, ends), strict=True)
            for share, own, scales, offset in parts:
                share.write(neighbor, share.moved(own, scales, offset))
        for run in (self._run, *self._neighbors):
            run.step(self._steps)
        offsets = np.array([self._offset(neighbor) for neighbor in self._neighbors]) / APART
        growth, self._frames = orthonormalized(offsets[np.newaxis], self._interval)
        return growth

    def _offset(self, neighbor: Simulation) -> FloatArray:
        """The offset of a neighbor, relative to the scales (P,)."""
        pairs = zip(self._shares, self._pilot.scales, strict=True)
        return np.concatenate(
            [share.offset(share.read(neighbor), share.read(self._run), scales) for share, scales in pairs]
        )

    def _constraints(self) -> FloatArray:
        """Equations of the rods for offsets at the start (2 M, P): r·δr = 0 and r·δv + v·δr = 0.

        Here r is the separation of the ends of a rod and v its rate. Rows have the length 1, or 0 where both vanish.
        """
        size = sum(share.size(share.read(self._run)) for share in self._shares)
        if not self._scene.has_rods:
            return np.zeros((0, size))
        places, speeds = self._run.positions, self._run.velocities
        extent, speed = self._pilot.scales[0]
        rods = [network.pairs[network.rods] + self._scene.slice(network).start for network in self._scene.networks]
        first, second = np.concatenate([np.zeros((0, 2), dtype=np.int64), *rods]).T
        count = len(first)
        at = np.arange(count)
        rows = np.zeros((2, count, 2, *places.shape))
        for end, sign in ((first, -1.0), (second, 1.0)):
            r, v = sign * (places[second] - places[first]), sign * (speeds[second] - speeds[first])
            rows[0, at, 0, end] = r * extent
            rows[1, at, 1, end] = r * speed
            rows[1, at, 0, end] = v * extent
        own = rows[:, :, :, self._shares[0].free].reshape(2 * count, -1)
        equations: FloatArray = np.zeros((2 * count, size))
        equations[:, : own.shape[1]] = own
        sizes = lengths(equations)[:, np.newaxis]
        return equations / np.where(sizes > 0.0, sizes, 1.0)


@dataclass(frozen=True)
class Pilot:
    """Properties of the first part of a motion."""

    dt: float
    """Time step [s]: the given one, or the smallest of the automatic ones."""
    scales: tuple[tuple[float, ...], ...]
    """Scale of each field of the state, for each item."""


def _pilot(scene: Scene, duration: float, numerics: Options) -> Pilot:
    """The properties of a motion, from a part of it."""
    run = Simulation(scene, **numerics)
    given = not isinstance(numerics.get("dt", "auto"), (str, StepRule))
    items = shares(scene)
    seen = [[share.read(run)] for share in items]
    dt = run.dt
    for _ in range(LOOKS):
        run.run(duration / LOOKS)
        for share, own in zip(items, seen, strict=True):
            own.append(share.read(run))
        dt = dt if given else min(dt, run.dt)
    pairs = zip(items, seen, strict=True)
    return Pilot(dt, tuple(share.scales(own, duration, duration / PILOT) for share, own in pairs))


def _refuse_further_state(scene: Scene) -> None:
    """Check that positions, velocities and fields are the whole state.

    Raises:
        SceneError: there is further state.
    """
    networks = scene.networks
    reasons = {
        "a Fluid, which has densities": bool(scene.fluids),
        "rigid bodies, which have orientations": scene.has_rigid_bodies,
        "springs that can break": any(body.can_tear for body in networks),
        "a field with absorbing edges, which have values of their own": any(grid.is_open for grid in scene.grids),
        "springs in a periodic domain, which may reach across its faces": bool(networks) and bool(scene.periodic),
    }
    for reason, found in reasons.items():
        if found:
            raise SceneError(
                f"lyapunov.scene: must be Tracers, or a scene whose state is positions, velocities and fields, "
                f"got {reason}"
            )
