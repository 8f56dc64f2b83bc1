"""Animated WebP: small files of high quality; Pillow compresses each frame by itself.

Pillow's own way to write one holds all frames until the last is there, and merges those that are like the one before.
Source: J. Zern et al., "WebP Image Format", RFC 9649, 2024, section 2.7.
"""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from physcore.film.pictures import opened
from physcore.film.writers.base import Film, FilmJob, Writer
from physcore.film.writers.patches import Patch, patches
from physcore.storage.files import replacing

TICKS = 1000
"""Delays are milliseconds."""
QUALITY = 90
"""Of 100. A film takes 0.4 to 0.9 of a GIF's bytes, and thin lines lose a little of their color; without loss it would
take twice a GIF's, and that is what APNG is for."""
ANIMATED, DESCRIBED = 0x02, 0x08
"""Flags of a film: several frames, and EXIF."""
REPLACE = b"\x02"
"""A frame takes the place of what is there, and stays."""
DESCRIPTION = 0x010E
"""The EXIF tag that holds the provenance: ImageDescription."""


class WebpWriter(Writer):
    """All colors, in fewer bytes than a GIF; all browsers show it."""

    suffixes: ClassVar = (".webp",)
    name: ClassVar = "a WebP"
    fastest: ClassVar = 90.0  # Browsers slow delays of 10 ms and less down to 100 ms.
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
                    file.write(_chunk(b"ANIM", struct.pack("<IH", 0, 0)))  # for ever
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
        """The description in the EXIF data."""
        with opened(path) as image:
            text = image.getexif().get(DESCRIPTION)
        return None if text is None else str(text)


def _frame(patch: Patch, delay: int) -> bytes:
    """A frame with its place and its time."""
    height, width, _ = patch.pixels.shape
    place = (patch.left // 2, patch.top // 2, width - 1, height - 1, delay)
    return b"".join(map(_short, place)) + REPLACE + _compressed(patch.pixels)


def _compressed(pixels: NDArray[np.uint8]) -> bytes:
    """The chunk with the compressed pixels, out of the WebP that Pillow makes of them."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="WEBP", quality=QUALITY, method=2)
    return buffer.getvalue()[12:]  # Without opacity it is one chunk behind the file's own head.


def _chunk(kind: bytes, content: bytes) -> bytes:
    """A piece with its length, which is made even."""
    return kind + struct.pack("<I", len(content)) + content + b"\0" * (len(content) % 2)


def _short(value: int) -> bytes:
    """A number in 24 bits."""
    return value.to_bytes(3, "little")
