"""The panel: its parts, and its methods for scripts."""

from __future__ import annotations

import atexit
import json
import os
import threading
import weakref
from collections.abc import Callable, Mapping
from importlib.resources import files
from types import TracebackType
from typing import Any, Self, cast

from numpy.typing import ArrayLike

from physcore.checks import is_word
from physcore.errors import FileError
from physcore.film.renderer import AUDITED
from physcore.panel.artist import Artist, Picture
from physcore.panel.controls import Control
from physcore.panel.report import COLUMNS, Report
from physcore.panel.requests import Desk
from physcore.panel.runner import Runner
from physcore.panel.server import Server
from physcore.panel.session import Session
from physcore.panel.shared import SharedSimulation
from physcore.scene.contents import BodyKey
from physcore.simulation.simulation import Simulation
from physcore.storage.files import replacing

PAGE = "page.html"
"""File of the page, read once when a panel is opened."""
CURVE = 900
"""Rows of the curve of energy that a new page is given."""


class Panel:
    """Panel of a simulation that plays.

        with pc.live(lambda: pc.Scene(pc.Particles([[0.0, 1.0]]), pc.Gravity()), show=False) as panel:  # a Panel
            panel.step(10)
            panel.simulation.time
            panel.reset()

    `live` opens it. All methods return when they have taken effect, and may be called from any thread. A context
    manager closes it at the end.
    """

    def __init__(
        self,
        session: Session,
        controls: Mapping[str, Control],
        pictures: Mapping[str, Any],
        fps: float,
        port: int,
        *,
        shown: bool,
    ) -> None:
        self._begins, daemon = shown, not shown
        self._controls, self._pictures = dict(controls), dict(pictures)
        self.speed = session.speed
        """Seconds of the simulation per second, as asked for."""
        self._curve: list[list[float]] = []
        self._last: Report | None = None
        self._lock = threading.RLock()
        self._closing, self._closed = False, threading.Event()
        audited = _shows_energy(pictures)
        self.runner = Runner(session, fps, audited=audited, tell=self._tell, daemon=daemon)
        self.artist = Artist(
            lambda: self.runner.moment, session.scene, pictures, fps, self._deliver, audited=audited, daemon=daemon
        )
        self.desk = Desk(self.runner, self.artist, self.speed)
        self._server = Server(
            page(),
            port,
            receive=self.desk.receive,
            greet=self.greeting,
            save=self.gif,
            watched=lambda on: self.watched(self, on=on),
            deserted=self._end,
            daemon=daemon,
        )
        self._simulation = SharedSimulation(self.runner)
        self.listeners: list[Callable[[dict[str, Any]], None]] = []
        """Functions of widgets that are called with each message to pages."""
        self.viewers: list[Callable[[Picture], None]] = []
        """Functions of widgets that are called with each picture."""
        self._watchers: set[object] = set()
        try:
            for part in (self.runner, self.artist, self._server):
                part.start()
        except BaseException:
            self.close()
            raise
        _open_panels.add(self)
        self.runner.ask(lambda session: None)

    @property
    def url(self) -> str:
        """The address of the page, with its token. Who knows it, on this machine, can use the panel."""
        return self._server.door.url

    @property
    def simulation(self) -> Simulation:
        """The simulation. It may be read from any thread while it plays: each read waits for the end of a batch."""
        return cast("Simulation", self._simulation)

    @property
    def values(self) -> dict[str, Any]:
        """The values of the controls."""
        return self.runner.read(lambda session: dict(session.values))

    @property
    def note(self) -> str:
        """Effect of the last `set`: that the simulation goes on, or why it started anew."""
        return self.runner.read(lambda session: session.note)

    @property
    def report(self) -> Report:
        """The latest report to the page."""
        assert self._last is not None  # The constructor waits for the first one.
        return self._last

    @property
    def error(self) -> str:
        """Reason for which the simulation stopped, such as a divergence; empty if it did not."""
        return self.report.error

    @property
    def closed(self) -> bool:
        """Whether the panel is closed."""
        return self._closed.is_set()

    def play(self) -> None:
        """Let the simulation play, from its present state."""
        self.runner.ask(lambda session: self.runner.play(on=True))

    def pause(self) -> None:
        """Pause after the present batch of steps."""
        self.runner.ask(lambda session: self.runner.play(on=False))

    def step(self, n: int = 1) -> None:
        """Pause, and take n equal steps.

        Raises:
            SceneError: steps are adaptive, and so not equal.
            SimulationDiverged: the state blew up; the simulation stands at the last good step.
        """
        self.runner.ask(lambda session: self.runner.step(n))

    def reset(self) -> None:
        """Go back to the scene of the present controls at time 0, paused.

        Raises:
            SceneError: the scene cannot be built. The panel is then as before.
        """
        self.runner.ask(lambda session: self.runner.reset())

    def set(self, **values: Any) -> None:
        """Set controls: `panel.set(stiffness=400.0)`.

        The simulation goes on from its present state by `Simulation.replace`, so that the change of energy is work.
        Where that is not possible, as with another number of particles, it starts anew. `note` says which.

        Raises:
            SceneError: there is no such control, a value is out of range, or the scene cannot be built. The panel is
                then as before.
        """
        self.runner.ask(lambda session: session.set(values))

    def grab(self, key: tuple[BodyKey, int] | BodyKey | ArrayLike, stiffness: float | None = None) -> None:
        """Take hold of a particle or a rigid body by a spring of no length to the pointer, which is where it is.

            panel.grab(("net", 5), stiffness=100.0)
            panel.drag((0.3, 0.1))
            panel.release()

        Args:
            key: (body, index), a body of one element, or a point [m], to which the nearest one is taken.
            stiffness: stiffness of the spring [N/m]; None: a value with which it follows the pointer in some tenths of
                a second, and that is stable at the present time step. The held element has some drag as well.

        Raises:
            SceneError: there is no such element, or the scene holds it fixed.
        """
        self.runner.ask(lambda session: session.grab(key, stiffness))

    def drag(self, point: ArrayLike) -> None:
        """Move the pointer to a point [m]. The change of the spring's energy is work.

        Raises:
            SceneError: nothing is held, or the point has another dimension.
        """
        self.runner.ask(lambda session: session.drag(point))

    def turn(self, rotation: ArrayLike) -> None:
        """Turn the rigid body that is held, by springs to its orientation at the grab turned by `rotation`.

            panel.grab("wheel")
            panel.turn(0.5)
            panel.release()

        The springs hold its center at the pointer too. The change of their energy is work.

        Args:
            rotation: angle in 2D, rotation vector in 3D [rad]. The torque is largest where the body is a quarter of a
                turn behind.

        Raises:
            SceneError: nothing is held, or no rigid body, or the rotation is not valid.
        """
        self.runner.ask(lambda session: session.turn(rotation))

    def release(self) -> None:
        """Let go of what is held."""
        self.runner.ask(lambda session: session.release())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the last seconds that the page has shown as a GIF.

        Raises:
            SceneError: nothing was shown yet.
            FileError: the file cannot be written, or its name does not end in .gif.
        """
        if not str(path).lower().endswith(".gif"):
            raise FileError(f"{path}: must end in .gif")
        content = self.gif()
        with replacing(path) as file:
            file.write(content)

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the panel is closed, as by its page, at most `timeout` seconds; returns whether it is closed."""
        return self._closed.wait(timeout)

    def close(self) -> None:
        """End the simulation, and close the page's address. Closing twice does nothing."""
        with self._lock:
            closing, self._closing = self._closing, True
        if closing:
            self._closed.wait()
            return
        self._send({"kind": "closed"})
        self._server.stop()
        self.artist.stop()
        self.runner.stop()
        self._closed.set()
        _open_panels.discard(self)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self.closed else self.url
        return f"Panel({', '.join(self._controls) or 'no controls'}: {state})"

    def gif(self) -> bytes:
        """The bytes of a GIF of the last seconds that were shown."""
        return self.artist.reel.gif(self.runner.moment.scene)

    def greeting(self) -> list[str]:
        """The messages for a new page. The first page of a panel that is shown begins to play."""
        if self._begins:
            self._begins = False
            self.runner.post(lambda session: self.runner.play(on=True))
        controls = [
            {"name": name, "kind": control.kind, **control.content()} for name, control in self._controls.items()
        ]
        scene = self.runner.moment.scene
        hello = {
            "kind": "hello",
            "controls": controls,
            "columns": COLUMNS,
            "themed": "theme" in self._pictures,
            "speed": self.speed,
            "drags": bool(scene.bodies),
            "turns": scene.has_rigid_bodies,
            "deep": scene.dimension == 3,
        }
        with self._lock:
            report = {} if self._last is None else {**self._last.content(), "rows": list(self._curve), "whole": True}
        return [json.dumps(hello), *([json.dumps(report)] if report else [])]

    def watched(self, watcher: object, *, on: bool) -> None:
        """Draw while somebody looks: the pages, or a widget."""
        with self._lock:
            (self._watchers.add if on else self._watchers.discard)(watcher)
            self.artist.watch(on=bool(self._watchers))

    def _tell(self, report: Report) -> None:
        """Pass a report on to pages, and keep its curve for new ones."""
        content = report.content()
        with self._lock:
            if self._last is not None and self._last.epoch != report.epoch:
                self._curve.clear()
            self._curve += content["rows"]
            del self._curve[:-CURVE]
            self._last = report
        content["error"] = content["error"] or self.artist.error
        self._send(content)

    def _send(self, content: dict[str, Any]) -> None:
        self._server.tell(content)
        for listener in list(self.listeners):
            listener(content)

    def _deliver(self, picture: Picture) -> None:
        self._server.show(picture.pixels, picture.hand)
        for viewer in list(self.viewers):
            viewer(picture)

    def _end(self) -> None:
        """Close from a thread that `close` waits for."""
        threading.Thread(target=self.close, name="physcore-panel-end").start()


def page() -> str:
    """The page: one HTML file with all that it needs."""
    return files("physcore.panel").joinpath(PAGE).read_text(encoding="utf-8")


def _shows_energy(pictures: Mapping[str, Any]) -> bool:
    """Whether pictures with these options, which may be invalid, show energies or time steps."""
    labels = pictures.get("labels")
    shown = labels if isinstance(labels, (tuple, list)) else ()
    return pictures.get("inset") is not None or any(is_word(label, word) for label in shown for word in AUDITED)


def _close_all() -> None:
    """Close the panels that are open when the interpreter ends."""
    for panel in open_panels():
        panel.close()


atexit.register(_close_all)
_open_panels: weakref.WeakSet[Panel] = weakref.WeakSet()
"""Panels to be closed at the end of the interpreter."""


def open_panels() -> list[Panel]:
    """The panels that are open."""
    return list(_open_panels)
