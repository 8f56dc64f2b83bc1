"""How a notebook shows recordings and films: as pictures of a bounded size."""

from __future__ import annotations

from dataclasses import replace
from html import escape
from weakref import WeakKeyDictionary

import numpy as np

from physcore.film.filming import gif_bytes
from physcore.markup import inline_image
from physcore.simulation.recording import Recording

SIDE = 480
"""The longer side of a preview is at most this [pixels]."""
BYTES = 2_000_000
"""A preview has at most so many."""
MOST = 150
"""A preview has at most so many frames."""
SLOWEST, FASTEST = 10.0, 25.0
"""Frames per second of a preview; a recording with fewer, such as of a planet, plays faster than real time."""
_previews: WeakKeyDictionary[Recording, str | None] = WeakKeyDictionary()
"""Those that were made: a notebook asks for them again and again."""


def html(recording: Recording) -> str | None:
    """A small film, with a word on what it leaves out. None without anything to draw."""
    if recording not in _previews:
        _previews[recording] = _preview(recording)
    return _previews[recording]


def full_html(recording: Recording) -> str:
    """The whole recording, as `physcore.film` draws it, however large that is."""
    rate = min(max(recording.fps, SLOWEST), 50.0)
    return inline_image(gif_bytes(recording, speed=rate / recording.fps), "gif", repr(recording))


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
    pace = "" if abs(some.fps / rate - 1.0) < 0.01 else f", {duration:.4g} s in {shown:.3g} s"
    caption = f'{left_out}{pace}; in full: recording.show(), or recording.film("run.gif")'
    return inline_image(content, "gif", repr(recording)) + f"<div><small>{escape(caption)}</small></div>"


def _size(recording: Recording) -> tuple[int, int]:
    """The size in which `film` would draw it, made small enough."""
    from physcore.film.colors.themes import resolve
    from physcore.film.renderer import Renderer
    from physcore.simulation.sources import sources

    with Renderer(sources(recording, None, None, {}), None, None, None, resolve("dark"), None, False) as renderer:
        width, height = renderer.size
    scale = min(SIDE / max(width, height), 1.0)
    return 2 * round(scale * width / 2), 2 * round(scale * height / 2)
