"""Archive format of checkpoints and recordings.

A file is a NumPy archive (NPZ, readable by `numpy.load`). Its zip comment has a magic word, the version of the format
and a checksum of all preceding bytes. Arrays are separate members; all other data are in the member `header.json`.
Nothing is ever pickled. A file appears under its name only when it is complete.
"""

from __future__ import annotations

import json
import math
import os
import re
import struct
from typing import IO, TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.lib import format as npy

from physcore.checks import file_path, shown
from physcore.errors import FileError
from physcore.storage.files import replacing

# hashlib and zipfile are imported on use: their import takes as long as that of the rest of physcore.
if TYPE_CHECKING:
    import zipfile

VERSION = 1
_MAGIC = b"physcore"
_HEADER = "header.json"
_DIGEST_SIZE = 32
_TRAILER_SIZE = len(_MAGIC) + 1 + 4 + 1 + 2 * _DIGEST_SIZE  # "physcore 0001 <hex>"
_BLOCK = 1 << 20
_AXES = 8
"""Largest number of axes of an array."""
_NPY_HEADER = re.compile(
    rb"\x93NUMPY\x01\x00..\{'descr': '(?P<dtype><[fiu][48]|\|[bui]1)', 'fortran_order': (?P<fortran>True|False), "
    rb"'shape': \((?P<shape>[0-9, ]{0,200})\), \} *\n",
    re.DOTALL,
)
"""Header that NumPy writes before an array of numbers, in version 1.0 of its format."""

Tree = Any
"""Value of a tree: None, bool, int, float, str, bytes, an array, or lists and dicts (with string keys) of these."""


def write(path: str | os.PathLike[str], kind: str, tree: dict[str, Tree]) -> None:
    """Write a tree of values to `path`; an existing file is replaced atomically.

    Raises:
        FileError: the file cannot be written.
    """
    import zipfile

    arrays: dict[str, np.ndarray] = {}
    header = json.dumps({"kind": kind, "content": _pack(tree, "", arrays)})
    with replacing(path) as file:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
            archive.writestr(zipfile.ZipInfo(_HEADER), header)
            for name, values in arrays.items():
                with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
                    npy.write_array(member, values, allow_pickle=False)
            archive.comment = _trailer("0" * 2 * _DIGEST_SIZE)
        size = file.tell() - _TRAILER_SIZE
        digest = _digest(file, size)
        file.seek(size)
        file.write(_trailer(digest))


def read(path: str | os.PathLike[str]) -> tuple[str, dict[str, Tree]]:
    """The kind and the tree of values of a file.

    Raises:
        SceneError: the value is not a path.
        FileError: the file is missing, damaged, of another version, or not a file of physcore.
    """
    named = file_path(path)
    try:
        with open(named, "rb") as file:
            _verify(file)
            return _read_archive(file)
    except FileError as error:
        raise FileError(f"{named}: {error}") from None
    except OSError as error:
        raise FileError(f"{named}: cannot be read: {error.strerror or error}") from error


def digest(tree: Tree) -> str:
    """Hash of a tree of values: BLAKE2 over its JSON and its arrays, the same on every machine."""
    import hashlib

    arrays: dict[str, np.ndarray] = {}
    result = hashlib.blake2b(json.dumps(_pack(tree, "", arrays), sort_keys=True).encode(), digest_size=16)
    for name, values in arrays.items():
        result.update(f"{name} {values.dtype.str} {values.shape}".encode())
        result.update(values.tobytes())
    return result.hexdigest()


def plain(tree: Tree) -> Tree:
    """A tree as it is read from a file: lists in place of tuples, and numbers of Python in place of those of NumPy."""
    match tree:
        case dict():
            return {key: plain(entry) for key, entry in tree.items()}
        case list() | tuple():
            return [plain(entry) for entry in tree]
        case np.generic():
            return tree.item()
    return tree


def _trailer(digest: str) -> bytes:
    return b"%s %04d %s" % (_MAGIC, VERSION, digest.encode())


def _digest(file: IO[bytes], size: int) -> str:
    """BLAKE2 hash of the first `size` bytes."""
    import hashlib

    result = hashlib.blake2b(digest_size=_DIGEST_SIZE)
    file.seek(0)
    while size > 0:
        block = file.read(min(size, _BLOCK))
        if not block:
            break
        result.update(block)
        size -= len(block)
    return result.hexdigest()


