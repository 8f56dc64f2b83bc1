"""The formats of films, one file each. To add one: a file here and a line in WRITERS."""

from __future__ import annotations

import os
from pathlib import Path

from physcore.errors import FileError, PhyscoreError, SceneError
from physcore.film.writers.apng import ApngWriter
from physcore.film.writers.base import Reel, Writer, delays
from physcore.film.writers.gif import GifWriter
from physcore.film.writers.mp4 import Mp4Writer
from physcore.film.writers.png import PngWriter
from physcore.film.writers.webp import WebpWriter

WRITERS: tuple[type[Writer], ...] = (GifWriter, WebpWriter, ApngWriter, Mp4Writer, PngWriter)
"""Every format that a film can have."""

__all__ = ["WRITERS", "GifWriter", "Reel", "Writer", "delays", "format_of", "writer_for"]


def format_of(path: str | os.PathLike[str]) -> type[Writer]:
    """The format of a film, by the end of its name.

    Raises:
        SceneError: the name has none of the known endings.
    """
    for kind in WRITERS:
        if Path(path).suffix.lower() == kind.suffix:
            return kind
    known = [kind.suffix for kind in WRITERS]
    raise SceneError(f"path: must end in {', '.join(known[:-1])} or {known[-1]}, got {os.fspath(path)!r}")


def writer_for(path: str | os.PathLike[str]) -> Writer:
    """What writes a film to a path; what can be known to fail is checked before the film is made, which may take long.

    Raises:
        SceneError: the name has none of the known endings.
        FileError: the folder does not exist.
        PhyscoreError: what the format needs is not installed.
    """
    kind, missing = format_of(path), format_of(path).missing()
    if not Path(path).parent.is_dir():
        raise FileError(f"{Path(path)}: cannot be written: no such folder")
    if missing is not None:
        raise PhyscoreError(f"path: {missing}")
    return kind()
