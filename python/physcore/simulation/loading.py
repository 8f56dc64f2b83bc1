"""Reading back what was saved."""

from __future__ import annotations

import os
from collections.abc import Callable

from physcore.checks import file_path
from physcore.errors import FileError, PhyscoreError
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation
from physcore.storage import archive
from physcore.storage.schema import word

_KINDS: dict[str, Callable[[dict[str, archive.Tree]], Simulation | Recording]] = {
    "simulation": Simulation.from_content,
    "recording": Recording.from_content,
}
"""The kinds of content of a file."""


def load(path: str | os.PathLike[str]) -> Simulation | Recording:
    """Read a checkpoint or a recording.

        recording.save("cloth.npz")
        recording = pc.load("cloth.npz")

    A checkpoint gives a Simulation that goes on with the same bits as the one that was saved.

    Raises:
        SceneError: it is no path.
        FileError: the file is missing, damaged, of another version, or no file of physcore; with what is wrong in it.
    """
    named = file_path(path)
    kind, content = archive.read(named)
    try:
        return _KINDS[word(*_KINDS)(kind, "kind")](content)
    except PhyscoreError as error:
        raise FileError(f"{named}: cannot be read by this version of physcore: {error}") from error
