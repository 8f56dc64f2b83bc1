"""Symptom "large": the GIF of a recording would exceed common size limits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from physcore.checks import IntArray
from physcore.numerics.choices import FRAMES_PER_SECOND
from physcore.simulation.recording import Recording
from physcore.studies.diagnosis.case import Case
from physcore.studies.diagnosis.finding import Finding

LARGEST_FILM = 10e6
"""Largest size of an image on GitHub and Discord [bytes]."""
SAMPLES = 6
"""Number of places in the film that are sampled."""


def large(case: Case) -> Iterator[Finding]:
    """Estimate the size of the default film from a few frames."""
    if case.recording is None or "positions" not in case.recording.channels:
        return
    size = film_bytes(case.recording)
    if size > LARGEST_FILM:
        cause = (
            f"its GIF of {len(case.recording)} frames takes up to {size / 1e6:.0f} MB, and GitHub and Discord take 10"
        )
        cure = "film it with max_bytes=10_000_000, or record fewer frames per second, or write a .webp or .mp4"
        yield Finding("large", cause, cure, float(size))


def film_bytes(recording: Recording) -> int:
    """Upper estimate of the size of a recording's default GIF [bytes].

    The estimate is the size of a single frame plus that of the changes between frames, from samples of frames and of
    pairs of frames. Approximated colors, which films above 3 MB have, reduce it by a fifth to a half.
    """
    count = len(recording)
    if count <= 4 * SAMPLES:
        return _gif(recording, np.arange(count))
    first = np.linspace(0, count - 2, SAMPLES).astype(np.int64)
    alone = _gif(recording, first)
    both = _gif(recording, np.stack([first, first + 1], axis=1).ravel())
    return round(alone / SAMPLES + (count - 1) * max(both - alone, 0) / SAMPLES)


def _gif(recording: Recording, frames: IntArray) -> int:
    """The size of the GIF of some frames [bytes]."""
    from physcore.film.filming import gif_bytes

    some = replace(
        recording,
        fps=FRAMES_PER_SECOND,
        times=np.arange(len(frames)) / FRAMES_PER_SECOND,
        channels={name: values[frames] for name, values in recording.channels.items()},
    )
    return len(gif_bytes(some))
