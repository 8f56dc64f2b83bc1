"""XPBD of cloth by other libraries, as far as they are installed: pyPBD (PositionBasedDynamics), Newton, and Warp.

All on one thread: what Warp compiles for processors runs on one, and PositionBasedDynamics is told to by OpenMP.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import os
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rivals.sweeps import colors

os.environ.setdefault("OMP_NUM_THREADS", "1")

Array = NDArray[Any]
SWEEPS = 10
"""In each step."""


class PyPBD:
    """The library of J. Bender and others, in double precision: Gauss and Seidel's iteration, group by group."""

    name = "PositionBasedDynamics (pyPBD)"
    precision = "f64"
    needs = ("pypbd",)

    def __init__(self, body: Any, h: float) -> None:
        import pypbd

        simulation = pypbd.Simulation.getCurrent()  # there is one for all models
        simulation.initDefault()
        self._model, self._stepper = pypbd.SimulationModel(), simulation.getTimeStep()
        self._model.init()
        simulation.setModel(self._model)
        self._particles = self._model.getParticles()
        # Its gravity is along the second axis.
        for at, velocity, mass, fixed in zip(body.positions, body.velocities, body.mass, body.fixed, strict=True):
            index = self._particles.size()
            self._particles.addVertex(at[[0, 2, 1]])
            self._particles.setVelocity(index, velocity[[0, 2, 1]])
            self._particles.setMass(index, 0.0 if fixed else mass)
        for (one, other), stiffness in zip(body.pairs.tolist(), body.stiffness, strict=True):
            self._model.addDistanceConstraint_XPBD(one, other, stiffness)
        self._stepper.setValueUInt(pypbd.TimeStepController.NUM_SUB_STEPS, 1)
        self._stepper.setValueUInt(pypbd.TimeStepController.MAX_ITERATIONS, SWEEPS)
        self._clock, self._h = pypbd.TimeManager.getCurrent(), h

    @property
    def x(self) -> Array:
        """Positions [m]."""
        return np.array(self._particles.getVertices())[:, [0, 2, 1]]

    def step(self, steps: int) -> None:
        """Take steps."""
        self._clock.setTimeStepSize(self._h)
        for _ in range(steps):
            self._stepper.step(self._model)


@cache
def warp() -> Any:
    """Warp, silent."""
    with contextlib.redirect_stdout(io.StringIO()):
        import warp

        warp.config.quiet = True
        warp.init()
    return warp


class Newton:
    """Newton's XPBD, in single precision: all springs at once, with relaxation."""

    name = "Newton (Jacobi, relaxed)"
    precision = "f32"
    needs = ("warp", "newton")

    def __init__(self, body: Any, h: float) -> None:
        warp()
        import newton

        builder = newton.ModelBuilder(gravity=(0.0, 0.0, -9.81))
        builder.add_particles(
            body.positions.tolist(),
            body.velocities.tolist(),
            np.where(body.fixed, 0.0, body.mass).tolist(),
            radius=[1e-6] * len(body),
        )
        for (one, other), stiffness in zip(body.pairs.tolist(), body.stiffness.tolist(), strict=True):
            builder.add_spring(one, other, stiffness, 0.0, 0.0)
        self._model = builder.finalize(device="cpu")
        self._model.particle_grid, self._model.particle_max_radius = None, 0.0  # no contacts of particles
        self._solver = newton.solvers.SolverXPBD(self._model, iterations=SWEEPS)
        self._states, self._control, self._h = [self._model.state(), self._model.state()], self._model.control(), h

    @property
    def x(self) -> Array:
        """Positions [m]."""
        return self._states[0].particle_q.numpy()

    def step(self, steps: int) -> None:
        """Take steps."""
        for _ in range(steps):
            self._states[0].clear_forces()
            self._solver.step(self._states[0], self._states[1], self._control, None, self._h)
            self._states.reverse()


