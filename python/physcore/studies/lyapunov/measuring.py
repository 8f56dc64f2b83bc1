"""Measurement of Lyapunov exponents: the growth of the offsets of neighbors, averaged over time."""

from __future__ import annotations

from typing import Unpack

import numpy as np

from physcore.arithmetic import log
from physcore.checks import BoolArray, FloatArray, count, flag, shown, span
from physcore.entrance import entrance
from physcore.errors import SceneError
from physcore.numerics.choices import Options
from physcore.progress import Progress
from physcore.scene.scene import Scene
from physcore.studies.lyapunov.exponents import Lyapunov
from physcore.studies.lyapunov.flows import Flow
from physcore.studies.lyapunov.mechanics import Mechanics
from physcore.studies.lyapunov.neighbors import Paths
from physcore.systems.tracers import Tracers
from physcore.units.systems import SI, UnitSystem

EXPONENTIAL = 1.5
"""Growth above which it is exponential, in units of that of a distance that grows in proportion to time."""

FEWEST, FOLDS = 4, 3.0
"""Number of intervals below which growth is exponential if its total logarithm is above the second number."""

PARTS = 10
"""Number of parts of the duration whose scatter gives the error for a single trajectory."""


@entrance
def lyapunov(
    scene: Scene | Tracers,
    duration: float,
    transient: float = 0.0,
    interval: float | None = None,
    *,
    exponents: int = 1,
    progress: bool | None = None,
    **numerics: Unpack[Options],
) -> Lyapunov:
    """Measure the largest Lyapunov exponents of the motion of a scene, or all exponents of a flow with tracers.

        pendulum = pc.SpringNetwork([[0, 0], [1, 0], [2, 0]], [[0, 1], [1, 2]], math.inf, fixed=[0])
        scene = pc.Scene(pendulum, pc.Gravity((0.0, -9.81)))
        chaos = pc.lyapunov(scene, duration=4.0, dt=0.005)
        chaos.exponents[0], chaos.errors[0]  # how fast two double pendulums part [1/s]

        cloud = pc.Tracers(rng.normal(size=(200, 3)) + (0, 0, 25), pc.Lorenz())
        spectrum = pc.lyapunov(cloud, duration=200.0, transient=20.0, dt=0.01)
        spectrum.exponents  # 0.906, 0.000, -14.572
        spectrum.dimension  # 2.062

    Each trajectory has neighbors along the axes of a small orthogonal frame. After each interval their offsets are
    orthonormalized by a QR decomposition. The exponents are the logarithms of the diagonal of R, averaged over time and
    trajectories. The offsets are 1e-7 of the extent of the motion. Truncation and rounding errors are then both about
    1e-7 of the growth, below the integration error and the statistical error.

    For scenes, with any integrator, each neighbor is a separate run with equal steps, one for each exponent. Offsets of
    positions are relative to the extent of the motion, offsets of velocities to the largest speed, and those of fields
    of further systems to half of their ranges. With rods, the offsets obey their constraints. The exponents of regular
    motion fall to zero as log(t)/t, because distances grow in proportion to time. Where the growth is not told from
    this, `exponential` is False. The error is then at least the exponent itself, so that it is consistent with zero; a
    longer duration may tell.

    Args:
        scene: a scene of bodies and systems; or tracers at their initial positions. More tracers average like a longer
            duration. In the flow of PointVortices, the vortices move too.
        duration: averaging time [s], above zero.
        transient: time before averaging [s], in which trajectories reach the attractor, and neighbors their directions.
        interval: the time between two orthonormalizations [s]; None: 2/max|∇v| at the tracers; for scenes, a thousandth
            of the duration.
        exponents: number of exponents of a scene, the largest ones: at most the dimension of its state.
        progress: whether to show a progress bar; None: on a terminal, after one second.
        numerics: integrator, dt and threads, as in Simulation; the precision is double. For scenes, an adaptive dt is
            replaced by its smallest value in the first part of the motion.

    Raises:
        SceneError: an argument is not valid; or the scene has further state than positions, velocities and fields, such
            as a Fluid, springs that can break, or absorbing edges.
        PhyscoreError: neighbors separate by a factor above 1e4 in an interval, which must be shorter.
        SimulationDiverged: a tracer goes to infinity, or the motion of bodies is not resolved.

    Source: G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15, 9 and 21 (1980); A. Wolf, J. B. Swift,
    H. L. Swinney, J. A. Vastano, Physica D 16, 285 (1985).
    """
    if numerics.get("precision", "f64") not in ("f64", "auto"):
        raise SceneError("lyapunov.precision: must be 'f64': neighbors are 1e-7 apart")
    average, before = span(duration, "lyapunov.duration"), span(transient, "lyapunov.transient", empty=True)
    step = None if interval is None else span(interval, "lyapunov.interval")
    number = count(exponents, "lyapunov.exponents", least=1)
    bar = None if progress is None else flag(progress, "progress")
    choices: Options = {**numerics, "precision": "f64"}
    if isinstance(scene, Scene):
        with scene.units.worded():
            return _averaged(Mechanics(scene, number, before, average, step, choices), bar, scene.units)
    if not isinstance(scene, Tracers):
        raise SceneError(f"lyapunov.scene: must be a Scene or Tracers, got {shown(scene)}")
    if len(scene) == 0:
        raise SceneError("lyapunov.scene: must be at least one tracer")
    return _averaged(Flow(scene, before, average, step, choices), bar, SI)


