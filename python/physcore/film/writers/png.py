"""PNG: the last frame."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import ClassVar

from physcore.film.writers.base import Reel, Writer
from physcore.storage import replacing

KEYWORD = "physcore"
"""Under which the evidence stands."""


def text_of(path: Path) -> str | None:
    """The text under the keyword."""
    from PIL import Image

    with Image.open(path) as image:
        text = image.info.get(KEYWORD)
    return None if text is None else str(text)


class PngWriter(Writer):
    """A still picture."""

    suffixes: ClassVar = (".png",)
    name: ClassVar = "a PNG"

    def write(self, reel: Reel, target: Path) -> None:
        """Write the last frame."""
        from PIL import Image
        from PIL.PngImagePlugin import PngInfo

        texts = PngInfo()
        texts.add_text(KEYWORD, reel.evidence)
        last = deque(reel.frames(), maxlen=1)[0]
        with replacing(target) as file:
            Image.fromarray(last.pixels()).save(file, format="PNG", pnginfo=texts)

    evidence = staticmethod(text_of)
