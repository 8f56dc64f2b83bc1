"""Stepper of a simulation: controls the number and the size of its steps."""

from __future__ import annotations

import math
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import asdict, replace
from typing import Any, NamedTuple, TypedDict

from physcore._core import World
from physcore.arithmetic import power
from physcore.checks import MOST, count, number
from physcore.errors import (
    MachWarning,
    PhyscoreError,
    SceneError,
    SceneWarning,
    SimulationDiverged,
    StabilityWarning,
    warn,
)
from physcore.numerics.choices import (
    FRAMES_PER_SECOND,
    AdaptiveStep,
    Limit,
    Numerics,
    StepRule,
    divide,
    free_step,
    largest_step,
    steps_to,
)
from physcore.scene.fluid import Fluid
from physcore.scene.records import Record
from physcore.scene.scene import Scene
from physcore.simulation import engine
from physcore.simulation.effort import ENCOUNTER_CURE, MOST_STEPS, is_encounter, long_run
from physcore.simulation.energy import BROKEN_DRIFT, FAIR_DRIFT, WRONG_DRIFT
from physcore.simulation.provenance import Segment, segments_from
from physcore.simulation.watch import Watch, stopped
from physcore.storage.archive import Tree
from physcore.systems.reaction_diffusion import ReactionDiffusion

CHECK_INTERVAL = 256
"""Number of steps between two checks of the limit of stability with dt="auto". Checks are at multiples of this number,
so that the bits do not depend on how the steps are requested.
"""

SHORT_CHECK_INTERVAL = 8
"""Number of steps between two checks of the limit with a fluid or a reaction.

At a tenth of the speed of sound and half of the limit, no particle of a fluid moves farther than a spacing in this
time. A check costs a reaction a few percent.
"""

RESOLVED_CHECK_INTERVAL = 16
"""Number of steps between two checks where oscillations are resolved: one or two periods of the fastest."""

FEW_CELLS = 10_000
"""Number of cells up to which the limit of a reaction is checked in each step, to resolve the fastest spikes."""

RESOLVED, NOTED = 0.005, 0.01
"""Errors of an oscillation after ten periods over its amplitude: of a resolved one, and of one that a note names."""

FIRST = 100
"""Number of steps before a drift with a given time step is warned of."""

DAMPINGS = ("drag", "spring damping")
"""Terms that limit the step by a decay, and not by an oscillation."""

COARSE = 25.0
"""Ratio of a given time step to the limit of accuracy above which it is warned of: a quarter of a turn in a step."""

NEAR = 0.5
"""Ratio of a given time step to a limit that varies above which the plan has a note; AutoStep() keeps to half."""

RECOVERED = 1.25
"""Factor by which the limit must rise before the time step follows it."""

SLOWEST = 64
"""Largest ratio of the initial time step to a later one. A spring compressed to zero length has no direction, and no
time step resolves it.
"""

FAST_SHARE = 0.02
"""Fraction of a fluid's particles that may exceed the Mach number without a warning, as spray and the tips of jets do
at any speed of sound. They are thin and have free surfaces, so that their density hardly changes.
"""

REHEARSED, REHEARSED_WORK, FEWEST = 20_000, 20_000_000, 100
"""Number of steps of a rehearsal, unless these are more steps of single particles than the second number; at least the
third number.
"""

STEADY = 1.5
"""Ratio of two numbers of steps per second up to which they count as equal."""

TIME_TOLERANCE = 1e-6
"""Tolerance of times, as a fraction of a step."""


class Before(NamedTuple):
    """State before a step that is watched."""

    world: Tree
    """Captured world."""
    time: float
    substepped: int
    segments: int
    """Number of segments."""
    segment: list[Segment]
    """The last segment."""


class Cut(NamedTuple):
    """Step that ended at an event."""

    steps: int
    """Number of steps up to its end."""
    dt: float
    """Length of the whole step [s]."""


class Captured(TypedDict):
    """State of a stepper in a checkpoint."""

    substepped: int
    limits: list[dict[str, Any]]
    segments: list[dict[str, Any]]


_UNWARNED = ContextVar("unwarned", default=False)