def _averaged(paths: Paths, progress: bool | None, units: UnitSystem) -> Lyapunov:
    """The mean growth along trajectories, after the transient."""
    warm, counted = paths.intervals
    parts: list[tuple[float, FloatArray]] = []
    history = []
    with Progress(warm + counted, "measuring", progress) as bar:
        for index in range(warm):
            paths.advance()
            bar.update(index + 1)
        growth, start = np.zeros(1), paths.time
        for index in range(counted):
            growth = growth + paths.advance()
            history.append((paths.time, growth.mean(axis=0)))
            bar.update(warm + index + 1)
            if (index + 1) * PARTS // counted > len(parts):
                parts.append((paths.time, growth.mean(axis=0)))
    each = growth / (paths.time - start)
    order = np.argsort(-each.mean(axis=0))
    each = each[:, order]
    errors = _scatter(each) if len(each) > 1 else _scatter(_rates(start, parts))[order]
    exponents, exponential = each.mean(axis=0), _is_exponential(*map(np.array, zip(*history, strict=True)))[order]
    errors = np.where(exponential, errors, np.fmax(errors, np.abs(exponents)))
    return Lyapunov(exponents, errors, each, paths.time - start, paths.directions, exponential, units)


def _is_exponential(times: FloatArray, growth: FloatArray) -> BoolArray:
    """Whether distances grow in proportion to e^(λ t), not to the time itself; shape (K,).

    The growth is the difference of two mean logarithms, over the second half and over the quarter before. These means
    even out oscillations.

    Args:
        times: times since the start of the motion [s], shape (F,).
        growth: accumulated logarithms of the distances (F, K).
    """
    count = len(growth)
    if count < FEWEST:
        told: BoolArray = np.abs(growth[-1]) > FOLDS
        return told
    late, early = (part.mean(axis=0) for part in (growth[count // 2 :], growth[count // 4 : count // 2]))
    linear = log(times)
    told = np.abs(late - early) > EXPONENTIAL * (linear[count // 2 :].mean() - linear[count // 4 : count // 2].mean())
    return told


def _rates(start: float, parts: list[tuple[float, FloatArray]]) -> FloatArray:
    """The growth rates [1/s] in each part of the time, from the accumulated growth at the end of each."""
    times = np.diff([start, *(time for time, _ in parts)])
    growth = np.array([grown for _, grown in parts])
    rates: FloatArray = np.diff(growth, axis=0, prepend=0.0 * growth[:1]) / times[:, np.newaxis]
    return rates if len(parts) == PARTS else rates[:0]


def _scatter(rates: FloatArray) -> FloatArray:
    """The standard error of the mean of several rates (N, K), shape (K,); NaN for fewer than two."""
    if len(rates) < 2:
        return np.full(rates.shape[1], np.nan)
    error: FloatArray = rates.std(axis=0, ddof=1) / np.sqrt(len(rates))
    return error