def _verify(file: IO[bytes]) -> None:
    """Check magic, version and checksum."""
    size = file.seek(0, os.SEEK_END) - _TRAILER_SIZE
    if size <= 0:
        raise FileError("is empty or cut short" if size > -_TRAILER_SIZE else "is empty")
    file.seek(size)
    trailer = file.read()
    magic, _, rest = trailer.partition(b" ")
    if magic != _MAGIC:
        raise FileError("is damaged, cut short, or no file of physcore")
    if trailer == _trailer(_digest(file, size)):
        return
    version = rest.partition(b" ")[0].decode("ascii", "replace")
    if version != f"{VERSION:04d}":
        raise FileError(f"has format version {version.lstrip('0')!r}; this physcore reads version {VERSION}")
    raise FileError("is damaged: its checksum does not match its content")


def _read_archive(file: IO[bytes]) -> tuple[str, dict[str, Tree]]:
    """The kind and the tree of an archive with a correct checksum. The content is not trusted.

    Raises:
        FileError: the archive differs from the form that `write` produces.
    """
    import zipfile

    try:
        with zipfile.ZipFile(file) as archive:
            _verify_members(archive, file.seek(0, os.SEEK_END))
            header = json.loads(archive.read(_HEADER))
            match header:
                case {"kind": str(kind), "content": dict(content)}:
                    return kind, _unpack(content, archive)
            raise FileError(f"is damaged: {_HEADER} must have a kind and a content")
    except RecursionError as error:
        raise FileError(f"is damaged: {_HEADER} is nested too deeply") from error
    except (zipfile.BadZipFile, KeyError, ValueError, EOFError, RuntimeError, struct.error) as error:
        raise FileError(f"is damaged: {error}") from error


def _verify_members(archive: zipfile.ZipFile, size: int) -> None:
    """Check that the members are not larger than the archive, so that reading them takes limited memory.

    Raises:
        FileError: a member is compressed or encrypted, which `write` never does, or occurs twice.
    """
    import zipfile

    members = archive.infolist()
    for member in members:
        if member.compress_type != zipfile.ZIP_STORED or member.file_size != member.compress_size:
            raise FileError(f"is damaged: {shown(member.filename)} is compressed, which physcore never does")
    if len({member.filename for member in members}) < len(members) or sum(each.file_size for each in members) > size:
        raise FileError("is damaged: its members overlap")


def _pack(value: Tree, path: str, arrays: dict[str, np.ndarray]) -> Tree:
    """A tree for JSON, with arrays and bytes moved to `arrays` under their paths."""
    inner = f"{path}/" if path else ""
    match value:
        case dict():
            return {key: _pack(entry, f"{inner}{key}", arrays) for key, entry in value.items()}
        case list() | tuple():
            return [_pack(entry, f"{inner}{index}", arrays) for index, entry in enumerate(value)]
        case np.ndarray():
            arrays[path] = value
            return {"$array": path}
        case bytes():
            arrays[path] = np.frombuffer(value, dtype=np.uint8)
            return {"$bytes": path}
        case np.generic():
            return value.item()
    return value


def _unpack(value: Tree, archive: zipfile.ZipFile) -> Tree:
    """The tree from the result of `_pack`; tuples become lists."""
    match value:
        case {"$array": name}:
            return _array(archive, name)
        case {"$bytes": name}:
            return _array(archive, name).tobytes()
        case dict():
            return {key: _unpack(entry, archive) for key, entry in value.items()}
        case list():
            return [_unpack(entry, archive) for entry in value]
    return value


def _array(archive: zipfile.ZipFile, name: object) -> np.ndarray:
    """An array from an archive.

    Raises:
        FileError: the array is missing, or its content does not match its header.
    """
    if not isinstance(name, str) or f"{name}.npy" not in archive.NameToInfo:
        raise FileError(f"is damaged: it has no array {shown(name)}")
    content = archive.read(f"{name}.npy")
    found = _NPY_HEADER.match(content)
    if found is None:
        raise FileError(f"is damaged: {shown(name)} has not the header of an array of numbers")
    shape = tuple(int(size) for size in found["shape"].decode().split(",") if size.strip())
    dtype, data = np.dtype(found["dtype"].decode()), memoryview(content)[found.end() :]
    if math.prod(shape) * dtype.itemsize != len(data) or len(shape) > _AXES:
        raise FileError(f"is damaged: {shown(name)} holds {len(data)} bytes, which is not the shape {shown(shape)}")
    order: Literal["F", "C"] = "F" if found["fortran"] == b"True" else "C"
    return np.frombuffer(data, dtype=dtype).reshape(shape, order=order).copy(order="K")
