"""Formats of files, chosen by how a name ends; what can be known to fail is checked before the work begins."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import ClassVar, TypeVar

from physcore.checks import file_path, shown
from physcore.errors import PhyscoreError, SceneError
from physcore.storage.files import require_writable


class Format:
    """A format of files."""

    suffixes: ClassVar[tuple[str, ...]]
    """How the names of its files end."""

    @classmethod
    def missing(cls) -> str | None:
        """The package that has to be installed first, as a sentence; None if none."""
        return None


Kind = TypeVar("Kind", bound=Format)


def format_of(path: str | os.PathLike[str], formats: Sequence[type[Kind]]) -> type[Kind]:
    """The one of some formats that a path asks for.

    Raises:
        SceneError: the name has none of their endings.
    """
    named = file_path(path)
    suffix = named.suffix.lower()
    for each in formats:
        if suffix in each.suffixes:
            return each
    known = [suffix for each in formats for suffix in each.suffixes]
    raise SceneError(f"path: must end in {', '.join(known[:-1])} or {known[-1]}, got {shown(str(named))}")


def writable(path: str | os.PathLike[str], formats: Sequence[type[Kind]]) -> Kind:
    """The format that writes to a path.

    Raises:
        SceneError: the name has none of the known endings.
        FileError: the file cannot be written.
        PhyscoreError: what the format needs is not installed.
    """
    kind = format_of(path, formats)
    missing = kind.missing()
    if missing is not None:
        raise PhyscoreError(f"path: {missing}")
    require_writable(path)
    return kind()
