"""Atomic writing of files: a file appears under its name only when it is complete.

Data are written to a temporary file beside the target, which is locked while the writer lives. The next writer of the
same target removes temporary files that are not locked, because their writers were killed.
"""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from physcore.checks import file_path
from physcore.errors import FileError

try:
    import fcntl
except ImportError:  # Windows: files are neither locked nor swept.
    fcntl = None  # type: ignore[assignment]

DIGITS = 8
"""Number of digits of the random part of a temporary name."""


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Context manager of a file for writing and reading. The file replaces `path` after success, and is deleted
    otherwise.

    A link is followed and remains a link. Only regular files are replaced, but not devices, for example.

    Raises:
        SceneError: the value is not a path.
        FileError: the file cannot be written.
    """
    named = file_path(path)
    try:
        target = _target(named)
        sweep(target.parent, target.name)
        with _created(target) as temporary:
            with open(temporary, "r+b") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, target)
    except FileError:
        raise
    except OSError as error:
        raise unwritable(named, error) from error


def require_writable(path: str | os.PathLike[str]) -> Path:
    """Check that a file can be written, before the work begins, by creating a temporary file as `replacing` does.

    Raises:
        SceneError: the value is not a path.
        FileError: the file cannot be written.
    """
    named = file_path(path)
    try:
        target = _target(named)
        if not target.parent.is_dir():
            raise OSError(errno.ENOENT, "no such folder")
        with _created(target):
            pass
    except OSError as error:
        raise unwritable(named, error) from error
    return named


def unwritable(path: Path, error: OSError) -> FileError:
    """The FileError for an OSError while a file is written."""
    return FileError(f"{path}: cannot be written: {error.strerror or error}")


def temporary_name(name: str) -> str:
    """The temporary name of a file or a folder."""
    import secrets

    return f".{name}.{secrets.token_hex(DIGITS // 2)}.tmp"


@contextmanager
def held(path: Path, *, create: bool = False) -> Iterator[bool]:
    """Context manager that protects a file or a folder from `sweep`. Its value tells whether the file still exists.

    Raises:
        OSError: the file cannot be opened, or with `create` exists already.
    """
    if fcntl is None:
        if create:
            open(path, "x").close()
        yield True
        return
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL if create else os.O_RDONLY, 0o666)
    try:
        with suppress(OSError):  # A file system without locks, where `sweep` does nothing either.
            fcntl.flock(descriptor, fcntl.LOCK_SH)
        yield os.fstat(descriptor).st_nlink > 0  # Another process may have swept it before it was locked.
    finally:
        os.close(descriptor)


def sweep(folder: Path, name: str) -> None:
    """Remove the temporary files and folders of a name that killed writers have left, which are not locked."""
    if fcntl is None:
        return
    with suppress(OSError):
        entries = list(os.scandir(folder))
        for left in entries:
            if _is_temporary(left.name, f".{name}."):
                with suppress(OSError), _unused(left.path):
                    for entry in entries:
                        if left.name in entry.name:  # The entry, and temporary files named after it.
                            _remove(entry)


@contextmanager
def _created(target: Path) -> Iterator[Path]:
    """Context manager of a new, empty, locked temporary file beside a target. The file is deleted at the end if it
    still exists.
    """
    while True:
        temporary = target.with_name(temporary_name(target.name))
        try:
            with held(temporary, create=True) as there:
                if there:
                    yield temporary
                    return
        finally:
            temporary.unlink(missing_ok=True)


@contextmanager
def _unused(path: str) -> Iterator[None]:
    """Context manager of an exclusive lock.

    Raises:
        OSError: another process has locked the file.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)


def _remove(entry: os.DirEntry[str]) -> None:
    if entry.is_dir(follow_symlinks=False):
        shutil.rmtree(entry.path)
    else:
        os.unlink(entry.path)


def _is_temporary(name: str, prefix: str) -> bool:
    """Whether a name is a temporary name of a target, such as .name.0123abcd.tmp."""
    digits = name.removeprefix(prefix).removesuffix(".tmp")
    return name == f"{prefix}{digits}.tmp" and len(digits) == DIGITS and set(digits) <= set("0123456789abcdef")


def _target(path: Path) -> Path:
    """The file that is replaced by a write to `path`.

    Raises:
        OSError: the file cannot be replaced.
    """
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise OSError(errno.ELOOP, "a link that leads to itself")
    if target.exists() and not target.is_file():
        raise OSError(errno.EINVAL, "not a regular file")
    return target
