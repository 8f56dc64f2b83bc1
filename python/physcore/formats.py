"""Formats of files, chosen by how a name ends; what can be known to fail is checked before the work begins."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, TypeVar

from physcore.errors import FileError, PhyscoreError, SceneError


class Format:
    """A format of files."""

    suffixes: ClassVar[tuple[str, ...]]
    """How the names of its files end."""

    @classmethod
    def missing(cls) -> str | None:
        """What has to be installed first, as a sentence; None if nothing."""
        return None


Kind = TypeVar("Kind", bound=Format)


def format_of(path: str | os.PathLike[str], formats: Sequence[type[Kind]]) -> type[Kind]:
    """The one of some formats that a path asks for.

    Raises:
        SceneError: the name has none of their endings.
    """
    suffix = Path(path).suffix.lower()
    for each in formats:
        if suffix in each.suffixes:
            return each
    known = [suffix for each in formats for suffix in each.suffixes]
    raise SceneError(f"path: must end in {', '.join(known[:-1])} or {known[-1]}, got {os.fspath(path)!r}")


def writable(path: str | os.PathLike[str], formats: Sequence[type[Kind]]) -> Kind:
    """What writes to a path.

    Raises:
        SceneError: the name has none of the known endings.
        FileError: the folder does not exist.
        PhyscoreError: what the format needs is not installed.
    """
    kind = format_of(path, formats)
    if not Path(path).parent.is_dir():
        raise FileError(f"{Path(path)}: cannot be written: no such folder")
    missing = kind.missing()
    if missing is not None:
        raise PhyscoreError(f"path: {missing}")
    return kind()
