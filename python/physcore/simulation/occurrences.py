"""Occurrences of events: their times, and the states at these times."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from physcore.checks import IntArray
from physcore.markup import html_table
from physcore.scene.contents import ItemKey
from physcore.scene.scene import Scene
from physcore.simulation.event import Event
from physcore.simulation.trajectory import Trajectory, channel_rules
from physcore.spelling import UnknownKey, did_you_mean
from physcore.storage.archive import Tree
from physcore.storage.schema import Sizes, record, several, text
from physcore.units.systems import SI

ROWS = 10
"""Number of occurrences that a table shows."""

TIME = 16
"""Least width of a column of times."""


@dataclass(frozen=True, eq=False, repr=False)
class Occurrences(Trajectory):
    """Occurrences of an event in a run, in the order of time.

        sinking = pc.Event.crossing("cloth", "y", -0.05)
        found = pc.simulate(scene, 0.2, events=[sinking]).events[sinking]  # Occurrences; at a prompt, a table
        found.times, found.indices  # (n,) each: when, and which particle
        found["cloth"].velocities  # (n, N, D)

    The fields are those of the recording, each with n states in place of its frames. Tables have the scene's units.
    """

    indices: IntArray
    """Index of the root in the values of the event's function, such as that of a particle, shape (n,)."""
    scene: Scene
    """Simulated scene."""
    name: str
    """Name of the event."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "units", self.scene.units)

    def __getitem__(self, item: ItemKey) -> Trajectory:  # type: ignore[override]  # the part of an item
        return self._part(self.scene, item)

    def __repr__(self) -> str:
        """The table, as at a prompt."""
        if not len(self):
            return f"{self.name}: none"
        heads = self._heads
        first, last = _width(heads[0]), _width(heads[2])
        lines = [f"{time:>{first}}{index:>8}{since:>{last}}".rstrip() for time, index, since in (heads, *self._rows())]
        return "\n".join([f"{self.name}: {len(self)}", *lines, *self._rest()])

    def _repr_html_(self) -> str:
        """The table as HTML, for notebooks."""
        rows = {str(number): cells for number, cells in enumerate(self._rows())}
        return html_table(["", *self._heads], rows, caption=", ".join([f"{self.name}: {len(self)}", *self._rest()]))

    def content(self) -> dict[str, Tree]:
        """The occurrences as plain values, for a file."""
        return {"name": self.name, "times": self.times, "indices": self.indices, "channels": self.channels}

    def end(self, index: int) -> str:
        """The time of the first or of the last occurrence, as text."""
        return f"{self.times[index]:.9g}" if len(self) else ""

    @property
    def _heads(self) -> tuple[str, str, str]:
        """The heads of the table."""
        return self.units.label("time", "s"), "index", self.units.label("since the one before", "s")

    def _rows(self) -> list[tuple[str, str, str]]:
        """The cells of the first occurrences."""
        since = ["", *(f"{each:.9g}" for each in np.diff(self.times[:ROWS]))]
        shown = zip(self.times[:ROWS], self.indices, since, strict=False)
        return [(f"{time:.9g}", str(index), after) for time, index, after in shown]

    def _rest(self) -> list[str]:
        """A line on the occurrences that the table omits."""
        return [f"and {len(self) - ROWS} more"] * (len(self) > ROWS)


@dataclass(frozen=True, eq=False, repr=False)
class Events:
    """Occurrences of all events of a run: `events[event]`, or by the name or the number of the event.

        low = pc.Event.crossing("cloth", "y", -0.05, name="low")
        events = pc.simulate(scene, 0.2, events=[low]).events  # Events; at a prompt, a table
        events[low].times, events["low"].times, events[0].times  # the same

    `Recording.events` and `Simulation.events` are of this class. Loaded and unpickled ones have no functions, and are
    accessed by names or numbers.
    """

    found: tuple[Occurrences, ...] = ()
    """The occurrences of each event."""
    keys: tuple[Event, ...] = ()
    """The events."""

    @classmethod
    def from_content(cls, content: Tree, path: str, scene: Scene, sizes: Sizes) -> Self:
        """The events of a recording from its file.

        Raises:
            FileError: the content is not valid.
        """

        def occurrences(value: Tree, path: str) -> Occurrences:
            rules = {
                "name": text,
                "times": sizes.array(path, finite=True),
                "indices": sizes.array(path, kind=np.int64),
                "channels": record(channel_rules(scene, sizes, path)),
            }
            return Occurrences(**record(**rules)(value, path), scene=scene)

        return cls(several(occurrences)(content, path))

    def __getitem__(self, key: Event | str | int) -> Occurrences:
        """The occurrences of an event.

        Raises:
            UnknownKey: there is no such event, or there are several of this name.
        """
        if isinstance(key, (int, np.integer)) and not isinstance(key, bool) and -len(self) <= key < len(self):
            return self.found[key]
        own = [self.found[index] for index, event in enumerate(self.keys) if event is key]
        own += [each for each in self.found if isinstance(key, str) and each.name == key]
        if len(own) == 1:
            return own[0]
        if isinstance(key, Event) and len(self) > len(self.keys):
            raise UnknownKey(f"no event {key.name!r}: a loaded recording has no functions: use its name or number")
        names = [str(each.name) for each in self.found]
        hint = did_you_mean(key, names) if not own else "; use its number"
        named = repr(key.name if isinstance(key, Event) else key)
        there = ", ".join(map(repr, names)) or "none"
        raise UnknownKey(f"{'no' if not own else 'more than one'} event {named}: there are {there}{hint}")

    def __iter__(self) -> Iterator[Occurrences]:
        return iter(self.found)

    def __len__(self) -> int:
        return len(self.found)

    def __getstate__(self) -> dict[str, Any]:
        """The state without the events, whose functions may not pickle."""
        return {"found": self.found, "keys": ()}

    def __repr__(self) -> str:
        """The table, as at a prompt."""
        rows = self._rows()
        if not rows:
            return "no events"
        width = max(len("event"), *(len(name) for name, *_ in rows))
        heads = self._heads
        column = max(map(_width, heads[2:]))
        lines = [
            f"{name:<{width}}{count:>8}{first:>{column}}{last:>{column}}".rstrip()
            for name, count, first, last in (heads, *rows)
        ]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """The table as HTML, for notebooks."""
        rows = {f"{index}: {name}": cells for index, (name, *cells) in enumerate(self._rows())}
        return html_table(self._heads, rows)

    @property
    def _heads(self) -> tuple[str, str, str, str]:
        """The heads of the table."""
        units = self.found[0].units if self.found else SI
        return "event", "number", units.label("first", "s"), units.label("last", "s")

    def _rows(self) -> list[tuple[str, str, str, str]]:
        """The name of each event, the number of occurrences, and the times of the first and the last one."""
        return [(each.name, str(len(each)), each.end(0), each.end(-1)) for each in self.found]


def _width(head: str) -> int:
    """The width of a column of times below a head."""
    return max(TIME, len(head) + 2)
