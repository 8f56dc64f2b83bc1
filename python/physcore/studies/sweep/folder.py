"""Folder of a sweep: a file that tells what the sweep is, and a file for each finished point."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from physcore.checks import file_path, shown
from physcore.errors import FileError, FileWarning, SceneError, warn
from physcore.storage import archive
from physcore.storage.archive import Tree
from physcore.storage.files import replacing, require_writable
from physcore.storage.schema import anything, flag, maybe, real, record, several, table, text
from physcore.studies.sweep.task import Failure, Outcome

NAME = "sweep.json"
"""Name of the file that tells what the sweep is."""
POINTS = "point-*.npz"
"""Pattern of the names of the other files."""
KIND = "point of a sweep"
"""Kind of the content of the other files."""

_FAILURE = record(kind=text, arguments=several(anything), attributes=table(anything), trace=text, lasting=flag)
_POINT = record(
    sweep=text, scene=maybe(text), value=anything, failure=maybe(_FAILURE), seconds=real(), recording=anything
)


@dataclass(frozen=True, eq=False)
class Folder:
    """Folder of one sweep."""

    path: Path
    sweep: str
    """Hash of what the sweep is."""
    digits: int
    """Number of digits in the names of files."""

    @classmethod
    def opened(cls, folder: object, content: dict[str, Tree], points: int) -> Folder:
        """The folder of a sweep, which is created if necessary.

        Args:
            folder: the path.
            content: what the sweep is, as values for JSON.
            points: the number of points.

        Raises:
            SceneError: the folder belongs to another sweep.
            FileError: the folder cannot be written.
        """
        path = file_path(folder, "folder")
        own = cls(path, str(archive.digest(content)), len(str(points - 1)))
        try:
            path.mkdir(parents=True, exist_ok=True)
            require_writable(path / NAME)
        except OSError as error:
            raise FileError(f"folder: {path} cannot be used as a folder: {error.strerror or error}") from error
        known = own._content()
        if known is None or not any(path.glob(POINTS)):
            with replacing(path / NAME) as file:
                file.write((json.dumps(content, indent=2, ensure_ascii=False) + "\n").encode())
        elif archive.digest(known) != own.sweep:
            raise SceneError(
                f"folder: {path} belongs to another sweep: {_difference(known, content)}; take another folder"
            )
        return own

    def _content(self) -> dict[str, Tree] | None:
        """The description of the sweep in the folder; None if there is none yet, or the file is damaged."""
        path = self.path / NAME
        if not path.exists():
            return None
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            content = None
        if not isinstance(content, dict):
            warn(f"folder: {path} is damaged, and is written anew", FileWarning)
            return None
        return content

    def file(self, index: int) -> Path:
        """The path of the file of a point."""
        return self.path / f"point-{index:0{self.digits}d}.npz"

    def present(self, points: int) -> dict[int, Outcome]:
        """The outcomes of all points that have a file, without recordings. A damaged file is left out.

        Raises:
            SceneError: a file belongs to another sweep.
        """
        found = ((index, self.read(index)) for index in range(points))
        return {index: replace(outcome, recording=None) for index, outcome in found if outcome is not None}

    def read(self, index: int) -> Outcome | None:
        """The outcome of a point; None if there is no file, or it is damaged.

        Raises:
            SceneError: the file belongs to another sweep.
        """
        path = self.file(index)
        if not path.exists():
            return None
        try:
            kind, tree = archive.read(path)
            if kind != KIND:
                raise FileError(f"is a {kind}, not a {KIND}")
            content = _POINT(tree, "")
        except FileError as error:
            warn(f"folder: {path} cannot be used, and is computed anew: {error}", FileWarning)
            return None
        if content.pop("sweep") != self.sweep:
            raise SceneError(f"folder: {path} belongs to another sweep; take another folder")
        failure = content.pop("failure")
        return Outcome(**content, failure=None if failure is None else Failure(**failure))

    def write(self, index: int, outcome: Outcome) -> None:
        """Write the outcome of a point.

        Raises:
            FileError: the file cannot be written.
        """
        failure = None if outcome.failure is None else asdict(outcome.failure)
        archive.write(self.file(index), KIND, {"sweep": self.sweep, **vars(outcome), "failure": failure})


def _difference(known: dict[str, Tree], content: dict[str, Tree]) -> str:
    """A phrase on the first difference between two sweeps."""
    for name in {**content, **known}:
        one, other = known.get(name), content.get(name)
        if archive.digest({"value": one}) == archive.digest({"value": other}):
            continue
        if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
            return f"in its {name}, {_difference(one, other)}"
        return f"{name} is {shown(one)}, and here it is {shown(other)}"
    return "it was written by another version"
