"""Provenance of a state: all that is needed, in addition to the scene, to reproduce and verify it."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import cache
from typing import Self

from physcore.checks import shown
from physcore.errors import FileError
from physcore.storage.archive import Tree
from physcore.storage.schema import Rule, either, of, real, record, several, table, text


@dataclass(frozen=True)
class Segment:
    """Consecutive steps of one size, or of sizes that follow the motion."""

    start: float
    """Start of the first step [s]."""
    steps: int
    """Number of steps."""
    dt: float | tuple[float, float]
    """Time step [s]; for adaptive steps the smallest and the largest."""

    @classmethod
    def from_content(cls, content: Tree) -> Self:
        """A segment from a file, where tuples are lists."""
        dt = content["dt"]
        return cls(content["start"], content["steps"], tuple(dt) if isinstance(dt, (list, tuple)) else dt)


@dataclass(frozen=True)
class Provenance:
    """Provenance of a simulation, from the start of its scene to its state. `Simulation.set` is not recorded in it.

    After `Simulation.replace` the steps are those in all scenes, and the scene beside it is the last one.
    """

    version: str
    """Version of physcore that computed the state."""
    numerics: dict[str, Tree]
    """Numerical options as names and plain values; an integrator or a step rule has its class and its fields."""
    segments: tuple[Segment, ...]
    """The steps that were taken."""
    state_hash: str
    """`Simulation.state_hash()` at the end."""

    def content(self) -> dict[str, Tree]:
        """The provenance as plain values, for a file."""
        return asdict(self)

    @classmethod
    def from_content(cls, content: Tree, path: str = "provenance") -> Self:
        """The provenance from the result of `content`.

        Raises:
            FileError: the content is not valid.
        """
        checked = of(cls, numerics=table(either(dict, _choice, _scalar)), segments=SEGMENTS)(content, path)
        return cls(**{**checked, "segments": segments_from(checked["segments"])})


def segments_from(content: Tree) -> tuple[Segment, ...]:
    """Segments from a file."""
    return tuple(Segment.from_content(entry) for entry in content)


def _segment(value: Tree, path: str) -> Tree:
    """A segment in a file, which ends at a finite time."""
    step = real(above=0.0)
    checked: Tree = of(Segment, start=real(least=0.0), dt=either(list, several(step, lengths=(2,)), step))(value, path)
    largest = max(checked["dt"]) if isinstance(checked["dt"], tuple) else checked["dt"]
    if math.isinf(checked["start"] + checked["steps"] * largest):
        raise FileError(f"{path}: must end at a finite time")
    return checked


SEGMENTS: Rule = several(_segment)
"""Rule for the segments in a file."""


def _choice(value: Tree, path: str) -> Tree:
    """An integrator, a step rule or a method of fluids; or several of these by the paths of their items."""
    return (_one if "kind" in value else table(_one))(value, path)


def _one(value: Tree, path: str) -> Tree:
    """An object with its fields, which may contain further objects, such as the kernel of a method."""
    return record(kind=text, fields=table(either(dict, _one, _scalar)))(value, path)


def _scalar(value: Tree, path: str) -> Tree:
    """A scalar value of JSON."""
    if isinstance(value, (dict, list)):
        raise FileError(f"{path}: must be one value, got {shown(value)}")
    return value


@cache
def version() -> str:
    """The version of physcore, cached because reading package metadata is slow."""
    from importlib import metadata

    return metadata.version("physcore")
