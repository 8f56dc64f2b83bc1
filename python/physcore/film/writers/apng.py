"""Writer of animated PNG, which is lossless. Pillow compresses each frame, and only one frame is in memory.

Pillow's own writer takes no generator, holds all frames in memory, and merges equal successive frames.

Source: W3C, "Portable Network Graphics (PNG) Specification (Third Edition)", 2025, section 11.3.6.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, ClassVar

import numpy as np
from numpy.typing import NDArray

from physcore.film.writers.base import Film, FilmJob, Writer
from physcore.film.writers.patches import patches
from physcore.film.writers.png import KEYWORD, text_of
from physcore.storage.files import replacing

TICKS = 1000
"""Unit of delays: 1/1000 s."""
STAY, REPLACE = 0, 0
"""Disposal and blend operation: a frame remains after its delay, and replaces the pixels below it."""


class ApngWriter(Writer):
    """Lossless animation for viewers of animated PNG: all browsers."""

    suffixes: ClassVar = (".apng",)
    name: ClassVar = "an animated PNG"
    fastest: ClassVar = 90.0  # Browsers replace delays of 10 ms and less by 100 ms.
    longest: ClassVar = 65535 / TICKS

    def write(self, job: FilmJob, target: Path) -> Film:
        """Write a film."""
        count, order = job.count(), 0
        with replacing(target) as file:
            shown = zip(patches(job.frames()), job.delays(TICKS), strict=True)
            for index, (patch, delay) in enumerate(shown):
                height, width, _ = patch.pixels.shape
                header, parts = _compressed(patch.pixels)
                if index == 0:
                    file.write(b"\x89PNG\r\n\x1a\n")
                    _chunk(file, b"IHDR", header)
                    _chunk(file, b"acTL", struct.pack(">II", count, 0))
                place = (order, width, height, patch.left, patch.top, delay, TICKS, STAY, REPLACE)
                _chunk(file, b"fcTL", struct.pack(">IIIIIHHBB", *place))
                order += 1
                for part in parts:
                    if index == 0:
                        _chunk(file, b"IDAT", part)
                    else:
                        _chunk(file, b"fdAT", struct.pack(">I", order) + part)
                        order += 1
            _chunk(file, b"tEXt", KEYWORD.encode() + b"\0" + job.provenance.encode())
            _chunk(file, b"IEND", b"")
        return self.written(job, target)

    provenance = staticmethod(text_of)


def _chunk(file: BinaryIO, kind: bytes, content: bytes) -> None:
    """Write a chunk with its length and its checksum."""
    file.write(struct.pack(">I", len(content)) + kind + content)
    file.write(struct.pack(">I", zlib.crc32(content, zlib.crc32(kind))))


def _compressed(pixels: NDArray[np.uint8]) -> tuple[bytes, Iterator[bytes]]:
    """The header and the compressed pixels of a picture, taken from the PNG written by Pillow."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG")
    chunks = list(_chunks(buffer.getvalue()))
    return chunks[0][1], (content for kind, content in chunks if kind == b"IDAT")


def _chunks(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    place = 8
    while place < len(content):
        length, kind = struct.unpack_from(">I4s", content, place)
        yield kind, content[place + 8 : place + 8 + length]
        place += 12 + length
