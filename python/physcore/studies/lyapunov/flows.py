"""Tracers in a flow, with their neighbors in one run."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray
from physcore.numerics.choices import Options, steps_to
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation
from physcore.studies.lyapunov.neighbors import APART, TINY, orthonormalized, random_frame
from physcore.systems.tracers import Tracers


class Flow:
    """All tracers, each followed by its D neighbors.

    Args:
        tracers: the tracers at their initial positions.
        before: the time before averaging [s].
        average: the averaging time [s].
        interval: the time between two orthonormalizations [s]; None: 2/max|∇v|.
        numerics: as in Simulation.
    """

    def __init__(
        self, tracers: Tracers, before: float, average: float, interval: float | None, numerics: Options
    ) -> None:
        dimension = tracers.dimension
        self.directions = dimension
        self._cloud = Tracers(np.repeat(tracers.positions, dimension + 1, axis=0), tracers.flow)
        scene = Scene(self._cloud, *tracers.partners)
        self._run = Simulation(scene, **numerics)
        # 2/|∇v|, from the limit of accuracy 0.1/|∇v|; without a limit, the time step.
        limit = self._run.plan.dt_limit
        self._interval = interval or (20.0 * limit if np.isfinite(limit) else self._run.dt)
        self.intervals = steps_to(before, self._interval, 1e-9), max(1, steps_to(average, self._interval, 1e-9))
        self._frames = np.broadcast_to(random_frame(dimension, dimension), (len(tracers), dimension, dimension))

    @property
    def time(self) -> float:
        """The present time [s]."""
        return self._run.time

    def advance(self) -> FloatArray:
        """Advance by an interval, and return the logarithms of the growth along each direction (N, D)."""
        dimension = self.directions
        places = self._run[self._cloud].positions.reshape(-1, dimension + 1, dimension)
        distance = APART * max(float(np.abs(places).max()), TINY)
        places[:, 1:] = places[:, :1] + distance * self._frames
        self._run[self._cloud].set(positions=places.reshape(-1, dimension))
        self._run.run(self._interval)
        moved = self._run[self._cloud].positions.reshape(places.shape)
        growth, self._frames = orthonormalized((moved[:, 1:] - moved[:, :1]) / distance, self._interval)
        return growth
