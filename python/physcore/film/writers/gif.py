"""GIF: a palette for the whole film, chosen from some of its frames, and of each frame what has changed."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import BinaryIO, ClassVar

from physcore._core import Gif
from physcore.film.writers.base import Reel, Writer, delays

TICKS = 100
"""Delays are hundredths of a second."""


class GifWriter(Writer):
    """The format that moves wherever a picture can be shown, in 255 colors."""

    suffixes: ClassVar = (".gif",)
    name: ClassVar = "a GIF"
    fastest: ClassVar = 50.0  # Most viewers slow shorter delays down to 100 ms.
    longest: ClassVar = 65535 / TICKS

    def write(self, reel: Reel, target: Path) -> None:
        """Write a film."""
        _write(reel, target)

    @staticmethod
    def content(reel: Reel) -> bytes:
        """The bytes of a film, without a file."""
        return _write(reel, None) or b""

    @staticmethod
    def evidence(path: Path) -> str | None:
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


def _write(reel: Reel, target: Path | None) -> bytes | None:
    """Write all frames, and give their bytes if there is no file to put them into."""
    stage = reel.stage
    with closing(Gif(target, stage.reserved)) as gif:
        for canvas in stage.samples():
            gif.observe(canvas)
        for canvas, delay in zip(reel.frames(), delays(stage.count, reel.rate, TICKS), strict=True):
            gif.frame(canvas, delay)
        gif.comment(reel.evidence)
        return gif.finish()


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
