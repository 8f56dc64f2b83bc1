"""The last seconds of a panel as pictures, which a GIF is made of."""

from __future__ import annotations

import json
import threading
from collections import deque
from contextlib import closing

import numpy as np
from numpy.typing import NDArray

from physcore._core import Canvas, Gif
from physcore.errors import SceneError
from physcore.film.writers.base import delays
from physcore.film.writers.budget import TOLERANCE
from physcore.scene.scene import Scene
from physcore.simulation.provenance_record import record_of

SECONDS = 6.0
"""Length of the film [s]."""
RATE = 20.0
"""Largest number of pictures per second."""
BYTES = 220_000_000
"""Largest memory of the pictures [bytes]."""
SAMPLES = 8
"""Number of pictures from which the palette is chosen."""
TICKS = 100
"""Unit of a GIF's delays: 1/100 s."""


class Reel:
    """The pictures of the last seconds in which something was drawn."""

    def __init__(self) -> None:
        self._pictures: deque[tuple[float, NDArray[np.uint8]]] = deque()
        self._lock = threading.Lock()

    def add(self, clock: float, pixels: NDArray[np.uint8]) -> None:
        """Add a picture that was drawn at a time of the clock [s], if the last one is old enough."""
        with self._lock:
            kept = self._pictures
            if kept and kept[-1][1].shape != pixels.shape:
                kept.clear()
            if kept and clock - kept[-1][0] < 0.9 / RATE:
                return
            kept.append((clock, pixels))
            while len(kept) > SECONDS * RATE or len(kept) * pixels.nbytes > BYTES:
                kept.popleft()

    def gif(self, scene: Scene) -> bytes:
        """The bytes of a GIF of the pictures, at the speed at which they were seen.

        Raises:
            SceneError: there are no pictures.
        """
        with self._lock:
            times, pictures = [time for time, _ in self._pictures], [pixels for _, pixels in self._pictures]
        if not pictures:
            raise SceneError("save: nothing was drawn yet: open the page, and let it play")
        # Pauses, in which nothing was drawn, are left out.
        gaps = np.minimum(np.diff(times), 2.0 / RATE)
        rate = 1.0 / float(gaps.mean()) if len(gaps) else RATE
        height, width = pictures[0].shape[:2]
        canvas = Canvas(width, height, (0, 0, 0), 1)
        with closing(Gif(None, [])) as gif:
            for pixels in pictures[:: max(1, len(pictures) // SAMPLES)]:
                canvas.picture(pixels, 0, 0)
                gif.observe(canvas)
            gif.tolerate(TOLERANCE)
            for pixels, delay in zip(pictures, delays(len(pictures), rate, TICKS), strict=True):
                canvas.picture(pixels, 0, 0)
                gif.frame(canvas, delay)
            record = {name: value for name, value in record_of(scene, None, None).items() if name != "machine"}
            gif.comment(json.dumps([record], allow_nan=False, separators=(",", ":")))
            content = gif.finish()
        assert content is not None  # It was written into memory.
        return content
