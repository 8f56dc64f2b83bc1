"""From a wish to a recording: with given numerics, or with those that keep an error within what was asked for."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Unpack

import numpy as np

from physcore.checks import flag, is_word, number, span
from physcore.errors import AccuracyError, SceneError, SimulationDiverged
from physcore.numerics.choices import FRAMES_PER_SECOND, Options, check
from physcore.numerics.integrators import INTEGRATORS, Integrator
from physcore.scene.scene import Scene
from physcore.simulation.frames import frame_count
from physcore.simulation.recording import CHANNELS, Recording, check_channels
from physcore.simulation.simulation import Simulation, require_scene, unwarned

DEEPEST = 30
"""Halvings of the time step after which a method is given up."""
FLAT = 0.7
"""A difference between two runs that shrinks less than this, twice, where it is small, has reached the floor of
rounding; of a method of first order it halves."""
SMALL = 1e-3
"""What is small, as a fraction of how far anything moves."""
PATIENCE = 10.0
"""Once a method has reached its floor, another is not tried that would take this many times as long as all so far: it
would take more steps, and rounding adds up with them."""
STUCK = 6
"""As often as this a difference that is not small may refuse to shrink: else it is chaos, or nothing converges."""


def simulate(
    scene: Scene,
    duration: float,
    fps: float = FRAMES_PER_SECOND,
    *,
    channels: tuple[str, ...] = CHANNELS,
    progress: bool | None = None,
    accuracy: float | None = None,
    energy_drift: float | None = None,
    **numerics: Unpack[Options],
) -> Recording:
    """Simulate a scene from its start and record it.

    With `accuracy` or `energy_drift` integrator and time step are chosen: methods race with ever finer steps, and the
    first that keeps its word wins. What is returned is the run at half of the step that was chosen, which proved it;
    what was achieved is printed, and is a note of the recording's plan.

    Args:
        scene: what to simulate.
        duration: [s].
        fps: frames per second of simulated time.
        channels: what to keep of each frame: "positions" and "velocities", of a Fluid also "densities" and "pressures".
        progress: whether to show a progress bar; None: on a terminal, when it takes longer than a second.
        accuracy: how far any particle may be from where it should be, at any frame [m].
        energy_drift: how far the energy balance may drift, as `Recording.energy.drift` counts it.
        numerics: integrator, dt, precision, threads, max_energy_growth, on_divergence, as in Simulation; dt is not to
            be given with `accuracy` or `energy_drift`, and an integrator that is given is the only one that is tried.

    Raises:
        SceneError, SimulationDiverged: as for Simulation.
        AccuracyError: no method keeps the accuracy or the drift; with the best that was reached.
    """
    if progress is not None:
        flag(progress, "progress")
    if accuracy is None and energy_drift is None:
        return Simulation(scene, **numerics).record(duration, fps, channels, progress=progress)
    require_scene(scene)
    if not is_word(numerics.get("dt", "auto"), "auto"):
        raise SceneError("dt: is what accuracy= and energy_drift= choose; leave it out")
    wish = Wish(
        math.inf if accuracy is None else number(accuracy, "accuracy", above=0.0),
        math.inf if energy_drift is None else number(energy_drift, "energy_drift", above=0.0),
    )
    kept = check_channels(channels, scene)
    whole, rate = span(duration, "duration", empty=True), span(fps, "fps")
    if frame_count(whole, rate) < 2:
        raise SceneError("fps: there is no frame but the first; ask for more of them, or for a longer duration")
    runners = list(_runners(scene, whole, rate, kept, numerics))
    recording, proof = _race(runners, wish, _advice(numerics, scene))
    print(proof)
    return replace(recording, plan=replace(recording.plan, notes=(*recording.plan.notes, proof)))


@dataclass(frozen=True)
class Wish:
    """What is asked for."""

    accuracy: float
    """[m]; inf: any."""
    drift: float
    """Of the energy balance; inf: any."""


@dataclass
class Runner:
    """One integrator on its way to finer steps."""

    scene: Scene
    duration: float
    fps: float
    channels: tuple[str, ...]
    options: Options
    order: int
    """The order that holds in this scene."""
    steps: int
    """Of the next run, in each interval between two frames."""
    seconds: float = 0.0
    """What the last run took; 0 before the first."""
    runs: list[Recording] = field(default_factory=list)
    """The last two that came to an end."""
    changes: list[float] = field(default_factory=list)
    """The largest distances between each run and the one before it [m]."""
    failed: int = 0

    @property
    def integrator(self) -> Integrator:
        """How it steps."""
        integrator = self.options["integrator"]
        assert isinstance(integrator, Integrator)
        return integrator

    def advance(self) -> None:
        """Run with half the step of the last time."""
        begin = time.perf_counter()
        dt = 1.0 / (self.fps * self.steps)
        self.steps *= 2
        channels = tuple(dict.fromkeys(("positions", *self.channels)))
        try:
            with unwarned():
                self.options["dt"] = dt
                simulation = Simulation(self.scene, **self.options)
            run = simulation.record(self.duration, self.fps, channels, progress=False)
        except SimulationDiverged:
            self.failed += 1
            self.runs.clear()
            return
        finally:
            self.seconds = time.perf_counter() - begin
        self.runs = [*self.runs, run][-2:]
        if len(self.runs) == 2:
            change = self.runs[1].positions - self.runs[0].positions
            if self.scene.periodic is not None:
                change = self.scene.periodic.nearest(change)
            self.changes.append(float(np.linalg.norm(change, axis=-1).max()))

    @property
    def errors(self) -> tuple[float, float]:
        """Those of the last two runs, from what changed between them; inf before there are two.

        With errors C dtᵖ the coarser is off by the change times 2ᵖ/(2ᵖ − 1), the finer by the change over 2ᵖ − 1. The
        order p is the one that was seen, between 1 and the nominal one; 1 where nothing was seen yet.
        """
        if not self.changes or len(self.runs) < 2:
            return math.inf, math.inf
        order = 1.0
        if len(self.changes) > 1 and 0.0 < self.changes[-1] < self.changes[-2]:
            order = min(max(1.0, math.log2(self.changes[-2] / self.changes[-1])), float(self.order))
        gain = 2.0**order
        return self.changes[-1] * gain / (gain - 1.0), self.changes[-1] / (gain - 1.0)

    @property
    def drifts(self) -> tuple[float, float]:
        """The energy drifts of the last two runs; inf before there are two."""
        if len(self.runs) < 2:
            return math.inf, math.inf
        coarse, fine = (float(np.abs(run.energy.drift).max()) for run in self.runs)
        return coarse, fine

    def keeps(self, wish: Wish) -> bool:
        """Whether the coarser of the last two runs did what was asked for, as the finer one proves."""
        return len(self.runs) == 2 and self.errors[0] <= wish.accuracy and self.drifts[0] <= wish.drift

    def expected(self, wish: Wish) -> float:
        """What it will take until then, about [s]; 0 where nobody knows."""
        if not self.changes or len(self.runs) < 2:
            return 2.0 * self.seconds
        excess = max(self.errors[0] / wish.accuracy, self.drifts[0] / wish.drift, 1.0)
        return float(2.0 * self.seconds * excess ** (1.0 / max(1, self.order)))

    @property
    def given_up(self) -> bool:
        """Whether finer steps have stopped to help: at the floor of rounding, or because nothing converges."""
        if self.failed + len(self.changes) > DEEPEST:
            return True
        flat = [later > FLAT * earlier for earlier, later in zip(self.changes, self.changes[1:], strict=False)]
        if not self.runs or len(flat) < 2:
            return False
        motion = float(np.abs(self.runs[-1].positions - self.runs[-1].positions[0]).max())
        least = 2 if self.changes[-1] < SMALL * motion else STUCK
        return len(flat) >= least and all(flat[-least:])


def _runners(
    scene: Scene, duration: float, fps: float, channels: tuple[str, ...], options: Options
) -> Iterator[Runner]:
    """All integrators that can compute the scene, or the one that was given; above order 1 where there is a choice."""
    given = options.get("integrator", "auto")
    candidates = [kind() for kind in INTEGRATORS if kind.order > 1] if is_word(given, "auto") else [given]
    refusal: SceneError | None = None
    for integrator in candidates:
        mine: Options = {**options, "integrator": integrator, "dt": 1.0 / fps}
        try:
            with unwarned():
                plan = Simulation(scene, **mine).plan
        except SceneError as error:
            refusal = error
            continue
        limit = plan.dt_limit if plan.dt_limit > 0.0 else math.inf
        steps = max(1, math.ceil(1.0 / (fps * limit) - 1e-9))
        yield Runner(scene, duration, fps, channels, mine, plan.order, steps)
    if refusal is not None and len(candidates) == 1:
        raise refusal


def _race(runners: list[Runner], wish: Wish, advice: str) -> tuple[Recording, str]:
    """The run that proves the first choice to do what was asked for, and what it proved."""
    best: Runner | None = None
    closest = (math.inf, math.inf)
    left, spent, floored = list(runners), 0.0, False
    while left:
        runner = min(left, key=lambda each: each.expected(wish))
        if floored and runner.expected(wish) > PATIENCE * spent:
            break
        runner.advance()
        spent += runner.seconds
        if runner.keeps(wish):
            recording = runner.runs[-1]
            return replace(recording, channels={name: recording.channels[name] for name in runner.channels}), _proof(
                runner
            )
        if runner.errors[1] < closest[0]:
            closest, best = (runner.errors[1], runner.drifts[1]), runner
        if runner.given_up:
            left.remove(runner)
            runner.runs.clear()
            floored = True
    asked = [f"within {wish.accuracy:g} m"] * math.isfinite(wish.accuracy)
    asked += [f"energy drift {wish.drift:g}"] * math.isfinite(wish.drift)
    reached = (
        f"the best was {type(best.integrator).__name__}, off by {closest[0]:.1e} m with a drift of {closest[1]:.1e}"
        if best is not None
        else "every one diverged"
    )
    raise AccuracyError(
        f"{'accuracy' if math.isfinite(wish.accuracy) else 'energy_drift'}: no method gets there ({', '.join(asked)}): "
        f"{reached}; {advice}",
        error=closest[0],
        energy_drift=closest[1],
    )


def _advice(numerics: Options, scene: Scene) -> str:
    """What to change where nothing does what was asked for."""
    advice = []
    if check(numerics, scene).precision == "f32":
        advice.append('take precision="f64"')
    if not is_word(numerics.get("integrator", "auto"), "auto"):
        advice.append("leave integrator out, so that others are tried")
    chaos = "no trajectory can be followed for long: pc.tradeoff(scene, duration) says until when"
    return "; ".join([*advice, f"where the motion is chaotic {chaos}"])


def _proof(runner: Runner) -> str:
    coarse, fine = runner.errors
    name, dt = type(runner.integrator).__name__, runner.runs[-1].plan.dt
    return (
        f"{name} with dt = {2.0 * dt:.4g} s keeps within {coarse:.1e} m (energy drift {runner.drifts[0]:.1e}), as a "
        f"run at half the step proves; that run is the one returned: {fine:.1e} m, drift {runner.drifts[1]:.1e}"
    )
