"""Writer of GIF: a palette chosen from samples of the film; each frame contains the pixels that have changed."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from typing import BinaryIO, ClassVar

from physcore._core import Gif
from physcore.film.writers.base import Film, FilmJob, Writer
from physcore.film.writers.budget import Cut, Search
from physcore.storage.files import held, replacing

TICKS = 100
"""Unit of delays: 1/100 s."""
LOOK = 8
"""Number of frames between two checks of the size."""
SMALL = 4096
"""Upper bound of the sizes of the header, the palette and the ends of blocks [bytes]."""


class GifWriter(Writer):
    """Animation of 255 colors that every program shows."""

    suffixes: ClassVar = (".gif",)
    name: ClassVar = "a GIF"
    fastest: ClassVar = 50.0  # Most viewers replace shorter delays by 100 ms.
    longest: ClassVar = 65535 / TICKS

    budgeted: ClassVar = True

    def write(self, job: FilmJob, target: Path) -> Film:
        """Write a film, repeatedly until it fits into the allowed bytes and uses them."""
        whole = job.renderer.size

        def attempt(cut: Cut, limit: int | None) -> int:
            _write_file(job, target, cut, limit)
            return target.stat().st_size

        cut = _fit(job, attempt)
        size, rate = cut.size(whole) if cut.scale < 1.0 else whole, job.rate / cut.stride
        return Film(target, target.stat().st_size, size, job.count(cut.stride), rate, cut.colors)

    @staticmethod
    def content(job: FilmJob, cut: Cut | None = None) -> bytes:
        """The bytes of a film, without a file; with a given reduction, or the one that fits."""
        if cut is not None:
            return _write(job, None, cut, None) or b""
        contents: list[bytes] = []

        def attempt(cut: Cut, limit: int | None) -> int:
            contents[:] = [_write(job, None, cut, limit) or b""]
            return len(contents[0])

        _fit(job, attempt)
        return contents[0]

    @staticmethod
    def provenance(path: Path) -> str | None:
        """The last comment of a GIF. Source: CompuServe, "Graphics Interchange Format, Version 89a", 1990."""
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
    """Film that exceeds its limit."""

    def __init__(self, limit: int, excess: float) -> None:
        super().__init__(limit, excess)
        self.limit = limit
        self.excess = excess
        """Estimated ratio of the size to the limit."""


def _fit(job: FilmJob, write: Callable[[Cut, int | None], int]) -> Cut:
    """Write a film repeatedly, until it fits into its limit and uses it. Returns the reduction of the final film.

    Raises:
        SceneError: the film cannot be made to fit.
    """
    search, whole = Search(job.rate, job.max_bytes), job.renderer.size
    going = True
    while going:
        size = search.cut.size(whole) if search.cut.scale < 1.0 else whole
        if size != job.renderer.size:
            job.renderer.resize(size)
        try:
            written = write(search.cut, search.limit)
        except TooLargeError as error:
            going = search.too_large(error.excess)
        else:
            going = search.fitted(written)
    assert search.fits is not None  # the loop ends only after a film has fitted
    return search.fits


def _write_file(job: FilmJob, target: Path, cut: Cut, limit: int | None) -> None:
    """Write the frames of a reduced film into a temporary file, which is locked, and rename it at the end.

    Raises:
        TooLargeError: the film is too large; nothing was written.
    """
    with ExitStack() as until_replaced, replacing(target) as file:
        part = Path(f"{file.name}.part")
        try:
            _write(job, part, cut, limit)
            until_replaced.enter_context(held(part))
            os.replace(part, file.name)
        finally:
            part.unlink(missing_ok=True)


def _write(job: FilmJob, target: Path | None, cut: Cut, limit: int | None) -> bytes | None:
    """Write the frames of a reduced film into a file; without one, return the bytes.

    Raises:
        TooLargeError: the film is too large; nothing was written.
    """
    renderer, times = job.renderer, job.delays(TICKS, cut.stride)
    with closing(Gif(target, renderer.reserved, colors=cut.colors)) as gif:
        for canvas in renderer.samples():
            gif.observe(canvas)
        gif.include(renderer.colors)
        gif.tolerate(cut.tolerance)
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
    """Raise TooLargeError if the part written so far exceeds the limit."""
    if written > limit:
        raise TooLargeError(limit, written / done / limit)


def _skip_colors(file: BinaryIO, packed: int) -> None:
    """Skip a color table, if there is one."""
    if packed & 0x80:
        file.seek(3 << (packed % 8 + 1), 1)


def _blocks(file: BinaryIO) -> bytes:
    """The contents of a sequence of data blocks, each preceded by its size, up to one of size zero."""
    parts = []
    while size := ord(file.read(1)):
        parts.append(file.read(size))
    return b"".join(parts)
