"""Writer of animated WebP: small files of high quality. Pillow compresses each frame separately.

Pillow's own writer holds all frames in memory, and merges equal successive frames.

Source: J. Zern et al., "WebP Image Format", RFC 9649, 2024, section 2.7.
"""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physcore.film.writers.base import Film, FilmJob, Writer
from physcore.film.writers.patches import Patch, patches
from physcore.storage.files import replacing
from physcore.storage.pictures import opened

TICKS = 1000
"""Unit of delays: 1/1000 s."""
QUALITY = 90
"""Quality of the compression, 0 to 100. At 90, a film has 0.4 to 0.9 of a GIF's size, and thin lines lose a little
color. Lossless WebP would have twice a GIF's size; APNG serves that purpose.
"""
ANIMATED, DESCRIBED = 0x02, 0x08
"""Flags of the file: several frames, and EXIF data."""
REPLACE = b"\x02"
"""Flags of a frame: it replaces the pixels below it, and remains."""
DESCRIPTION = 0x010E
"""The EXIF tag that holds the provenance: ImageDescription."""


class WebpWriter(Writer):
    """Animation of all colors, smaller than a GIF; all browsers show it."""

    suffixes: ClassVar = (".webp",)
    name: ClassVar = "a WebP"
    fastest: ClassVar = 90.0  # Browsers replace delays of 10 ms and less by 100 ms.
    longest: ClassVar = (2**24 - 1) / TICKS

    def write(self, job: FilmJob, target: Path) -> Film:
        """Write a film."""
        from PIL import Image

        with replacing(target) as file:
            file.write(b"RIFF\0\0\0\0WEBP")
            shown = zip(patches(job.frames()), job.delays(TICKS), strict=True)
            for index, (patch, delay) in enumerate(shown):
                if index == 0:
                    height, width, _ = patch.pixels.shape
                    features = bytes([ANIMATED | DESCRIBED, 0, 0, 0])
                    file.write(_chunk(b"VP8X", features + _short(width - 1) + _short(height - 1)))
                    file.write(_chunk(b"ANIM", struct.pack("<IH", 0, 0)))  # 0 repetitions: endless
                file.write(_chunk(b"ANMF", _frame(patch, delay)))
            exif = Image.Exif()
            exif[DESCRIPTION] = job.provenance
            file.write(_chunk(b"EXIF", exif.tobytes().removeprefix(b"Exif\0\0")))
            size = file.tell()
            file.seek(4)
            file.write(struct.pack("<I", size - 8))
        return self.written(job, target)

    @staticmethod
    def provenance(path: Path) -> str | None:
        """The description in the EXIF data of a film."""
        with opened(path) as image:
            text = image.getexif().get(DESCRIPTION)
        return None if text is None else str(text)


def _frame(patch: Patch, delay: int) -> bytes:
    """A frame with its position and its delay."""
    height, width, _ = patch.pixels.shape
    place = (patch.left // 2, patch.top // 2, width - 1, height - 1, delay)
    return b"".join(map(_short, place)) + REPLACE + _compressed(patch.pixels)


def _compressed(pixels: NDArray[np.uint8]) -> bytes:
    """The chunk of the compressed pixels, taken from the WebP written by Pillow."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="WEBP", quality=QUALITY, method=2)
    return buffer.getvalue()[12:]  # Without an alpha channel, the file has one chunk after its header of 12 bytes.


def _chunk(kind: bytes, content: bytes) -> bytes:
    """A chunk with its length, padded to even length."""
    return kind + struct.pack("<I", len(content)) + content + b"\0" * (len(content) % 2)


def _short(value: int) -> bytes:
    """A number as 24 bits, little-endian."""
    return value.to_bytes(3, "little")
