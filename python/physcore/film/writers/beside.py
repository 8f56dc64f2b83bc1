"""Videos beside GIFs, to compare their sizes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from physcore.film.writers.base import Film, FilmJob, Writer
from physcore.film.writers.gif import GifWriter
from physcore.film.writers.mp4 import Mp4Writer
from physcore.film.writers.webp import WebpWriter

_films: ContextVar[list[Film] | None] = ContextVar("_films", default=None)


@contextmanager
def videos_beside() -> Iterator[list[Film]]:
    """Write each GIF of this context as a video of the same name too: an MP4, or a WebP where FFmpeg is missing.

    Yields:
        The films written so far.
    """
    films: list[Film] = []
    token = _films.set(films)
    try:
        yield films
    finally:
        _films.reset(token)


def write_film(writer: Writer, job: FilmJob, target: Path) -> Film:
    """Write a film, and its video where one is asked for."""
    films, size = _films.get(), job.renderer.size
    film = writer.write(job, target)
    if films is not None:
        films.append(film)
        if isinstance(writer, GifWriter):
            if job.renderer.size != size:  # the GIF was made smaller
                job.renderer.resize(size)
            video = WebpWriter() if Mp4Writer.missing() else Mp4Writer()
            films.append(video.write(job, target.with_suffix(video.suffixes[0])))
    return film
