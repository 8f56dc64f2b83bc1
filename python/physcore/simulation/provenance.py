"""The provenance of a state: what it takes, beside the scene, to compute it again and to check that."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cache
from typing import Self

from physcore.checks import shown
from physcore.errors import FileError
from physcore.storage.archive import Tree
from physcore.storage.schema import Rule, either, of, record, several, table, text


@dataclass(frozen=True)
class Segment:
    """Steps in a row, all of one size, or of sizes that followed the motion."""

    start: float
    """When the first of them began [s]."""
    steps: int
    """How many they are."""
    dt: float | tuple[float, float]
    """Their size [s]; of adaptive steps the smallest and the largest."""

    @classmethod
    def from_content(cls, content: Tree) -> Self:
        """A segment out of a file, where tuples are lists."""
        dt = content["dt"]
        return cls(content["start"], content["steps"], tuple(dt) if isinstance(dt, list) else dt)


@dataclass(frozen=True)
class Provenance:
    """How a simulation came to its state, from the start of its scene; `Simulation.set` leaves no trace in it."""

    version: str
    """The physcore that computed it."""
    numerics: dict[str, Tree]
    """The numerical choices: names and plain values, of an integrator or a rule for steps its kind and its fields."""
    segments: tuple[Segment, ...]
    """The steps that were taken."""
    state_hash: str
    """`Simulation.state_hash()` at the end."""

    def content(self) -> dict[str, Tree]:
        """For a file."""
        return asdict(self)

    @classmethod
    def from_content(cls, content: Tree, path: str = "provenance") -> Self:
        """The provenance that `content` gave.

        Raises:
            FileError: it is something else.
        """
        checked = of(cls, numerics=table(either(dict, _choice, _scalar)), segments=SEGMENTS)(content, path)
        return cls(**{**checked, "segments": segments_from(checked["segments"])})


def segments_from(content: Tree) -> tuple[Segment, ...]:
    """Segments out of a file."""
    return tuple(Segment.from_content(entry) for entry in content)


SEGMENTS: Rule = several(of(Segment))
"""The rule for the segments in a file."""


def _choice(value: Tree, path: str) -> Tree:
    """An integrator, a rule for steps or a method for fluids; or several by the paths of what they are for."""
    return (_one if "kind" in value else table(_one))(value, path)


def _one(value: Tree, path: str) -> Tree:
    """A thing with its fields, in which may be others, as a kernel is in a method."""
    return record(kind=text, fields=table(either(dict, _one, _scalar)))(value, path)


def _scalar(value: Tree, path: str) -> Tree:
    """One value of JSON."""
    if isinstance(value, (dict, list)):
        raise FileError(f"{path}: must be one value, got {shown(value)}")
    return value


@cache
def version() -> str:
    """The version of this physcore; found once, because reading package metadata takes its time."""
    from importlib import metadata

    return metadata.version("physcore")
