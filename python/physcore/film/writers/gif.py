"""GIF: a palette for the whole film, chosen from some of its frames, and of each frame what has changed."""

from __future__ import annotations

import os
from contextlib import ExitStack, closing
from math import ceil
from pathlib import Path
from typing import BinaryIO, ClassVar

from physcore._core import Gif
from physcore.film.writers.base import Film, FilmJob, Writer, delays
from physcore.film.writers.budget import Cut
from physcore.storage.files import held, replacing

TICKS = 100
"""Delays are hundredths of a second."""
LOOK = 8
"""After so many frames it is looked whether they are too large already."""
SMALL = 4096
"""More than the bytes of the header, the palette and the ends of blocks."""


class GifWriter(Writer):
    """The format that moves wherever a picture can be shown, in 255 colors."""

    suffixes: ClassVar = (".gif",)
    name: ClassVar = "a GIF"
    fastest: ClassVar = 50.0  # Most viewers slow shorter delays down to 100 ms.
    longest: ClassVar = 65535 / TICKS

    budgeted: ClassVar = True

    def write(self, job: FilmJob, target: Path) -> Film:
        """Write a film, as often as it takes to find what fits into the bytes that are allowed."""
        cut, whole = Cut(), job.renderer.size
        while True:
            try:
                _write_file(job, target, cut)
            except TooLargeError as error:
                cut = cut.deeper(error.excess, job.rate, error.limit)
                job.renderer.resize(cut.size(whole))
            else:
                frames = ceil(job.renderer.count / cut.stride)
                size, rate = target.stat().st_size, job.rate / cut.stride
                return Film(target, size, job.renderer.size, frames, rate, cut.colors)

    @staticmethod
    def content(job: FilmJob) -> bytes:
        """The bytes of a film, without a file."""
        return _write(job, None, Cut()) or b""

    @staticmethod
    def provenance(path: Path) -> str | None:
        """The last comment. Source: CompuServe, "Graphics Interchange Format, Version 89a", 1990."""
        comment = None
        with path.open("rb") as file:
            if file.read(6) != b"GIF89a":
                raise ValueError("is no GIF")
            _skip_colors(file, file.read(7)[4])
            while (kind := file.read(1)) != b";":
                if kind == b"!":
                    label, content = file.read(1), _blocks(file)
                    comment = content.decode() if label == b"\xfe" else comment
                elif kind == b",":
                    _skip_colors(file, file.read(9)[8])
                    file.seek(1, 1)
                    _blocks(file)
                else:
                    raise ValueError("is damaged or cut short")
        return comment


class TooLargeError(Exception):
    """A film will take more bytes than it may."""

    def __init__(self, limit: int, excess: float) -> None:
        super().__init__(limit, excess)
        self.limit = limit
        self.excess = excess
        """How many times more, as far as can be told."""


def _write_file(job: FilmJob, target: Path, cut: Cut) -> None:
    """Write what is left of all frames under a temporary name first, which is locked as long as it is there.

    Raises:
        TooLargeError: they are too many; nothing was written.
    """
    with ExitStack() as until_replaced, replacing(target) as file:
        part = Path(f"{file.name}.part")
        try:
            _write(job, part, cut)
            until_replaced.enter_context(held(part))
            os.replace(part, file.name)
        finally:
            part.unlink(missing_ok=True)


def _write(job: FilmJob, target: Path | None, cut: Cut) -> bytes | None:
    """Write what is left of all frames, and give their bytes if there is no file to put them into.

    Raises:
        TooLargeError: they are too many; nothing was written.
    """
    renderer, limit = job.renderer, job.max_bytes
    times = delays(ceil(renderer.count / cut.stride), job.rate / cut.stride, TICKS)
    with closing(Gif(target, renderer.reserved, quality=job.quality, colors=cut.colors)) as gif:
        for canvas in renderer.samples():
            gif.observe(canvas)
        for index, (canvas, delay) in enumerate(zip(job.frames(cut.stride), times, strict=True)):
            gif.frame(canvas, delay)
            if limit is not None and (index % LOOK == LOOK - 1 or index == len(times) - 1):
                _refuse_if_too_large(gif.written(), limit, (index + 1) / len(times))
        provenance = job.provenance
        if limit is not None:
            _refuse_if_too_large(gif.written() + len(provenance) + SMALL, limit, 1.0)
        gif.comment(provenance)
        return gif.finish()


def _refuse_if_too_large(written: int, limit: int, done: float) -> None:
    """Stop where what is done shows that the whole will not fit."""
    if written > limit:
        raise TooLargeError(limit, written / done / limit)


def _skip_colors(file: BinaryIO, packed: int) -> None:
    """Go past a table of colors, if there is one."""
    if packed & 0x80:
        file.seek(3 << (packed % 8 + 1), 1)


def _blocks(file: BinaryIO) -> bytes:
    """A run of blocks, each after its size, up to one of size zero."""
    parts = []
    while size := ord(file.read(1)):
        parts.append(file.read(size))
    return b"".join(parts)
