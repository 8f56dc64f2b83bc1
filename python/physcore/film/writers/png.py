"""Writer of PNG: the last frame."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import ClassVar

from physcore.film.writers.base import Film, FilmJob, Writer
from physcore.storage.files import replacing

KEYWORD = "physcore"
"""Keyword of the provenance."""


def text_of(path: Path) -> str | None:
    """The text under the keyword of a PNG or APNG file, found without decoding frames as Pillow would.

    Source: W3C, "Portable Network Graphics (PNG) Specification", third edition, 2025: chunks.
    """
    with path.open("rb") as file:
        if file.read(8) != b"\x89PNG\r\n\x1a\n":
            raise ValueError("is no PNG")
        while len(head := file.read(8)) == 8:
            size, kind = int.from_bytes(head[:4]), head[4:]
            if kind == b"tEXt":
                keyword, _, text = file.read(size).partition(b"\0")
                if keyword == KEYWORD.encode():
                    return text.decode("latin-1")
                size = 0
            file.seek(size + 4, 1)
    return None


class PngWriter(Writer):
    """Still picture of the last frame."""

    suffixes: ClassVar = (".png",)
    name: ClassVar = "a PNG"
    moving: ClassVar = False

    def write(self, job: FilmJob, target: Path) -> Film:
        """Write the last frame."""
        from PIL import Image
        from PIL.PngImagePlugin import PngInfo

        last = deque(job.frames(), maxlen=1)[0]
        texts = PngInfo()
        texts.add_text(KEYWORD, job.provenance)
        with replacing(target) as file:
            Image.fromarray(last.pixels()).save(file, format="PNG", pnginfo=texts)
        return Film(target, target.stat().st_size, job.renderer.size, 1, job.rate)

    provenance = staticmethod(text_of)