@cache
def kernels() -> tuple[Any, Any, Any]:
    """Prediction, the sweep over a color, and velocities, as one writes them in Warp."""
    wp = warp()

    @wp.kernel
    def predict(x: wp.array(dtype=wp.vec3), v: wp.array(dtype=wp.vec3), w: wp.array(dtype=float), h: float) -> None:
        i = wp.tid()
        if w[i] > 0.0:
            v[i] = v[i] + wp.vec3(0.0, 0.0, -9.81 * h)
        x[i] = x[i] + h * v[i]

    @wp.kernel
    def sweep(
        x: wp.array(dtype=wp.vec3),
        w: wp.array(dtype=float),
        pairs: wp.array(dtype=wp.vec2i),
        rest: wp.array(dtype=float),
        compliance: wp.array(dtype=float),
        multipliers: wp.array(dtype=float),
        first: int,
    ) -> None:
        k = first + wp.tid()
        i, j = pairs[k][0], pairs[k][1]
        apart = x[j] - x[i]
        length = wp.length(apart)
        weight = w[i] + w[j] + compliance[k]
        change = (length - rest[k] - compliance[k] * multipliers[k]) / weight
        multipliers[k] = multipliers[k] + change
        x[i] = x[i] + (w[i] * change / length) * apart
        x[j] = x[j] - (w[j] * change / length) * apart

    @wp.kernel
    def velocities(
        x: wp.array(dtype=wp.vec3), before: wp.array(dtype=wp.vec3), v: wp.array(dtype=wp.vec3), h: float
    ) -> None:
        i = wp.tid()
        v[i] = (x[i] - before[i]) / h

    return predict, sweep, velocities


class Warp:
    """Kernels of our own in Warp, in single precision: Gauss and Seidel's iteration, a launch for each color."""

    name = "Warp, by colors"
    precision = "f32"
    needs = ("warp",)

    def __init__(self, body: Any, h: float) -> None:
        wp = warp()
        of, (self._predict, self._sweep, self._velocities) = colors(body.pairs), kernels()
        order = np.argsort(of, kind="stable")
        ends = np.searchsorted(of[order], np.arange(of.max() + 2))
        self._parts = list(zip(ends[:-1].tolist(), np.diff(ends).tolist(), strict=True))
        self._x, self._v = (wp.array(each, dtype=wp.vec3, device="cpu") for each in (body.positions, body.velocities))
        self._before = wp.empty_like(self._x)
        numbers = {
            "w": np.where(body.fixed, 0.0, 1.0 / body.mass),
            "rest": body.rest_length[order],
            "compliance": 1.0 / (body.stiffness[order] * h * h),
            "multipliers": np.zeros(len(order)),
        }
        self._numbers = {name: wp.array(each, dtype=float, device="cpu") for name, each in numbers.items()}
        self._pairs, self._h = wp.array(body.pairs[order], dtype=wp.vec2i, device="cpu"), h

    @property
    def x(self) -> Array:
        """Positions [m]."""
        return self._x.numpy()

    def step(self, steps: int) -> None:
        """Take steps."""
        wp, x, v, h = warp(), self._x, self._v, self._h
        w, rest, compliance, multipliers = self._numbers.values()
        for _ in range(steps):
            wp.copy(self._before, x)
            multipliers.zero_()
            wp.launch(self._predict, dim=len(x), inputs=[x, v, w, h], device="cpu")
            for _ in range(SWEEPS):
                for first, count in self._parts:
                    inputs = [x, w, self._pairs, rest, compliance, multipliers, first]
                    wp.launch(self._sweep, dim=count, inputs=inputs, device="cpu")
            wp.launch(self._velocities, dim=len(x), inputs=[x, self._before, v, h], device="cpu")


LIBRARIES = (PyPBD, Newton, Warp)
"""The opponents."""


def installed(library: type[PyPBD | Newton | Warp]) -> bool:
    """Whether it can be imported."""
    return all(map(importlib.util.find_spec, library.needs))