@contextmanager
def unwarned() -> Iterator[None]:
    """Suppress warnings, for runs whose time step the package itself chooses in order to measure the result."""
    token = _UNWARNED.set(True)
    try:
        yield
    finally:
        _UNWARNED.reset(token)


class Stepper:
    """Stepper of a world, with a given time step or one chosen from the limit of stability.

    The limit is that of the springs in their present directions. The certified limit is lower, and valid for all
    directions, as long as no spring is shorter than half its rest length. No automatic time step exceeds it. With
    dt="auto" the certified limit is checked periodically. A time step above it is replaced by a smaller one, and is
    restored when the limit rises again.
    """

    def __init__(self, world: World, scene: Scene, numerics: Numerics) -> None:
        self._world = world
        self._scene = scene
        self._numerics = numerics
        self._adaptive = numerics.adaptive
        self._limits: tuple[Limit, Limit] | None = None
        """The initial limit, and the limit that the present time step obeys; None unless dt="auto"."""
        self._varies = engine.limit_varies(world)
        self._interval = _check_interval(scene, numerics)
        self._stepping = threading.Lock()
        self._mach_warned = False
        self._long_warned = False
        self._substepped = 0
        self._segments: list[Segment] = []
        self._last: Before | None = None
        """The state before the last step that was watched."""
        self._cut: Cut | None = None
        """The last step that ended at an event."""

    def begin(self) -> None:
        """Find the limits before the first step. A stepper from a checkpoint uses `restore` instead.

        Raises:
            SceneError: no time step is certain to be stable.
        """
        if self.fixed is not None:
            self._warn_if_unstable(self.fixed)
            return
        if self._adaptive is None:
            self._limits = (engine.limit(self._world),) * 2
        self._largest(FRAMES_PER_SECOND)  # Raises for a scene without any stable step.

    @property
    def fixed(self) -> float | None:
        """The given time step [s], or None."""
        return None if isinstance(self._numerics.dt, StepRule) else self._numerics.dt

    @property
    def limit(self) -> Limit:
        """The limit of the time step; of the present state if the step follows the motion or was given."""
        if self._adaptive is not None:
            return engine.present_limit(self._world)
        return self._limits[1] if self._limits else engine.limit(self._world)

    @property
    def substepped(self) -> int:
        """The number of steps that failed and were repeated in parts."""
        return self._substepped if self._adaptive is None else self._world.adaptation()[1]

    @property
    def dt(self) -> float:
        """The time step [s] of the last step, or of that of which a part was taken; before the first step, that of the
        next one.
        """
        if self._cut is not None and self._cut.steps == self._world.steps:
            return self._cut.dt
        return self.fixed or self._world.dt or self._largest(FRAMES_PER_SECOND)

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The steps that were taken since the scene's start."""
        if self._adaptive is None:
            return tuple(self._segments)
        _, _, smallest, largest = self._world.adaptation()
        return (Segment(0.0, self._world.steps, (smallest, largest)),) if self._world.steps else ()

    def step(self, steps: int, watch: Watch | None = None) -> None:
        """Advance by a number of steps; with a watch, at most to a terminal event."""
        left = count(steps, "step.n")
        if self._adaptive is not None:
            raise SceneError(
                "dt: adaptive steps are not equal, and end where an interval ends: use run(duration), record or "
                f"frames; or give dt a number{'' if self._numerics.integrator.self_adaptive else ', or AutoStep()'}"
            )
        with self._alone():
            if self.fixed is not None:
                return self._advance_by(left, self.fixed, watch)
            while left > 0 and not stopped(watch):
                self._check_limit()
                batch = min(left, self._until_check())
                left -= self._advance(batch, self._largest(FRAMES_PER_SECOND), watch)
        return None

    def run(self, duration: float, fps: float = FRAMES_PER_SECOND, watch: Watch | None = None) -> None:
        """Advance by a duration [s]: to its end with dt="auto", to the first step at or after it with a given dt. With
        a watch, advance at most to the end of the step that has a terminal event.
        """
        interval = number(duration, "run.duration", least=0.0)
        self.warn_if_long(interval)
        with self._alone():
            if self.fixed is not None:
                return self._advance_by(max(0, steps_to(interval, self.fixed, TIME_TOLERANCE)), self.fixed, watch)
            if interval == 0.0:
                return None
            if self._adaptive is not None:
                return self._adapt(interval, fps, self._adaptive, watch)
            steps, dt = divide(interval, self._largest(fps))
            while steps > 0 and not stopped(watch):
                if self._check_limit():
                    steps, dt = divide(steps * dt, self._largest(fps))
                batch = min(steps, self._until_check())
                steps -= self._advance(batch, dt, watch)
        return None

    def settle(self, watch: Watch | None) -> None:
        """End a watch, and go to the state at its terminal event from the end of the last step."""
        last, self._last = self._last, None
        if watch is None:
            return
        watch.end()
        if watch.stop is None or watch.stop.stretch is None or last is None:
            return
        stretch, dt = watch.stop.stretch, self.dt
        self._return_to(last)
        self._world.restore(stretch.world)
        self._note(Segment(last.time, stretch.parts, stretch.size))
        self._cut = Cut(self._world.steps, dt)

    def notes(self, limit: Limit) -> list[str]:
        """Notes of the plan about adaptive steps, limits that vary, and oscillations that steps do not resolve."""
        if self._adaptive is None:
            return self._momentary(limit) + self._unresolved(limit)
        by = (
            f"keep their last coefficient within {self._adaptive.tolerance:g} of the largest acceleration"
            if self._numerics.integrator.self_adaptive and self._adaptive.tolerance is not None
            else f"keep their error within {self._adaptive.tolerance:g} m"
            if self._adaptive.tolerance is not None
            else f"keep to {self._adaptive.safety:.0%} of the limit at both of their ends, in blocks of halves"
        )
        rejected, _, smallest, largest = self._world.adaptation()
        taken = (
            f"{self._world.steps} taken, from {smallest:.3g} s to {largest:.3g} s, {rejected} tried and taken back"
            if self._world.steps
            else "none taken so far"
        )
        return [f"adaptive steps {by}: {taken}"]

    def _momentary(self, limit: Limit) -> list[str]:
        """A note on a given step near a limit that varies with the motion."""
        flows = any(isinstance(body, Fluid) for body in self._scene.bodies)
        if isinstance(self._numerics.dt, StepRule) or not self._varies or not (limit.kind == "accuracy" or flows):
            return []
        if not NEAR * limit.dt < self.dt <= limit.dt:
            return []
        return [
            f"the {limit.kind} limit of {limit.dt:.3g} s ({limit.term}) is that of the present state, and falls where "
            'the motion becomes faster; dt="auto" follows it'
        ]

    def _unresolved(self, limit: Limit) -> list[str]:
        """A note on the fastest oscillation of bodies, if it is off by more than 1 % after ten periods."""
        integrator = self._numerics.integrator
        if not self._scene.bodies:
            return []
        if math.isinf(limit.dt) and any(Record.of(force).is_code for force in self._scene.forces):
            return [
                f"nothing limits the time step of {self.dt:.3g} s: make sure that it resolves the functions of time"
            ]
        if limit.kind != "stability" or limit.stability == 0.0 or integrator.resolving == 1.0 or limit.term in DAMPINGS:
            return []
        ratio = self.dt / (integrator.resolving * limit.stability)
        slower = ratio * float(power(RESOLVED / NOTED, 1.0 / integrator.order))
        if slower <= 1.0:
            return []
        return [
            f"the fastest oscillations ({limit.term}) are not resolved; motion that is at least {slower:.2g} times "
            "slower is within 1 % of its amplitude after ten periods; dt=pc.AutoStep(resolve=True) resolves all, in "
            f"{ratio:.2g} times as many steps"
        ]

    def _adapt(self, interval: float, fps: float, rule: AdaptiveStep, watch: Watch | None) -> None:
        """Advance by an interval [s] in steps that follow the motion."""
        before, most = self.substepped, MOST if watch is None else 1
        course: tuple[float, float, int] | None = (self._world.time, interval, 0)
        while course is not None and not stopped(watch):
            with self._watched(watch):
                try:
                    course, flow = self._world.run(course, most, rule.safety, free_step(fps), rule.tolerance)
                except SimulationDiverged as error:
                    self._complete(error)
                    raise
            if before == 0 < self.substepped:
                before = self.substepped
                cause = "safety" if rule.tolerance is None else "tolerance"
                warn(
                    f"a step that follows the motion diverged and was halved: take a smaller {cause}", StabilityWarning
                )
            self._warn_of_mach_number(*flow or (0.0, 0.0, 0.0))

    def _advance_by(self, steps: int, dt: float, watch: Watch | None) -> None:
        """Advance by `steps` steps."""
        while steps > 0 and not stopped(watch):
            steps -= self._advance(steps, dt, watch)

    @contextmanager
    def _watched(self, watch: Watch | None) -> Iterator[None]:
        """Look for events in the one step that is taken inside. If this fails, return to the start of the step."""
        if watch is None:
            yield
            return
        watch.prepare()
        world, segments = self._world, self._segments
        start = Before(world.capture(), world.time, self._substepped, len(segments), segments[-1:])
        steps = world.steps
        try:
            yield
            if world.steps != steps:
                watch.look(start.world)
                self._last = start
        except SimulationDiverged:
            raise  # The world is at the last good state, perhaps after parts of the step.
        except BaseException:
            self._return_to(start)
            raise

    def _return_to(self, start: Before) -> None:
        """Return to the start of the last step."""
        self._world.restore(start.world)
        self._substepped = start.substepped
        self._segments[max(0, start.segments - 1) :] = start.segment

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Lock against other threads, which could otherwise advance the world between two batches of steps."""
        if not self._stepping.acquire(blocking=False):
            raise PhyscoreError(
                "this simulation is running, in another thread or around this call: wait until that has ended"
            )
        try:
            yield
        finally:
            self._stepping.release()

    def _advance(self, steps: int, dt: float, watch: Watch | None) -> int:
        """Advance by up to `steps` steps, by one with a watch, and return their number."""
        with self._watched(watch):
            return self._take(steps if watch is None else 1, dt)

    def _take(self, steps: int, dt: float) -> int:
        """Take up to `steps` steps, and return their number. The first step that must be repeated in parts is the last
        one.
        """
        start, before = self._world.time, self._world.steps
        try:
            flow = self._world.step(steps, dt)
        except SimulationDiverged as error:
            taken = self._world.steps - before
            self._note(Segment(start, taken, dt))
            if self._numerics.on_divergence != "substep":
                self._complete(error)
                raise
            self._substep(error, dt)
            return taken + 1
        except BaseException:
            self._note(Segment(start, self._world.steps - before, dt))
            raise
        self._note(Segment(start, steps, dt))
        self._warn_of_mach_number(*flow or (0.0, 0.0, 0.0))
        return steps

    def _note(self, new: Segment) -> None:
        """Add steps to the history. As with the engine's clock, a segment ends only if the step size changes."""
        if new.steps == 0:
            return
        last = self._segments[-1] if self._segments else None
        if last is not None and last.dt == new.dt:
            self._segments[-1] = replace(last, steps=last.steps + new.steps)
        else:
            self._segments.append(new)

    def _substep(self, error: SimulationDiverged, dt: float) -> None:
        """Repeat a failed step in parts.

        Raises:
            SimulationDiverged: the smallest parts fail too.
        """
        message = (
            f"a step failed ({error.cause}) and is taken again in parts; take a smaller dt where this happens often"
        )
        if self._substepped == 0:
            self._warn(f"at {error.time:.4g} s {message}", StabilityWarning)
        self._substepped += 1
        start = self._world.time
        parts, failed = self._world.substep(dt)
        for steps, size in parts:
            self._note(Segment(start, steps, size))
            start += steps * size
        if isinstance(failed, SimulationDiverged):
            self._complete(failed)
        if failed is not None:
            raise failed

    def _complete(self, error: SimulationDiverged) -> None:
        """Add the last good state to an error, and the name of the particle's body if it has one."""
        if error.element.startswith("particle "):
            start = 0
            for body in self._scene.bodies:
                if start <= error.particle < start + len(body) and body.name is not None:
                    mine = f"{error.element} ({error.particle - start} of {body.name!r})"
                    error.args = (str(error).replace(f"{error.element} ", f"{mine} ", 1),)
                start += len(body)
        error.last_good = engine.shown(engine.snapshot(self._world, self._scene), self._scene)

    def steps_ahead(self, duration: float) -> float | None:
        """The number of steps in a duration [s] from now; None if it is unknown.

        Steps that follow the motion are counted in a rehearsal, in intervals of increasing length. Its mean is used if
        the last two intervals have about the same number of steps per second.
        """
        if self._adaptive is None:
            return duration / self.dt
        rule, least = self._adaptive, self.dt
        world = engine.build(self._scene, self._numerics)
        world.restore(self._world.capture())
        most = max(FEWEST, min(REHEARSED, REHEARSED_WORK // max(1, self._scene.particles)))
        taken, passed, interval, rates = 0, 0.0, 0.5 * least, [0.0, 0.0]
        try:
            while passed < duration and taken < most:
                interval, before = min(2.0 * interval, duration - passed), world.steps
                course = (world.time, interval, 0)
                world.run(course, MOST, rule.safety, free_step(FRAMES_PER_SECOND), rule.tolerance)
                taken, passed = taken + world.steps - before, passed + interval
                rates = [rates[1], (world.steps - before) / interval]
        except SimulationDiverged:
            return None
        steady = passed >= duration or max(rates) <= STEADY * min(rates)
        return taken * duration / passed if steady else None

    def warn_if_long(self, duration: float) -> None:
        """Warn once if a duration [s] takes more steps than are probably intended."""
        given = self.fixed is not None
        if self._long_warned or duration <= MOST_STEPS * self.dt or _UNWARNED.get():
            return
        steps = self.steps_ahead(duration)
        if steps is None:
            return
        message = long_run(duration, duration / steps, "" if given else self.limit.term, given)
        if message is not None:
            self._long_warned = True
            self._warn(message, SceneWarning)

    def warn_of_drift(self, drift: float) -> None:
        """Warn of a large drift of the energy balance over a whole run; with a given time step, of a very large one.

        Methods for stiff motion lose energy by choice. The energy in motion of the first steps from rest is no scale.
        """
        allowed = WRONG_DRIFT if self.fixed is None else BROKEN_DRIFT if self._world.steps > FIRST else math.inf
        # NaN, beyond the range of numbers, has a warning of its own.
        if not drift > allowed or self._numerics.integrator.stiff or _UNWARNED.get():
            return
        warn(
            f"the energy balance drifted by {drift:.2g} of the energy in motion: the motion is not resolved; "
            f"{self._finer(drift)}, and see pc.diagnose(recording)",
            StabilityWarning,
        )

    def _finer(self, drift: float) -> str:
        """Advice for a fair drift, from drift ∝ dt^order."""
        rule, order, limit = self._numerics.dt, max(1, self._numerics.integrator.order), self.limit
        if is_encounter(limit.term, limit.kind) and not isinstance(rule, AdaptiveStep):
            return ENCOUNTER_CURE
        factor = float(power(FAIR_DRIFT / min(drift, 1.0), 1.0 / order))
        if not isinstance(rule, StepRule) or math.isinf(limit.dt):
            return f"take dt={factor * self.dt:.1g}"
        if isinstance(rule, AdaptiveStep) and rule.tolerance is not None:
            return f"take dt=pc.AdaptiveStep(tolerance={0.01 * rule.tolerance:.1g})"
        # Steps may be shorter than the rule asks for, where frames are near each other.
        safety = rule.safety if isinstance(rule, AdaptiveStep) else min(rule.safety, self.dt / limit.dt)
        method = type(self._numerics.integrator).__name__
        return f'take integrator="{method}" and dt=pc.{type(rule).__name__}(safety={factor * safety:.1g})'

    def _warn_of_mach_number(self, mach: float, share: float, sound: float) -> None:
        if self._mach_warned or share <= FAST_SHARE:
            return
        self._mach_warned = True
        message = (
            f"{share:.1%} of a fluid's particles are faster than Mach {mach} where sound has {sound:.3g} m/s: there "
            f"density is off by about Mach squared, {mach * mach:.1%} and more, and one percent is meant; raise "
            "sound_speed in fluids=pc.WeaklyCompressible(…)"
        )
        self._warn(message, MachWarning)

    def _largest(self, fps: float) -> float:
        rule = self._numerics.dt
        assert isinstance(rule, StepRule)
        return largest_step(self.limit, rule, self._numerics.integrator, fps)

    def _until_check(self) -> int:
        return self._interval - self._world.steps % self._interval if self._varies else sys.maxsize

    def _check_limit(self) -> bool:
        """Check the limit if due, and return whether the time step has to change."""
        if not self._varies or self._world.steps == 0 or self._world.steps % self._interval != 0:
            return False
        assert self._limits
        first, kept = self._limits
        fallen = kept.kept / RECOVERED if self._numerics.resolves else self.dt
        # NaN, and so no change, where a function of the user's is not finite nearby: the step itself will say so.
        certified = engine.certified(self._world)
        if kept != first and certified >= first.kept:
            kept = first
        elif certified < fallen or (kept != first and certified >= RECOVERED * kept.kept):
            present = engine.limit(self._world)
            # Without an initial limit, as for grains that do not touch yet, there is no lower bound of the time step.
            least = first.dt / SLOWEST if math.isfinite(first.dt) and present.term == "springs" else 0.0
            kept = replace(present, dt=max(present.dt, least), certified=max(present.certified, least))
        else:
            return False
        self._limits = first, kept
        return True

    def _warn_if_unstable(self, dt: float) -> None:
        if _UNWARNED.get():
            return
        # The certified limit is smaller and much faster to compute.
        if dt <= engine.certified(self._world):
            return
        limit = engine.limit(self._world)
        if dt <= limit.stability:
            if limit.kind == "accuracy" and dt > COARSE * limit.accuracy and not self._numerics.integrator.stiff:
                self._warn(
                    f"dt = {dt:g} s is {dt / limit.accuracy:.2g} times the limit of accuracy in this scene, "
                    f"{limit.accuracy:g} s ({limit.term}): the motion is not resolved",
                    StabilityWarning,
                )
            return
        name = type(self._numerics.integrator).__name__
        if limit.endured == 0.0:
            message = (
                f"{name} is not stable at any time step in this scene ({limit.term}): its energy grows without end"
            )
        elif dt > limit.endured:
            message = (
                f"dt = {dt:g} s is above the limit of stability of {name} in this scene, {limit.stability:g} s "
                f"({limit.term}): the simulation will blow up"
            )
        else:
            message = (
                f"dt = {dt:g} s is above the limit of stability that is certain for {name} in this scene, "
                f"{limit.stability:g} s ({limit.term}): the simulation may blow up; the true limit may be "
                f"{_how_much_larger(limit)}, `stability_limit(scene, {name}(), measured=True)` finds it"
            )
        self._warn(message, StabilityWarning)

    def _warn(self, message: str, category: type[Warning]) -> None:
        """Warn in the scene's units."""
        warn(self._scene.units.reworded(message), category)

    def capture(self) -> Captured:
        """The state of the stepper, in addition to that of the world: limits, segments and counts."""
        segments = [asdict(segment) for segment in self._segments]
        limits = [vars(limit) for limit in self._limits or ()]
        return {"substepped": self._substepped, "limits": limits, "segments": segments}

    def restore(self, state: Captured) -> None:
        """Restore the state from `capture`."""
        self._substepped = state["substepped"]
        self._segments = list(segments_from(state["segments"]))
        if state["limits"]:
            first, kept = (Limit(**limit) for limit in state["limits"])
            self._limits = first, kept


def _check_interval(scene: Scene, numerics: Numerics) -> int:
    """The number of steps between two checks of the limit."""
    if numerics.resolves:
        return RESOLVED_CHECK_INTERVAL
    cells = [math.prod(system.grid.cells) for system in scene.systems if isinstance(system, ReactionDiffusion)]
    if cells and max(cells) <= FEW_CELLS:
        return 1
    return SHORT_CHECK_INTERVAL if cells or scene.fluids else CHECK_INTERVAL


def _how_much_larger(limit: Limit) -> str:
    """The ratio of the possible limit of stability to the certain one, as text."""
    if limit.stability == 0.0 or math.isinf(limit.endured):
        return "larger"
    return f"up to {limit.endured / limit.stability:.3g} times as large"
