"""Base class of writers, the job given to a writer, and the delays of frames."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import ClassVar

from physcore._core import Canvas
from physcore.checks import span
from physcore.errors import SceneError, SceneWarning, warn
from physcore.film.film_renderer import FilmRenderer
from physcore.film.writers.loops import Repeat
from physcore.markup import inline_image, inline_page, inline_video
from physcore.progress import Progress
from physcore.storage.formats import Format
from physcore.units.systems import SI, UnitSystem

KINDS = {".gif": "gif", ".webp": "webp", ".apng": "apng", ".png": "png"}
"""Suffixes of films that a page shows as images, with their types; others are videos in MP4."""
PAGE = ".html"
"""Suffix of pages."""
LONG = 2.0
"""Duration of a frame from which on a film in real time is warned of [s]."""

INLINE = 3_000_000
"""Largest size of a film that is embedded in a notebook [bytes]."""


@dataclass(frozen=True)
class Film:
    """Written film."""

    path: Path
    """The path of its file."""
    bytes: int
    """Size of the file [bytes]."""
    size: tuple[int, int]
    """Width and height [pixels]."""
    frames: int
    """Number of frames."""
    rate: float
    """Frames per second."""
    colors: int | None = None
    """Largest number of colors; None: all colors."""

    def __repr__(self) -> str:
        moving = f", {self.frames} frames, {self.rate:.4g} per second" if self.frames > 1 else ""
        colors = "" if self.colors is None else f", {self.colors} colors"
        return f"{self.path}: {self.size[0]}×{self.size[1]}{moving}{colors}, {self.bytes / 1e6:.2f} MB"

    def _repr_html_(self) -> str:
        """HTML for notebooks: a description, and the film itself if it exists and has at most 3 MB."""
        words = f"<div>{escape(repr(self))}</div>"
        suffix = self.path.suffix.lower()
        kind = KINDS.get(suffix)
        if self.bytes > INLINE:
            return f'<a href="{escape(str(self.path))}">{words}</a>'
        try:
            content = self.path.read_bytes()
        except OSError:
            return words
        if suffix == PAGE:
            return inline_page(content.decode(), repr(self)) + words
        return (inline_video(content, repr(self)) if kind is None else inline_image(content, kind, repr(self))) + words


@dataclass(frozen=True, eq=False)
class FilmJob:
    """Job of a writer: a film whose frames are drawn one at a time."""

    renderer: FilmRenderer
    """The renderer of its frames."""
    rate: float
    """Frames per second."""
    max_bytes: int | None
    """Largest size of the file [bytes], for formats that can be made smaller."""
    describe: Callable[[], str]
    """Gives the provenance record as JSON in ASCII. Call it at the end: a scene that was not simulated yet is simulated
    then.
    """
    progress: bool | None
    """Whether to show a progress bar, as in `film`."""
    repeat: Repeat = field(default_factory=Repeat)
    """The transition from the end to the start."""

    def count(self, stride: int = 1) -> int:
        """The number of frames of the film, if it shows one of every `stride` frames of the renderer."""
        return self.repeat.count(math.ceil(self.renderer.count / stride), self.rate / stride)

    def delays(self, ticks: int, stride: int = 1) -> list[int]:
        """The delay of each frame, in units of 1/ticks s; accumulated times are off by at most half a unit."""
        result = delays(self.count(stride), self.rate / stride, ticks)
        if result:
            result[self.held(stride)] += round(self.repeat.hold * ticks)
        return result

    def held(self, stride: int = 1) -> int:
        """The index of the frame that is held: the last one drawn."""
        return min(math.ceil(self.renderer.count / stride), self.count(stride)) - 1

    @property
    def provenance(self) -> str:
        """The provenance record, as JSON in ASCII."""
        return self.describe()

    def frames(self, stride: int = 1) -> Iterator[Canvas]:
        """Every frame, or every second, third, …; each canvas is valid until the next is requested."""
        return self.repeat.frames(self._drawn(stride), math.ceil(self.renderer.count / stride), self.rate / stride)

    def _drawn(self, stride: int) -> Iterator[Canvas]:
        """The frames of the renderer."""
        with Progress(self.renderer.count, "drawing", self.progress) as bar:
            for index, canvas in enumerate(self.renderer.frames()):
                if index % stride == 0:
                    yield canvas
                bar.update(index + 1)


class Writer(Format, ABC):
    """Base class of the formats of films."""

    name: ClassVar[str]
    """The name of the format in a sentence."""
    fastest: ClassVar[float] = math.inf
    """Largest frame rate that every viewer supports [1/s]."""
    longest: ClassVar[float] = math.inf
    """Longest delay of a frame [s]."""

    @classmethod
    def rate(cls, fps: float, speed: float | None, units: UnitSystem = SI) -> float:
        """Frame rate of a film that shows `fps` frames per second, or other unit of time of a scene, at a given speed.

        Without a speed, the film plays in real time, or a unit of time in a second. If the format cannot, it plays
        slower, with a warning in real time. Frames that last for seconds are warned of.

        Raises:
            SceneError: the format does not support the frame rate at this speed.
        """
        if speed is None and fps > cls.fastest * (1.0 + 1e-9):
            if units.time.symbol == "s":
                warn(
                    f"{cls.name} shows at most {cls.fastest:g} frames per second, so that this film of {fps:g} plays "
                    f"at {cls.fastest / fps:.2g} of its speed; record {cls.fastest:g} or fewer for real time",
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
        if speed is None and cls.moving and rate * LONG < 1.0:
            warn(
                f"each frame of this film lasts {1.0 / rate:.3g} s, because {fps:.3g} are recorded per "
                f"{units.time.symbol or 'unit of time'}, which takes a second: give it a speed, such as "
                f"speed={30.0 / fps:.3g} for 30 frames per second, or speed=1 if this is meant",
                SceneWarning,
            )
        return rate

    budgeted: ClassVar[bool] = False
    """Whether the film can be made to fit into a number of bytes."""
    video: ClassVar[bool] = False
    """Whether the compression is strong enough for large pictures."""
    moving: ClassVar[bool] = True
    """Whether the format has more than one frame."""
    captioned: ClassVar[bool] = True
    """Whether titles and labels are part of the picture."""
    blends: ClassVar[bool] = True
    """Whether two frames can be blended."""

    @abstractmethod
    def write(self, job: FilmJob, target: Path) -> Film:
        """Write a film. The file appears under its name when it is complete; until then an existing file stays.

        Raises:
            OSError: the file cannot be written.
        """

    @classmethod
    def written(cls, job: FilmJob, target: Path) -> Film:
        """The written film, if it shows the whole job."""
        return Film(target, target.stat().st_size, job.renderer.size, job.count(), job.rate)

    @staticmethod
    @abstractmethod
    def provenance(path: Path) -> str | None:
        """The provenance record in a file; None if there is none.

        Raises:
            OSError, ValueError: the file cannot be read.
        """


def delays(count: int, rate: float, ticks: int) -> list[int]:
    """The delays of `count` frames, in units of 1/ticks s; accumulated times are off by at most half a unit."""
    ends = [math.floor(ticks * (index + 1) / rate + 0.5) for index in range(count)]
    return [end - start for start, end in zip([0, *ends], ends, strict=False)]
