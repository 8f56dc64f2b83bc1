"""File formats, selected by the suffix of a name; foreseeable errors are raised before the work begins."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import ClassVar, TypeVar

from physcore.checks import file_path, shown
from physcore.errors import PhyscoreError, SceneError
from physcore.storage.files import require_writable


class Format:
    """Base class of file formats."""

    suffixes: ClassVar[tuple[str, ...]]
    """Suffixes of the file names."""

    @classmethod
    def missing(cls) -> str | None:
        """A sentence on the package that must be installed first; None if none is missing."""
        return None


Kind = TypeVar("Kind", bound=Format)


def format_of(path: str | os.PathLike[str], formats: Sequence[type[Kind]]) -> type[Kind]:
    """The format selected by the suffix of a path.

    Raises:
        SceneError: the suffix is unknown.
    """
    named = file_path(path)
    suffix = named.suffix.lower()
    for each in formats:
        if suffix in each.suffixes:
            return each
    known = [suffix for each in formats for suffix in each.suffixes]
    raise SceneError(f"path: must end in {', '.join(known[:-1])} or {known[-1]}, got {shown(str(named))}")


def writable(path: str | os.PathLike[str], formats: Sequence[type[Kind]]) -> Kind:
    """An instance of the format selected by the suffix of a path, after a check that it can write.

    Raises:
        SceneError: the suffix is unknown.
        FileError: the file cannot be written.
        PhyscoreError: a package that the format needs is not installed.
    """
    kind = format_of(path, formats)
    missing = kind.missing()
    if missing is not None:
        raise PhyscoreError(f"path: {missing}")
    require_writable(path)
    return kind()
