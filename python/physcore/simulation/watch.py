"""Watch of a run: it looks for events in each step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from physcore import memory
from physcore._core import World
from physcore.checks import BoolArray, FloatArray, frozen
from physcore.errors import SceneError, SimulationDiverged
from physcore.numerics.choices import Numerics
from physcore.scene.scene import Scene
from physcore.simulation import engine
from physcore.simulation.event import Event, decided, period_in, values_of
from physcore.simulation.occurrences import Events, Occurrences
from physcore.simulation.roots import crossed
from physcore.simulation.state import Snapshot
from physcore.simulation.within import Fork, Step, Stretch
from physcore.storage.archive import Tree

RESOLUTION = 4.0 * float(np.finfo(float).eps)
"""Tolerance of the time of an event, as a fraction of the time."""

MANY = 2**20
"""Number of bytes from which on the free memory is checked."""


class Stop(NamedTuple):
    """End of a run at an event within its last step."""

    time: float
    """Time of the event [s]."""
    stretch: Stretch | None
    """The way there from the start of the step; None if the run ends at the end of the step."""


class _Root(NamedTuple):
    """Root of an event within a step."""

    time: float
    event: int
    place: int
    """Index in the values of the event."""
    fields: dict[str, FloatArray]
    part: float | None
    """Time since the start of the step [s] by a part of it; None at its end, and for an interpolated state."""


class Watch:
    """Watch of a world for events. `prepare` evaluates them before each step, `look` afterwards.

    A root is bracketed by the ends of a step. It is refined by steps of other lengths from the start of this step, in a
    second world: the run itself is not touched. Where short steps differ from long ones in kind, it is refined by the
    interpolation that frames use. The time of a root is the later end of the last bracket. There, values have their
    later sign, so that a run from this state on does not find the root again.
    """

    def __init__(
        self, events: Sequence[Event], world: World, scene: Scene, numerics: Numerics, channels: tuple[str, ...]
    ) -> None:
        self._events = tuple(events)
        self._paths = tuple(f"events[{index}]" for index in range(len(events)))
        self._periods = tuple(
            period_in(event, scene, path) for event, path in zip(self._events, self._paths, strict=True)
        )
        self._world = world
        self._scene = scene
        self._fork = Fork(scene, numerics)
        methods = (numerics.integrator, *numerics.integrators.values())
        self._interpolates = bool(scene.constraints) or not all(method.continuous for method in methods)
        fields = engine.fields(world, scene)
        self._rates = {info.name: info.rate for info in fields}
        self._shapes = {info.name: info.shape for info in fields}
        self._channels = tuple(name for name in channels if name in self._rates)
        self._found: tuple[list[_Root], ...] = tuple([] for _ in events)
        self._bytes, self._checked = 0, MANY
        self._present: Snapshot | None = None
        self._values: tuple[FloatArray, ...] = ()
        self.stop: Stop | None = None
        """The end of the run, once a terminal event has occurred."""

    @property
    def events(self) -> Events:
        """The occurrences so far."""
        every: list[Occurrences] = []
        for event, roots in zip(self._events, map(list, self._found), strict=True):
            channels = {
                name: np.array([root.fields[name] for root in roots]).reshape(len(roots), *self._shapes[name])
                for name in self._channels
            }
            times, indices = np.array([root.time for root in roots]), np.array([root.place for root in roots], np.int64)
            every.append(Occurrences(times, channels, indices, self._scene, str(event.name)))
        return Events(tuple(every), self._events)

    def prepare(self) -> None:
        """Evaluate the events in the present state, if the last step did not end there.

        Raises:
            SceneError: a function raised an exception, or returned what is no finite number.
        """
        if self._present is None:
            state = engine.snapshot(self._world, self._scene)
            self._values = self._evaluated(state, None)
            self._present = state

    def restart(self) -> None:
        """Take the present state as a new start: what was set between two steps is no event."""
        self._present = None

    def end(self) -> None:
        """Free what only steps need."""
        self._fork.free()

    def look(self, start: Tree) -> None:
        """Look for events in the last step, from a captured world at its start.

        Raises:
            SceneError: as in `prepare`; or the states at the events do not fit into memory.
        """
        assert self._present is not None
        step = Step(start, self._present, engine.snapshot(self._world, self._scene))
        values = self._evaluated(step.after, self._values)
        roots = [
            self._root(step, event, int(index), float(values[event].flat[index]))
            for event in range(len(self._events))
            for index in np.flatnonzero(self._changed(event, values[event]))
        ]
        roots.sort(key=lambda root: root.time)
        last = self._last(roots)
        stop = None if last is None else self._stop(step, last)
        self._keep([root for root in roots if last is None or root.time <= last.time])
        self._present, self._values, self.stop = step.after, values, stop

    def _evaluated(self, state: Snapshot, before: Sequence[FloatArray] | None) -> tuple[FloatArray, ...]:
        """The values of all events in a state; those before where a sign is unknown."""
        shown = self._shown(state)
        values = [self._valued(event, shown) for event in range(len(self._events))]
        last: Sequence[FloatArray | None] = before or [None] * len(values)
        return tuple(decided(*each) for each in zip(self._events, values, [shown] * len(values), last, strict=True))

    def _shown(self, state: Snapshot) -> Snapshot:
        """A state as the user sees it, in arrays that no function can change."""
        shown = engine.shown(state, self._scene)
        for array in shown.fields.values():
            frozen(array)
        return shown

    def _valued(self, event: int, shown: Snapshot) -> FloatArray:
        """The values of an event in a state as the user sees it; of periodic values those nearest to 0."""
        values = values_of(self._events[event], shown, self._paths[event])
        if self._values and values.shape != self._values[event].shape:
            raise SceneError(
                f"{self._paths[event]}.function: must always return one shape, "
                f"returned {self._values[event].shape} and then {values.shape}"
            )
        period = self._periods[event]
        return values if period is None else np.asarray(values - period * np.rint(values / period))

    def _changed(self, event: int, after: FloatArray) -> BoolArray:
        """Which values of an event became 0 or changed sign in a step, in its direction."""
        before, direction, period = self._values[event], self._events[event].direction, self._periods[event]
        changed: BoolArray = (before != 0.0) & (np.sign(after) != np.sign(before))
        if direction != 0:
            changed &= before * direction < 0.0
        if period is not None:
            changed &= np.abs(after - before) < 0.5 * period
        return changed

    def _root(self, step: Step, event: int, index: int, after: float) -> _Root:
        """The root of a value within a step at whose ends it has opposite signs, or at whose end it is 0."""
        if after == 0.0:
            return _Root(step.after.time, event, index, self._fields(step.after), None)
        try:
            return self._refined(step, event, index, after, interpolates=self._interpolates)
        except SimulationDiverged:
            return self._refined(step, event, index, after, interpolates=True)

    def _refined(self, step: Step, event: int, index: int, after: float, *, interpolates: bool) -> _Root:
        """The root, by parts of the step or by interpolation.

        Raises:
            SimulationDiverged: a part diverges.
        """

        def state(part: float) -> Snapshot:
            if part >= step.length:
                return step.after
            return step.interpolated(part, self._rates) if interpolates else self._fork.state(step, part)

        def value(part: float) -> float:
            return float(self._valued(event, self._shown(state(part))).flat[index])

        before = float(self._values[event].flat[index])
        part = crossed(value, (0.0, step.length), (before, after), RESOLUTION * step.after.time)
        at = state(part)
        return _Root(at.time, event, index, self._fields(at), None if interpolates or at is step.after else part)

    def _last(self, roots: Sequence[_Root]) -> _Root | None:
        """The root that ends the run; None if none of them does."""
        counts = [len(roots) for roots in self._found]
        for root in roots:
            counts[root.event] += 1
            terminal = self._events[root.event].terminal
            if terminal is not False and counts[root.event] >= int(terminal):
                return root
        return None

    def _stop(self, step: Step, last: _Root) -> Stop:
        """The end of a run at a root."""
        return Stop(last.time, None if last.part is None else self._fork.stretch(step, last.part))

    def _fields(self, state: Snapshot) -> dict[str, FloatArray]:
        """The fields to keep, as the user sees them."""
        fields = engine.shown(state, self._scene).fields
        return {name: fields[name] for name in self._channels}

    def _keep(self, roots: Sequence[_Root]) -> None:
        """Keep the roots of a step."""
        self._bytes += sum(values.nbytes for root in roots for values in root.fields.values())
        if self._bytes > self._checked:
            memory.require(2.0 * self._bytes, "the states at the events", "events", "record fewer channels")
            self._checked = 2 * self._bytes
        for root in roots:
            self._found[root.event].append(root)


def stopped(watch: Watch | None) -> bool:
    """Whether a terminal event has ended the run."""
    return watch is not None and watch.stop is not None
