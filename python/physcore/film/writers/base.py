"""Formats of films: the job that a writer is given, the base of writers, and the display time of frames."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import ClassVar, Literal, get_args

from physcore._core import Canvas
from physcore.checks import span
from physcore.errors import SceneError, SceneWarning, warn
from physcore.film.renderer import Renderer
from physcore.film.writers.loops import Repeat
from physcore.markup import inline_image
from physcore.progress import Progress
from physcore.storage.formats import Format

Quality = Literal["fast", "high"]
KINDS = {".gif": "gif", ".webp": "webp", ".apng": "apng", ".png": "png"}
"""What a page shows as an image."""
INLINE = 3_000_000
"""Films of at most so many bytes are shown by themselves in notebooks."""
QUALITIES: tuple[Quality, ...] = get_args(Quality)


@dataclass(frozen=True)
class Film:
    """A film that was written."""

    path: Path
    """The path of its file."""
    bytes: int
    """How large it is."""
    size: tuple[int, int]
    """Width and height [pixels]."""
    frames: int
    """How many it shows."""
    rate: float
    """How many of them in a second."""
    colors: int | None = None
    """How many it has at most; None: all that there are."""

    def __repr__(self) -> str:
        moving = f", {self.frames} frames, {self.rate:.4g} per second" if self.frames > 1 else ""
        colors = "" if self.colors is None else f", {self.colors} colors"
        return f"{self.path}: {self.size[0]}×{self.size[1]}{moving}{colors}, {self.bytes / 1e6:.2f} MB"

    def _repr_html_(self) -> str:
        """For notebooks: the film itself as long as it has at most 3 MB and is still there, and what it is."""
        words = f"<div>{escape(repr(self))}</div>"
        kind = KINDS.get(self.path.suffix.lower())
        if kind is None or self.bytes > INLINE:
            return f'<a href="{escape(str(self.path))}">{words}</a>'
        try:
            return inline_image(self.path.read_bytes(), kind, repr(self)) + words
        except OSError:
            return words


@dataclass(frozen=True, eq=False)
class FilmJob:
    """A film to be written, one frame at a time."""

    renderer: Renderer
    """The renderer of its frames."""
    rate: float
    """Frames per second."""
    quality: Quality
    """How much care is taken of colors, where a format has few."""
    max_bytes: int | None
    """How large the file may become, where a format can be made smaller."""
    describe: Callable[[], str]
    """Gives the provenance record, as JSON in ASCII; a scene that was not simulated yet is, so ask late."""
    progress: bool | None
    """Whether to show a progress bar, as in `film`."""
    repeat: Repeat = field(default_factory=Repeat)
    """How it begins again."""

    def count(self, stride: int = 1) -> int:
        """How many frames the film has, if of so many of the renderer's one is shown."""
        return self.repeat.count(math.ceil(self.renderer.count / stride), self.rate / stride)

    def delays(self, ticks: int, stride: int = 1) -> list[int]:
        """How long each frame is shown, in units of 1/ticks s, none of them late by more than half a unit."""
        result = delays(self.count(stride), self.rate / stride, ticks)
        if result:
            result[self.held(stride)] += round(self.repeat.hold * ticks)
        return result

    def held(self, stride: int = 1) -> int:
        """The number of the frame that is held: the last one drawn."""
        return min(math.ceil(self.renderer.count / stride), self.count(stride)) - 1

    @property
    def provenance(self) -> str:
        """The provenance record, as JSON in ASCII."""
        return self.describe()

    def frames(self, stride: int = 1) -> Iterator[Canvas]:
        """Every frame, or every second, third, …; each canvas is valid until the next is asked for."""
        return self.repeat.frames(self._drawn(stride), math.ceil(self.renderer.count / stride), self.rate / stride)

    def _drawn(self, stride: int) -> Iterator[Canvas]:
        """Those of the renderer."""
        with Progress(self.renderer.count, "drawing", self.progress) as bar:
            for index, canvas in enumerate(self.renderer.frames()):
                if index % stride == 0:
                    yield canvas
                bar.update(index + 1)


class Writer(Format, ABC):
    """A format of films."""

    name: ClassVar[str]
    """Its name in a sentence."""
    fastest: ClassVar[float] = math.inf
    """Frames per second that every viewer shows."""
    longest: ClassVar[float] = math.inf
    """How long it can show one frame [s]."""

    @classmethod
    def rate(cls, fps: float, speed: float | None) -> float:
        """Frames per second of a film that shows `fps` frames of each simulated second; None: in real time, or slower,
        with a warning, where the format cannot.

        Raises:
            SceneError: the format cannot show them at that speed.
        """
        if speed is None and fps > cls.fastest * (1.0 + 1e-9):
            warn(
                f"{cls.name} shows at most {cls.fastest:g} frames per second, so that this film of {fps:g} plays at "
                f"{cls.fastest / fps:.2g} of its speed; record {cls.fastest:g} or fewer for real time",
                SceneWarning,
            )
            return cls.fastest
        rate = fps * (1.0 if speed is None else span(speed, "speed"))
        if rate > cls.fastest * (1.0 + 1e-9):
            raise SceneError(
                f"fps: {cls.name} shows at most {cls.fastest:g} frames per second, got {rate:g}; record fewer, "
                f"or play it slower: speed={cls.fastest:g}/{fps:g}"
            )
        if rate * cls.longest < 1.0:
            raise SceneError(
                f"fps: {cls.name} shows a frame for at most {cls.longest:.0f} s, got {1 / rate:g} s; "
                f"play it faster: speed={30.0 / fps:.3g}"
            )
        return rate

    budgeted: ClassVar[bool] = False
    """Whether it can be made to fit into a number of bytes."""
    video: ClassVar[bool] = False
    """Whether it is compressed so well that large pictures are usual."""
    moving: ClassVar[bool] = True
    """Whether it shows more than one frame."""

    @abstractmethod
    def write(self, job: FilmJob, target: Path) -> Film:
        """Write a film; it appears under its name when it is whole, and until then what was there stays.

        Raises:
            OSError: the file cannot be written.
        """

    @classmethod
    def written(cls, job: FilmJob, target: Path) -> Film:
        """The film that was written, if it shows the whole job."""
        return Film(target, target.stat().st_size, job.renderer.size, job.count(), job.rate)

    @staticmethod
    @abstractmethod
    def provenance(path: Path) -> str | None:
        """The provenance record in a file; None if there is none.

        Raises:
            OSError, ValueError: the file cannot be read.
        """


def delays(count: int, rate: float, ticks: int) -> list[int]:
    """How long each of `count` frames is shown, in units of 1/ticks s, none of them late by more than half a unit."""
    ends = [math.floor(ticks * (index + 1) / rate + 0.5) for index in range(count)]
    return [end - start for start, end in zip([0, *ends], ends, strict=False)]
