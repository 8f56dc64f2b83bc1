"""Stepper of a simulation: controls the number and the size of its steps."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import Any, NamedTuple, TypedDict

from physcore._core import World
from physcore.checks import MOST, count, number
from physcore.errors import PhyscoreError, SceneError, SimulationDiverged
from physcore.numerics.choices import FRAMES_PER_SECOND, AdaptiveStep, Limit, Numerics, divide, free_step, steps_to
from physcore.scene.scene import Scene
from physcore.simulation import engine
from physcore.simulation.earlier import Earlier
from physcore.simulation.provenance import Segment, segments_from
from physcore.simulation.rehearsal import steps_ahead
from physcore.simulation.step_notes import notes_on
from physcore.simulation.step_size import StepSize
from physcore.simulation.step_warnings import StepWarnings
from physcore.simulation.watch import Watch, stopped
from physcore.storage.archive import Tree

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
    earlier: dict[str, Any]


class Stepper:
    """Stepper of a world: takes steps of a given size, or of one chosen from the limit of stability."""

    def __init__(self, world: World, scene: Scene, numerics: Numerics) -> None:
        self._world = world
        self._scene = scene
        self._numerics = numerics
        self._adaptive = numerics.adaptive
        self._size = StepSize(world, scene, numerics)
        self._warnings = StepWarnings(self._size)
        self._stepping = threading.Lock()
        self._substepped = 0
        self._segments: list[Segment] = []
        self._last: Before | None = None
        """The state before the last step that was watched."""
        self._cut: Cut | None = None
        """The last step that ended at an event."""
        self._begun = world.steps
        """The number of steps at the start of the scene."""
        self._replaced = False
        self.earlier = Earlier()
        """Parts of the budgets from the scenes before this one."""

    def begin(self) -> None:
        """Find the limits before the first step. A stepper from a checkpoint uses `restore` instead.

        Raises:
            SceneError: no time step is certain to be stable.
        """
        self._size.begin()
        if self.fixed is not None:
            self._warnings.of_instability(self.fixed)

    def succeed(self, before: Stepper, earlier: Earlier) -> None:
        """Go on from the stepper of the scene before."""
        self._substepped, self._segments, self.earlier = before._substepped, list(before._segments), earlier
        before._replaced = True

    def require_present(self) -> None:
        """Refuse to go on with a scene that was replaced.

        Raises:
            PhyscoreError: it was.
        """
        if self._replaced:
            raise PhyscoreError(
                "the scene of this simulation was replaced between two of its frames: ask for frames, or record, anew"
            )

    @property
    def fixed(self) -> float | None:
        """The given time step [s], or None."""
        return self._size.fixed

    @property
    def limit(self) -> Limit:
        """The limit of the time step; of the present state if the step follows the motion or was given."""
        return self._size.limit

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
        taken = self._world.dt if self._world.steps > self._begun else 0.0
        return self.fixed or taken or self._size.largest(FRAMES_PER_SECOND)

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
        with self.alone():
            if self.fixed is not None:
                return self._advance_by(left, self.fixed, watch)
            while left > 0 and not stopped(watch):
                self._size.check(self.dt)
                batch = min(left, self._size.until_check())
                left -= self._advance(batch, self._size.largest(FRAMES_PER_SECOND), watch)
        return None

    def run(self, duration: float, fps: float = FRAMES_PER_SECOND, watch: Watch | None = None) -> None:
        """Advance by a duration [s]: to its end with dt="auto", to the first step at or after it with a given dt. With
        a watch, advance at most to the end of the step that has a terminal event.
        """
        interval = number(duration, "run.duration", least=0.0)
        self.warn_if_long(interval)
        with self.alone():
            if self.fixed is not None:
                return self._advance_by(max(0, steps_to(interval, self.fixed, TIME_TOLERANCE)), self.fixed, watch)
            if interval == 0.0:
                return None
            if self._adaptive is not None:
                return self._adapt(interval, fps, self._adaptive, watch)
            steps, dt = divide(interval, self._size.largest(fps))
            while steps > 0 and not stopped(watch):
                if self._size.check(self.dt):
                    steps, dt = divide(steps * dt, self._size.largest(fps))
                batch = min(steps, self._size.until_check())
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
        """Notes of the plan about steps, whose present limit is known."""
        return [*notes_on(self._size, self.dt, limit), *self.earlier.notes(self._scene.units)]

    def _adapt(self, interval: float, fps: float, rule: AdaptiveStep, watch: Watch | None) -> None:
        """Advance by an interval [s] in steps that follow the motion."""
        before, most = self.substepped, MOST if watch is None else 1
        course: tuple[float, float, int, float | None] | None = (self._world.time, interval, 0, None)
        while course is not None and not stopped(watch):
            with self._watched(watch):
                try:
                    course, flow = self._world.run(course, most, rule.safety, free_step(fps), rule.tolerance)
                except SimulationDiverged as error:
                    self._complete(error)
                    raise
            if before == 0 < self.substepped:
                before = self.substepped
                self._warnings.of_halves(rule)
            self._warnings.of_mach_number(*flow or (0.0, 0.0, 0.0))

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
    def alone(self) -> Iterator[None]:
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
        self._warnings.of_mach_number(*flow or (0.0, 0.0, 0.0))
        return steps

    def _note(self, new: Segment) -> None:
        """Add steps to the history. As with the engine's clock, a segment ends only if the step size changes."""
        if new.steps == 0:
            return
        last = self._segments[-1] if self._segments else None
        if last is not None and last.dt == new.dt:
            self._segments[-1] = Segment(last.start, last.steps + new.steps, last.dt)
        else:
            self._segments.append(new)

    def _substep(self, error: SimulationDiverged, dt: float) -> None:
        """Repeat a failed step in parts.

        Raises:
            SimulationDiverged: the smallest parts fail too.
        """
        if self._substepped == 0:
            self._warnings.of_parts(error)
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
        """The number of steps in a duration [s] from now; None if it is unknown."""
        return steps_ahead(self._size, self.dt, duration)

    def warn_if_long(self, duration: float) -> None:
        """Warn once if a duration [s] takes more steps than are probably intended."""
        self._warnings.of_length(duration, self.dt)

    def warn_of_drift(self, drift: float) -> None:
        """Warn of a large relative drift of the energy balance over a whole run."""
        self._warnings.of_drift(drift, self.dt)

    def capture(self) -> Captured:
        """The state of the stepper, in addition to that of the world: limits, segments and counts."""
        segments = [asdict(segment) for segment in self._segments]
        limits = [vars(limit) for limit in self._size.limits]
        earlier = self.earlier.content()
        return {"substepped": self._substepped, "limits": limits, "segments": segments, "earlier": earlier}

    def restore(self, state: Captured) -> None:
        """Restore the state from `capture`."""
        self._substepped = state["substepped"]
        self._segments = list(segments_from(state["segments"]))
        self.earlier = Earlier.from_content(state["earlier"])
        self._size.restore([Limit(**limit) for limit in state["limits"]])
