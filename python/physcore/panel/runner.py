"""Physics of a panel in a thread of its own: advances a session at the pace of the clock on the wall."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

from physcore.panel.report import Report, energy_row, plan_of
from physcore.panel.session import Session
from physcore.panel.worker import Worker
from physcore.scene.scene import Scene
from physcore.simulation.passage import Passage
from physcore.simulation.state import Snapshot
from physcore.simulation.step_warnings import unwarned

T = TypeVar("T")

PATIENCE = 0.1
"""Longest delay that physics catches up with [s]; what is behind by more is given up, and the panel tells."""
AUDITS = 15.0
"""Energies per second."""
REPORTS = 15.0
"""Reports per second."""
PLANS = 0.05
"""Largest fraction of the time for the limits of the time step."""
WINDOW = 1.0
"""Time over which the pace is measured [s]."""


@dataclass(frozen=True, eq=False)
class Moment:
    """State that physics has reached, and when, for the thread that draws."""

    passage: Passage
    scene: Scene
    """Scene of the controls."""
    start: float
    """Simulated time of the moment before [s]."""
    clock: float
    """When physics was here [s]."""
    interval: float
    """Time since the moment before [s]."""
    hand: tuple[int, tuple[float, ...]] | None
    """Row of the held element among those of all bodies, and the pointer [m]."""

    def share(self, now: float) -> float:
        """Fraction of the way from the moment before to this one that is due at a time of the clock."""
        return min(max((now - self.clock) / self.interval, 0.0), 1.0) if self.interval > 0.0 else 1.0

    def state(self, share: float) -> Snapshot:
        """The state at a fraction of the way."""
        end = self.passage.after.time
        return self.passage.at(self.start + share * (end - self.start), self.scene)


class Runner:
    """Physics of a panel.

    Args:
        session: the session, which this thread owns.
        fps: pictures per second.
        audited: whether each moment needs its energy, because pictures show it.
        tell: is called with each report, in this thread.
        daemon: whether the interpreter may end while it runs.
    """

    def __init__(
        self, session: Session, fps: float, *, audited: bool, tell: Callable[[Report], None], daemon: bool
    ) -> None:
        self._session, self._fps, self._audited, self._tell = session, fps, audited, tell
        self._worker = Worker(self._idle, daemon=daemon)
        self._playing, self._error = False, ""
        self._origin = (0.0, 0.0)
        """A time of the clock [s], and the simulated time that is due then [s]."""
        self._cost = math.nan
        """Processing time per simulated time [s/s]; NaN before the first steps."""
        self._paces: deque[tuple[float, float]] = deque()
        self._plan: dict[str, Any] = {}
        self._plan_due = self._audit_due = self._report_due = 0.0
        self._urged: dict[str, Callable[[Session], object]] = {}
        self._lock = threading.Lock()
        self._urged_due = 0.0
        self._rows: list[list[float]] = []
        self._epoch = 0
        self.moment = self._present()
        """The latest moment. Any thread may read it."""

    def start(self) -> None:
        """Start the thread, paused."""
        self._worker.start()

    def stop(self) -> None:
        """End the thread."""
        self._worker.stop()

    def ask(self, job: Callable[[Session], T]) -> T:
        """Have something done with the session between two batches of steps, and return its result.

        Raises:
            PhyscoreError: the panel is closed.
        """
        self._order_urged()
        return self._worker.ask(lambda: self._changed(job))

    def read(self, job: Callable[[Session], T]) -> T:
        """Have something read from the session, which it leaves as it is."""
        return self._worker.ask(lambda: job(self._session))

    def post(self, job: Callable[[Session], object]) -> None:
        """Have something done with the session, without waiting; an error goes to the page."""
        self._order_urged()
        self._worker.post(lambda: self._attempt(job))

    def urge(self, kind: str, job: Callable[[Session], object]) -> None:
        """Have something done soon, in place of a request of this kind that still waits; an error goes to the page.

        Such requests come as fast as a mouse moves. Physics spends at most half of its time on them. Other requests are
        done after those that were urged before: what is held is moved to where the mouse was when it let go.
        """
        with self._lock:
            self._urged[kind] = job
        self._worker.post(lambda: None)  # which wakes the thread

    def play(self, *, on: bool) -> None:
        """Begin or pause to play; only for jobs of this thread."""
        self._playing = on
        if on:
            self._rebase(time.perf_counter())

    def step(self, number: object) -> None:
        """Pause, and take steps; only for jobs of this thread."""
        self.play(on=False)
        self._session.step(number)

    def reset(self) -> None:
        """Pause at time 0; only for jobs of this thread."""
        self._session.reset()
        self.play(on=False)

    def set_speed(self, speed: float) -> None:
        """Set the speed [s/s]; only for jobs of this thread."""
        self._session.speed = speed
        self._rebase(time.perf_counter())

    def _order_urged(self) -> None:
        """Have what is urged done before any later request."""
        for job in self._taken_urged():
            self._worker.post(partial(self._attempt, job))

    def _taken_urged(self) -> list[Callable[[Session], object]]:
        """Requests that are urged, which then are not urged any more."""
        with self._lock:
            urged, self._urged = self._urged, {}
        return list(urged.values())

    def _attempt(self, job: Callable[[Session], object]) -> None:
        """Do a job that may change the session; an error goes to the page."""
        try:
            self._changed(job)
        except Exception as error:
            self._error = str(error)
            self._report(time.perf_counter())

    def _do_urged(self, now: float) -> float | None:
        """Do what is urged, if it is due; return the time until then [s], or None if there is nothing."""
        if not self._urged:
            return None
        if now < self._urged_due:
            return self._urged_due - now
        for job in self._taken_urged():
            self._attempt(job)
        end = time.perf_counter()
        self._urged_due = end + (end - now)
        return None

    def _changed(self, job: Callable[[Session], T]) -> T:
        """Do a job that may change the session, and publish what became of it."""
        session, before = self._session, self._session.simulation
        with unwarned():
            result = job(session)
            session.course.begin()
            if session.simulation is not before:
                self._begin_anew()
            self._error = ""
            self.moment, self._plan_due = self._present(), 0.0
            self._report(time.perf_counter())
        return result

    def _begin_anew(self) -> None:
        """Forget what belongs to another simulation."""
        self._rows.clear()
        self._epoch += 1
        self._cost = math.nan
        self._rebase(time.perf_counter())

    def _rebase(self, now: float) -> None:
        """Let the present simulated time be due now."""
        self._origin = (now, self._session.simulation.time)
        self._paces.clear()
        self._paces.append(self._origin)

    def _due(self, now: float) -> float:
        """The simulated time that is due [s]."""
        start, simulated = self._origin
        return simulated + (now - start) * self._session.speed

    def _idle(self) -> float | None:
        """Take the steps that are due; return the time until the next ones [s], or None while paused."""
        left = self._do_urged(time.perf_counter())
        if not self._playing:
            return left
        now, session = time.perf_counter(), self._session
        behind = self._due(now) - session.simulation.time
        if behind < 0.0:
            return min(-behind / session.speed, math.inf if left is None else left)
        try:
            with unwarned():
                self._advance(now)
        except Exception as error:
            self._playing, self._error = False, str(error)
            session.course.begin()
            self.moment = self._present(audited=False)
            self._report(time.perf_counter())
        return 0.0

    def _advance(self, start: float) -> None:
        """Take steps for one picture, or as many as can be taken in the time of one, and publish the moment."""
        session = self._session
        frame, before = 1.0 / self._fps, session.simulation.time
        duration = session.speed * frame
        if self._cost > 0.0:
            duration = min(duration, frame / self._cost)
        elif math.isnan(self._cost):
            duration = min(duration, session.simulation.dt)
        audited = self._audited or start >= self._audit_due
        passage = session.course.advance(duration, audited=audited)
        now, reached = time.perf_counter(), passage.after.time
        if audited:
            self._audit_due = start + 1.0 / AUDITS
        cost = (now - start) / (reached - before) if reached > before else self._cost
        self._cost = cost if math.isnan(self._cost) else 0.7 * self._cost + 0.3 * cost
        interval = max(now - self.moment.clock, 0.0)
        # Physics that keeps pace is drawn at its own speed, whatever the delays of this thread.
        interval = min(max(interval, 0.0), max((reached - before) / session.speed, now - start))
        self.moment = Moment(passage, session.scene, before, now, interval, self._held())
        self._note_energy(passage)
        self._keep_pace(now, reached)
        if now >= self._report_due:
            self._report(now)

    def _keep_pace(self, now: float, reached: float) -> None:
        """Measure the pace, and give up what is too far behind."""
        late = self._due(now) - reached
        if late > PATIENCE * self._session.speed:
            self._origin = (now, reached)
        self._paces.append((now, reached))
        while len(self._paces) > 2 and now - self._paces[0][0] > WINDOW:
            self._paces.popleft()

    @property
    def _pace(self) -> float | None:
        """Simulated time over the time that was asked for, in the last second; None if that is not known yet."""
        if not self._playing or len(self._paces) < 2:
            return None
        (start, first), (end, last) = self._paces[0], self._paces[-1]
        return (last - first) / ((end - start) * self._session.speed) if end - start > 0.3 * WINDOW else None

    def _present(self, *, audited: bool = True) -> Moment:
        """The present state as a moment."""
        passage = self._session.course.present(audited=audited)
        self._note_energy(passage)
        return Moment(passage, self._session.scene, passage.after.time, time.perf_counter(), 0.0, self._held())

    def _held(self) -> tuple[int, tuple[float, ...]] | None:
        """The row of what the hand holds, and its pointer."""
        hand, scene = self._session.hand, self._session.scene
        return None if hand is None else (scene.place(hand.body).start + hand.index, hand.pointer)

    def _note_energy(self, passage: Passage) -> None:
        """Add a row to the curve of energy, if the energy is known."""
        if passage.energy is not None:
            self._rows.append(energy_row(passage.energy, self._session.drift.add(passage.energy)))

    def _report(self, now: float) -> None:
        """Tell what the page shows beside the picture."""
        session = self._session
        if now >= self._plan_due:
            self._plan = plan_of(session.simulation)
            spent = time.perf_counter() - now
            self._plan_due = now + max(1.0, spent / PLANS)
        rows, self._rows = self._rows, []
        self._report_due = now + 1.0 / REPORTS
        self._tell(
            Report(
                time=session.simulation.time,
                steps=session.simulation.steps,
                playing=self._playing,
                speed=session.speed,
                pace=self._pace,
                values=dict(session.values),
                note=session.note,
                error=self._error,
                plan=self._plan,
                epoch=self._epoch,
                rows=rows,
            )
        )
