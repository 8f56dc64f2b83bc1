"""Display of recordings and films in notebooks, as pictures of bounded size."""

from __future__ import annotations

from dataclasses import replace
from html import escape
from weakref import WeakKeyDictionary

import numpy as np

from physcore.film.filming import gif_bytes
from physcore.markup import inline_image
from physcore.simulation.recording import Recording

SIDE = 480
"""Longest side of a preview [pixels]."""
BYTES = 2_000_000
"""Largest size of a preview [bytes]."""
MOST = 150
"""Largest number of frames of a preview."""
SLOWEST, FASTEST = 10.0, 25.0
"""Least and largest frame rate of a preview [1/s]. A recording with fewer frames per second, such as of planets, plays
faster than real time.
"""
_previews: WeakKeyDictionary[Recording, str | None] = WeakKeyDictionary()
"""Cache of the previews, because a notebook requests them repeatedly."""
_films: WeakKeyDictionary[Recording, str] = WeakKeyDictionary()
"""Cache of the whole films that were shown."""


def html(recording: Recording) -> str | None:
    """A small film, with a note on the frames left out; None if there is nothing to draw."""
    if recording not in _previews:
        _previews[recording] = _preview(recording)
    return _previews[recording]


def full_html(recording: Recording) -> str:
    """The whole recording as drawn by `physcore.film`, of any size."""
    if recording not in _films:
        rate = min(max(recording.fps, SLOWEST), 50.0)
        content = gif_bytes(recording, speed=rate / recording.fps)
        _films[recording] = inline_image(content, "gif", repr(recording))
    return _films[recording]


def _preview(recording: Recording) -> str | None:
    if "positions" not in recording.channels:
        return None
    count = len(recording)
    stride = max(-(-count // MOST), round(recording.fps / FASTEST), 1)
    chosen = np.arange(0, count, stride)
    some = replace(
        recording,
        times=recording.times[chosen],
        fps=recording.fps / stride,
        channels={name: values[chosen] for name, values in recording.channels.items()},
    )
    rate = min(max(some.fps, SLOWEST), FASTEST)
    content = gif_bytes(some, size=_size(some), speed=rate / some.fps, max_bytes=BYTES)
    duration, shown = float(recording.times[-1] - recording.times[0]), len(chosen) / rate
    left_out = f"every {stride}th of {count} frames" if stride > 1 else f"{count} frames"
    unit = recording.units.suffix("s")
    pace = "" if abs(some.fps / rate - 1.0) < 0.01 else f", {duration:.4g}{unit} in {shown:.3g} s"
    caption = f'{left_out}{pace}; in full: recording.show(), or recording.film("run.gif")'
    return inline_image(content, "gif", repr(recording)) + f"<div><small>{escape(caption)}</small></div>"


def _size(recording: Recording) -> tuple[int, int]:
    """The size that `film` would choose, scaled down to SIDE."""
    from physcore.film.colors.themes import resolve
    from physcore.film.film_renderer import FilmRenderer
    from physcore.simulation.sources import sources

    with FilmRenderer(sources(recording, None, None, {}), None, None, None, resolve("dark"), None, False) as renderer:
        width, height = renderer.size
    scale = min(SIDE / max(width, height), 1.0)
    return 2 * round(scale * width / 2), 2 * round(scale * height / 2)
