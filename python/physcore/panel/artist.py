"""Pictures of a panel, drawn in a thread of their own by the renderer of films."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from physcore.checks import FloatArray
from physcore.film.camera.view import View
from physcore.film.renderer import Renderer
from physcore.panel.reel import Reel
from physcore.panel.runner import Moment
from physcore.scene.scene import Scene
from physcore.simulation.state import Frame, Snapshot

ROOM = 1.25
"""Width of the view over that of the first state, in which it is going to move."""
SIZE, LARGEST = (640, 480), 1.4
"""Size of pictures, if none is asked for [pixels], and the largest factor by which it grows with the page."""
LEAP = 0.02
"""Least fraction of the way between two moments that is worth another picture."""


@dataclass(frozen=True, eq=False)
class Picture:
    """Drawn picture."""

    pixels: NDArray[np.uint8]
    """Colors (height, width, 3)."""
    state: Snapshot
    """The state that it shows."""
    view: View
    """Projection of its scene to pixels."""
    hand: tuple[float, float, float, float] | None
    """Pixels of what is held, and of the pointer."""


class Artist:
    """Thread that draws the present moment of a physics thread.

    Args:
        moment: gives the present moment.
        scene: the first scene.
        options: options of the renderer.
        fps: pictures per second.
        deliver: is called with each picture, in this thread.
        audited: whether pictures show energies or time steps, which moments then have.
        daemon: whether the interpreter may end while it runs.

    Raises:
        SceneError: an option is not valid, or does not suit the scene.
    """

    def __init__(
        self,
        moment: Callable[[], Moment],
        scene: Scene,
        options: Mapping[str, Any],
        fps: float,
        deliver: Callable[[Picture], None],
        *,
        audited: bool,
        daemon: bool,
    ) -> None:
        self._moment, self._options, self._fps, self._deliver = moment, dict(options), fps, deliver
        self._audited = audited
        if "format" in options:
            self._options.setdefault("size", None)
        self._lock = threading.Lock()
        self._wake = threading.Event()
        self._open, self._watched, self._lost = True, False, False
        self._shown: tuple[Moment, float] | None = None
        self._look: dict[str, Any] = {"size": SIZE}
        """Options that follow the page."""
        self._renderer = self._made(scene)
        self.error = ""
        self.reel = Reel()
        self.picture = self._drawn(moment(), 1.0)
        """The latest picture. Any thread may read it."""
        self._thread = threading.Thread(target=self._run, name="physcore-panel-pictures", daemon=daemon)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread, and wait for its end."""
        self._open = False
        self._wake.set()
        if self._thread.ident is not None and threading.current_thread() is not self._thread:
            self._thread.join()

    def watch(self, *, on: bool) -> None:
        """Begin or end to draw; a panel that nobody looks at draws nothing."""
        self._watched = on
        self._shown = None
        if on:
            self._wake.set()
        else:
            self._wake.clear()

    def frame_anew(self) -> None:
        """Frame the next picture anew, around the state then."""
        self._lost = True

    def turn(self, azimuth: float, elevation: float, zoom: float) -> None:
        """Turn and magnify the view, as `Renderer.turn` does.

        Raises:
            SceneError: a value is not valid, or the camera moves by itself.
        """
        with self._lock:
            self._renderer.turn(azimuth, elevation, zoom)
        self._shown = None

    def suit(self, theme: str, width: float) -> None:
        """Draw from now on in a theme and for a width of the page [pixels], as far as the options leave them open."""
        factor = min(max(width / SIZE[0], 1.0), LARGEST)
        size = tuple(2 * round(factor * side / 2) for side in SIZE)
        look = {name: value for name, value in (("theme", theme), ("size", size)) if name not in self._options}
        with self._lock:
            if look != self._look:
                self._look, before = look, self._renderer
                self._renderer = self._made(self._moment().scene)
                self._renderer.look_as(before)
        self._shown = None

    def _made(self, scene: Scene) -> Renderer:
        """A renderer."""
        room = ROOM if scene.bodies else 1.0
        return Renderer(scene, **{"room": room, "fps": self._fps, **self._look, **self._options})

    def _run(self) -> None:
        due = 0.0
        while self._open:
            self._wake.wait()
            now = time.perf_counter()
            due = max(due, now - 1.0 / self._fps) + 1.0 / self._fps
            try:
                self._draw_next(now)
            except Exception as error:
                self.error = f"the picture cannot be drawn: {error}"
            time.sleep(max(due - time.perf_counter(), 0.0))

    def _draw_next(self, now: float) -> None:
        """Draw what is due, unless it is drawn already."""
        moment = self._moment()
        share = moment.share(now)
        if self._lost:
            self._lost = False
            self._renderer.reset()
        elif self._shown is not None and self._shown[0] is moment and not _is_news(share, self._shown[1]):
            return
        with self._lock:
            picture = self._drawn(moment, share)
        self._shown, self.picture, self.error = (moment, share), picture, ""
        if not self._open or not self._watched:
            return
        self.reel.add(now, picture.pixels)
        self._deliver(picture)

    def _drawn(self, moment: Moment, share: float) -> Picture:
        """The picture of a moment."""
        state = moment.state(share)
        pixels = self._renderer.draw(_frame(state, moment) if self._audited else state)
        view = self._renderer.view
        assert view is not None  # A picture was drawn.
        return Picture(pixels, state, view, _pixels_of_hand(moment, state, view))


def _is_news(share: float, shown: float) -> bool:
    """Whether a fraction of the way between two moments is worth another picture after the last one."""
    return share - shown >= LEAP or (share == 1.0 and shown < 1.0)


def places_of(state: Snapshot) -> FloatArray:
    """The positions of all particles and rigid bodies, in the order of the engine's rows [m]."""
    scene = state.scene
    assert scene is not None  # It is the state of a whole scene.
    parts = [state[body].positions for body in scene.bodies]
    return np.concatenate(parts) if parts else np.empty((0, scene.dimension))


def _pixels_of_hand(moment: Moment, state: Snapshot, view: View) -> tuple[float, float, float, float] | None:
    """Pixels of what is held, and of the pointer."""
    if moment.hand is None:
        return None
    row, pointer = moment.hand
    ends, _, _ = view.project(np.array([places_of(state)[row], pointer]))
    x0, y0, x1, y1 = ends.ravel().tolist()
    return x0, y0, x1, y1


def _frame(state: Snapshot, moment: Moment) -> Frame:
    """A state with the energy of the last step, for the labels of pictures."""
    passage = moment.passage
    assert passage.energy is not None  # The caller has checked this.
    nothing = np.zeros(0)
    length = passage.after.time - passage.before.time
    return Frame(**vars(state), dt=length, energy=passage.energy, momentum=nothing, angular_momentum=nothing)
