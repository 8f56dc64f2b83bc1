"""Requests of a page: the effect of each on the parts of a panel. Each returns at once; errors become reports."""

from __future__ import annotations

import queue
from collections.abc import Callable, Mapping
from typing import Any

from physcore.checks import number, word
from physcore.errors import PhyscoreError
from physcore.panel.artist import Artist, Picture
from physcore.panel.pointer import moved, picked, rolled
from physcore.panel.runner import Runner
from physcore.panel.session import Session

BEYOND = 100.0
"""Largest distance of a pointer from a picture, as a share of its sides."""
SPEEDS = 1024.0
"""Largest factor by which a page changes the speed."""


class Desk:
    """Desk at which requests of pages come in.

    Args:
        runner: the thread of physics.
        artist: the thread of pictures.
        speed: the speed of which pages choose factors [s/s].
    """

    def __init__(self, runner: Runner, artist: Artist, speed: float) -> None:
        self.runner, self.artist, self.speed = runner, artist, speed
        self.waiting: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        """Values of controls that pages have set, until physics knows them."""

    def receive(self, message: object) -> None:
        """Do as a page asks. Other messages are ignored: they come from no page of this package."""
        if not isinstance(message, dict) or not isinstance(message.get("do"), str):
            return
        request = REQUESTS.get(message["do"])
        if request is not None:
            try:
                request(self, message)
            except (PhyscoreError, KeyError):
                return


def _set(desk: Desk, message: Mapping[str, Any]) -> None:
    values = message["values"]
    if isinstance(values, dict):
        desk.waiting.put(values)
        desk.runner.urge("set", lambda session: _set_now(desk, session))


def _set_now(desk: Desk, session: Session) -> None:
    """Set all values that have come in since the last time."""
    values: dict[str, Any] = {}
    while not desk.waiting.empty():
        values |= desk.waiting.get()
    if values:
        session.set(values)


def _speed(desk: Desk, message: Mapping[str, Any]) -> None:
    factor = number(message["factor"], "speed.factor", least=1.0 / SPEEDS, most=SPEEDS)
    desk.runner.post(lambda session: desk.runner.set_speed(factor * desk.speed))


def _grab(desk: Desk, message: Mapping[str, Any]) -> None:
    picture = desk.artist.picture
    x, y = _pixel(message, picture)
    found, seen = picked(picture, x, y), picture.state.scene
    if found is None or seen is None:
        return
    place, index = seen.index(found[0]), found[1]

    def grab(session: Session) -> None:
        """Take hold of the element in the present scene, which may have replaced the one in the picture."""
        bodies = session.scene.bodies
        if place < len(bodies) and index < len(bodies[place]):
            session.grab((bodies[place], index), None)

    desk.runner.post(grab)


def _drag(desk: Desk, message: Mapping[str, Any]) -> None:
    picture = desk.artist.picture
    x, y = _pixel(message, picture)

    def drag(session: Session) -> None:
        if session.hand is not None:
            session.drag(moved(picture.view, session.hand.pointer, x, y))

    desk.runner.urge("drag", drag)


def _roll(desk: Desk, message: Mapping[str, Any]) -> None:
    picture = desk.artist.picture
    x, y = _pixel(message, picture)

    def roll(session: Session) -> None:
        if session.hand is not None and session.hand.body.is_rigid:
            session.turn(rolled(picture, x, y))

    desk.runner.urge("roll", roll)


def _release(desk: Desk, message: Mapping[str, Any]) -> None:
    desk.runner.post(lambda session: session.release())


def _play(desk: Desk, message: Mapping[str, Any]) -> None:
    desk.runner.post(lambda session: desk.runner.play(on=True))


def _pause(desk: Desk, message: Mapping[str, Any]) -> None:
    desk.runner.post(lambda session: desk.runner.play(on=False))


def _step(desk: Desk, message: Mapping[str, Any]) -> None:
    desk.runner.post(lambda session: desk.runner.step(1))


def _reset(desk: Desk, message: Mapping[str, Any]) -> None:
    desk.runner.post(lambda session: desk.runner.reset())


def _frame(desk: Desk, message: Mapping[str, Any]) -> None:
    desk.artist.frame_anew()


def _turn(desk: Desk, message: Mapping[str, Any]) -> None:
    angles = [number(message[name], name, least=-360.0, most=360.0) for name in ("azimuth", "elevation")]
    desk.artist.turn(angles[0], angles[1], number(message["zoom"], "zoom", least=0.1, most=10.0))


def _look(desk: Desk, message: Mapping[str, Any]) -> None:
    width = number(message["width"], "width", least=1.0, most=1e5)
    desk.artist.suit(word(message["theme"], "theme", ("dark", "light")), width)


def _pixel(message: Mapping[str, Any], picture: Picture) -> tuple[float, float]:
    """The pixel of a picture that a page means, which gives shares of its own one. That one may have another size."""
    height, width, _ = picture.pixels.shape
    x, y = (number(message[name], name, least=-BEYOND, most=BEYOND) for name in ("x", "y"))
    return width * x, height * y


REQUESTS: dict[str, Callable[[Desk, Mapping[str, Any]], None]] = {
    "play": _play,
    "pause": _pause,
    "step": _step,
    "reset": _reset,
    "set": _set,
    "speed": _speed,
    "grab": _grab,
    "drag": _drag,
    "roll": _roll,
    "release": _release,
    "frame": _frame,
    "look": _look,
    "turn": _turn,
}
"""Requests by name. "seen" and "save" are answered by what carries the messages."""
