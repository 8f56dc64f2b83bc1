"""Transitions from the end of a film to its start: none, backward playback, or a crossfade."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from physcore._core import Canvas
from physcore.checks import span, word
from physcore.errors import SceneError

Loop = Literal["bounce", "crossfade"]
BLEND = 0.5
"""Duration of a crossfade [s]."""
PART = 1 / 3
"""Largest fraction of a short film that a crossfade takes."""


@dataclass(frozen=True)
class Repeat:
    """Transition from the end of a film to its start."""

    loop: Loop | None = None
    hold: float = 0.0
    """Additional duration of the last drawn frame [s]."""

    def count(self, drawn: int, rate: float) -> int:
        """The number of frames of the film, from the number of drawn frames and the frame rate."""
        if self.loop == "bounce":
            return max(2 * drawn - 2, 1)
        return drawn - self._blended(drawn, rate) if self.loop == "crossfade" else drawn

    def frames(self, drawn: Iterator[Canvas], count: int, rate: float) -> Iterator[Canvas]:
        """The frames of the film; each canvas is valid until the next is requested."""
        if self.loop == "bounce":
            return _bounced(drawn)
        return _crossfaded(drawn, count, self._blended(count, rate)) if self.loop == "crossfade" else drawn

    @staticmethod
    def _blended(drawn: int, rate: float) -> int:
        """The number of frames of a crossfade."""
        return min(math.ceil(BLEND * rate), math.floor(PART * drawn))


def check_loop(loop: object, hold: object, name: str, longest: float, *, moving: bool, blends: bool = True) -> Repeat:
    """The requested transition.

    Args:
        loop, hold: as in `film`.
        name: the name of the format in a sentence.
        longest: longest delay of a frame in this format [s].
        moving: whether the format has more than one frame.
        blends: whether it can blend two frames.

    Raises:
        SceneError: there is no such loop, or the format does not support it.
    """
    chosen = None if loop is None else word(loop, "loop", get_args(Loop))
    seconds = span(hold, "hold", empty=True)
    if not moving:  # a still picture has no duration
        if chosen is not None:
            raise SceneError(f"loop: needs more than one frame, and {name} has only the last; leave it out")
        return Repeat()
    if chosen == "crossfade" and not blends:
        raise SceneError(f"loop: {name} cannot blend the end into the start; give 'bounce', or leave it out")
    if seconds > longest / 2:
        raise SceneError(f"hold: must be at most {longest / 2:.0f} s in {name}, got {seconds:g}")
    if chosen == "crossfade" and seconds > 0.0:
        raise SceneError("hold: a crossfade has no last frame to hold; give one of the two")
    return Repeat(chosen, seconds)


def _bounced(drawn: Iterator[Canvas]) -> Iterator[Canvas]:
    """The frames forward and backward; the frames are kept in a temporary file."""
    with tempfile.TemporaryFile(prefix="physcore-") as file:
        count, shape = 0, (0, 0, 0)
        for canvas in drawn:
            pixels = canvas.pixels()
            file.write(np.ascontiguousarray(pixels).data)
            count, shape = count + 1, pixels.shape
            yield canvas
        again, size = Canvas(shape[1], shape[0], (0, 0, 0)), math.prod(shape)
        for index in range(count - 2, 0, -1):
            file.seek(index * size)
            again.picture(np.frombuffer(file.read(size), dtype=np.uint8).reshape(shape), 0, 0)
            yield again


def _crossfaded(drawn: Iterator[Canvas], count: int, blended: int) -> Iterator[Canvas]:
    """The frames from the end of the blend on. The last ones are blended with the first ones, which alone are in
    memory.
    """
    start: list[NDArray[np.uint8]] = []
    for index, canvas in enumerate(drawn):
        if index < blended:
            start.append(canvas.pixels())
        elif index < count - blended:
            yield canvas
        else:
            place = index - (count - blended)
            pixels, weight = canvas.pixels(), (place + 1) / (blended + 1)
            mixture = np.rint((1.0 - weight) * pixels + weight * start[place]).astype(np.uint8)
            result = Canvas(pixels.shape[1], pixels.shape[0], (0, 0, 0))
            result.picture(mixture, 0, 0)
            yield result
