"""Files that appear under their name when they are whole, and never stand there half written.

What is written stands beside the target under a temporary name, which is locked for as long as the writer lives. Who
writes the same target next removes what it finds there and can lock: its writer was killed.
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
except ImportError:  # Windows: nothing is locked there, and so nothing is swept.
    fcntl = None  # type: ignore[assignment]

DIGITS = 8
"""Of the random number in a temporary name."""


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A file to write and read that takes the place of `path` when the block ends well, and vanishes when it does not.

    A link is followed, so that it stays a link; what is no file, such as a device, is not replaced.

    Raises:
        SceneError: it is no path.
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
    """Find out whether a file can be written before the work begins, by creating what `replacing` would create.

    Raises:
        SceneError: it is no path.
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
    """The error for what the system says of a file that is written."""
    return FileError(f"{path}: cannot be written: {error.strerror or error}")


def temporary_name(name: str) -> str:
    """The name of a file or a folder until it is whole."""
    import secrets

    return f".{name}.{secrets.token_hex(DIGITS // 2)}.tmp"


@contextmanager
def held(path: Path, *, create: bool = False) -> Iterator[bool]:
    """Keep `sweep` away from a file or a folder, until the block ends or the process does; say whether it is there.

    Raises:
        OSError: it cannot be opened, or is to be created and is there.
    """
    if fcntl is None:
        if create:
            open(path, "x").close()
        yield True
        return
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL if create else os.O_RDONLY, 0o666)
    try:
        with suppress(OSError):  # A file system without locks, where nobody can sweep either.
            fcntl.flock(descriptor, fcntl.LOCK_SH)
        yield os.fstat(descriptor).st_nlink > 0  # Somebody may have swept it before it was locked.
    finally:
        os.close(descriptor)


def sweep(folder: Path, name: str) -> None:
    """Remove the temporary files and folders of a name that killed writers have left: those that nobody has locked."""
    if fcntl is None:
        return
    with suppress(OSError):
        entries = list(os.scandir(folder))
        for left in entries:
            if _is_temporary(left.name, f".{name}."):
                with suppress(OSError), _unused(left.path):
                    for entry in entries:
                        if left.name in entry.name:  # It, and what was written on the way to it.
                            _remove(entry)


@contextmanager
def _created(target: Path) -> Iterator[Path]:
    """A new, empty temporary file beside a target, which is locked; removed at the end, if it is still there."""
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
    """A lock for nobody else.

    Raises:
        OSError: somebody has locked it.
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
    """Whether it is a temporary name of some target: .name.0123abcd.tmp."""
    digits = name.removeprefix(prefix).removesuffix(".tmp")
    return name == f"{prefix}{digits}.tmp" and len(digits) == DIGITS and set(digits) <= set("0123456789abcdef")


def _target(path: Path) -> Path:
    """The file that is replaced when one is written.

    Raises:
        OSError: it cannot be replaced.
    """
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise OSError(errno.ELOOP, "a link that leads to itself")
    if target.exists() and not target.is_file():
        raise OSError(errno.EINVAL, "not a regular file")
    return target
