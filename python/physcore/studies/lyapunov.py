"""Lyapunov exponents of flows: how fast neighboring tracers part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Unpack

import numpy as np

from physcore.checks import FloatArray, flag, shown, span
from physcore.errors import PhyscoreError, SceneError
from physcore.numerics.choices import Options, steps_to
from physcore.progress import Progress
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation
from physcore.spelling import spelled
from physcore.systems.point_vortices import PointVortices
from physcore.systems.tracers import Tracers

APART = 1e-7
"""The distance of neighbors, as a fraction of the largest coordinate: truncation is relative to it, and rounding to
1e-16 over it."""
TINY = 1e-30
"""The smallest extent [m]."""
FARTHEST = 1e4
"""The largest growth of a distance between two orthonormalizations: neighbors stay in the linear range."""


@dataclass(frozen=True, eq=False)
class Lyapunov:
    """The Lyapunov exponents of a flow, the largest first.

        cloud = pc.Tracers(rng.normal(size=(20, 3)) + (0, 0, 25), pc.Lorenz())
        spectrum = pc.lyapunov(cloud, duration=5.0, transient=1.0, dt=0.01)  # a Lyapunov
        spectrum.exponents, spectrum.dimension

    `lyapunov` measures it.
    """

    exponents: FloatArray
    """Mean rates of growth λ along the D directions of the tangent space [1/s], shape (D,)."""
    errors: FloatArray
    """Their standard errors from the scatter among tracers [1/s], shape (D,); not a number of a single tracer."""
    each: FloatArray
    """The exponents along the path of each tracer [1/s], shape (N, D)."""
    duration: float
    """The time over which they were averaged [s]."""

    @property
    def sum(self) -> float:
        """Σ λ, the mean rate at which volumes grow [1/s]."""
        return float(self.exponents.sum())

    @property
    def dimension(self) -> float:
        """The dimension of the attractor by Kaplan and Yorke: j + (λ₁ + … + λⱼ)/|λⱼ₊₁|, with the largest j at which
        that sum is not below zero.
        """
        sums = np.cumsum(self.exponents)
        j = int((sums >= 0.0).sum())
        if j == 0 or j == len(sums):
            return float(j)
        return j + float(sums[j - 1] / abs(self.exponents[j]))


@spelled
def lyapunov(
    tracers: Tracers,
    duration: float,
    transient: float = 0.0,
    interval: float | None = None,
    *,
    progress: bool | None = None,
    **numerics: Unpack[Options],
) -> Lyapunov:
    """The full spectrum of Lyapunov exponents of the flow that tracers are in.

        cloud = pc.Tracers(rng.normal(size=(200, 3)) + (0, 0, 25), pc.Lorenz())
        spectrum = pc.lyapunov(cloud, duration=200.0, transient=20.0, dt=0.01)
        spectrum.exponents  # 0.906, 0.000, -14.572
        spectrum.dimension  # 2.062

    Each tracer takes D neighbors along, on the axes of a small orthogonal frame, in the same run. After each interval
    their offsets are orthonormalized by a QR decomposition; the logarithms of its diagonal, averaged over time and over
    the tracers, are the exponents. The offsets are 1e-7 of the largest coordinate, where truncation and rounding
    both are some 1e-7 of a growth, below the error of the integrator and the statistical one.

    Args:
        tracers: from where the paths begin; more of them average as a longer duration does. In the flow of
            PointVortices these move too.
        duration: how long is averaged [s], above zero.
        transient: how long tracers move before that, to be on the attractor, and neighbors, to turn to their directions
            [s].
        interval: the time between two orthonormalizations [s]; None: 2/max|∇v| at the tracers.
        progress: whether to show a progress bar; None: on a terminal, when it takes longer than a second.
        numerics: integrator, dt and threads, as in Simulation; the precision is double.

    Raises:
        SceneError: an argument is not valid.
        PhyscoreError: neighbors part by more than 1e4 in an interval, which has to be shorter.
        SimulationDiverged: a tracer runs to infinity.

    Source: G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15, 9 and 21 (1980); A. Wolf, J. B. Swift,
    H. L. Swinney, J. A. Vastano, Physica D 16, 285 (1985).
    """
    if not isinstance(tracers, Tracers):
        raise SceneError(f"lyapunov.tracers: must be Tracers, got {shown(tracers)}")
    if len(tracers) == 0:
        raise SceneError("lyapunov.tracers: must be at least one")
    if numerics.get("precision", "f64") not in ("f64", "auto"):
        raise SceneError("lyapunov.precision: must be 'f64': neighbors are 1e-7 apart")
    average, before = span(duration, "lyapunov.duration"), span(transient, "lyapunov.transient", empty=True)
    run, cloud = _with_neighbors(tracers, numerics)
    step = _interval(run) if interval is None else span(interval, "lyapunov.interval")
    warm, count = steps_to(before, step, 1e-9), max(1, steps_to(average, step, 1e-9))
    dimension = tracers.dimension
    # Along no axis: that may be a direction in which all stay that are on it.
    frame, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(dimension, dimension)))
    frames = np.broadcast_to(frame, (len(tracers), dimension, dimension))
    growth, start = np.zeros((len(tracers), dimension)), run.time
    with Progress(warm + count, "measuring", None if progress is None else flag(progress, "progress")) as bar:
        for index in range(warm + count):
            if index == warm:
                growth[:], start = 0.0, run.time
            logarithms, frames = _advance(run, cloud, frames, step)
            growth += logarithms
            bar.update(index + 1)
    each = growth / (run.time - start)
    each = each[:, np.argsort(-each.mean(axis=0))]
    scatter = each.std(axis=0, ddof=1) if len(each) > 1 else np.full(dimension, np.nan)
    return Lyapunov(each.mean(axis=0), scatter / np.sqrt(len(each)), each, run.time - start)


def _with_neighbors(tracers: Tracers, numerics: Options) -> tuple[Simulation, Tracers]:
    """A run of all tracers, each with D neighbors after it."""
    places = np.repeat(tracers.positions, tracers.dimension + 1, axis=0)
    cloud = Tracers(places, tracers.flow)
    scene = Scene(cloud, tracers.flow) if isinstance(tracers.flow, PointVortices) else Scene(cloud)
    options: Options = {**numerics, "precision": "f64"}
    return Simulation(scene, **options), cloud


def _interval(run: Simulation) -> float:
    """2/|∇v|, by the limit of accuracy, which is 0.1/|∇v|; the step where nothing limits it [s]."""
    limit = run.plan.dt_limit
    return 20.0 * limit if np.isfinite(limit) else run.dt


def _advance(run: Simulation, cloud: Tracers, frames: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    """The logarithms of the growth along each direction (N, D), and the frames (N, D, D) of rows after a step [s]."""
    dimension = frames.shape[-1]
    places = run[cloud].positions.reshape(-1, dimension + 1, dimension)
    distance = APART * max(float(np.abs(places).max()), TINY)
    places[:, 1:] = places[:, :1] + distance * frames
    run[cloud].set(positions=places.reshape(-1, dimension))
    run.run(step)
    moved = run[cloud].positions.reshape(places.shape)
    q, r = np.linalg.qr(((moved[:, 1:] - moved[:, :1]) / distance).swapaxes(1, 2))
    diagonal = np.diagonal(r, axis1=1, axis2=2)
    if np.abs(r).max() > FARTHEST:
        raise PhyscoreError(
            f"lyapunov.interval: neighbors parted by {np.abs(r).max():.1e} in {step:g} s; take a shorter interval"
        )
    result: FloatArray = np.log(np.abs(diagonal))
    turned: FloatArray = (q * np.sign(diagonal)[:, np.newaxis, :]).swapaxes(1, 2)
    return result, turned
