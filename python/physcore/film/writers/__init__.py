"""Formats of films, one module each. To add one: a module here and a line in WRITERS."""

from __future__ import annotations

from physcore.film.writers.apng import ApngWriter
from physcore.film.writers.base import Film, FilmJob, Writer, delays
from physcore.film.writers.gif import GifWriter
from physcore.film.writers.loops import Loop, check_loop
from physcore.film.writers.mp4 import Mp4Writer
from physcore.film.writers.page import PageWriter
from physcore.film.writers.png import PngWriter
from physcore.film.writers.webp import WebpWriter

WRITERS: tuple[type[Writer], ...] = (GifWriter, WebpWriter, ApngWriter, Mp4Writer, PageWriter, PngWriter)
"""All formats of films."""

__all__ = ["WRITERS", "Film", "FilmJob", "GifWriter", "Loop", "Writer", "check_loop", "delays"]
