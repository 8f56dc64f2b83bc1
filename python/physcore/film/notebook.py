"""How a notebook shows a recording: as a film."""

from __future__ import annotations

from physcore.film.filming import gif_bytes
from physcore.simulation.recording import Recording

SLOW = 5.0
"""Frames per second below which a recording is played faster than real time: the orbit of a planet, say."""


def html(recording: Recording) -> str | None:
    """The GIF: in real time, or as close to it as a GIF can be. None without positions."""
    import base64

    from physcore.film.writers.gif import GifWriter

    if "positions" not in recording.channels:
        return None
    rate = min(max(recording.fps, SLOW), GifWriter.fastest)
    content = base64.b64encode(gif_bytes(recording, speed=rate / recording.fps)).decode()
    return f'<img alt="{recording!r}" src="data:image/gif;base64,{content}">'
