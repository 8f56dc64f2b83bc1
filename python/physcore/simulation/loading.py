"""Loading of checkpoints and recordings."""

from __future__ import annotations

import os
from collections.abc import Callable

from physcore.checks import file_path
from physcore.entrance import entrance
from physcore.errors import FileError, PhyscoreError
from physcore.simulation.recording import Recording
from physcore.simulation.simulation import Simulation
from physcore.storage import archive
from physcore.storage.schema import word

_KINDS: dict[str, Callable[[dict[str, archive.Tree]], Simulation | Recording]] = {
    "simulation": Simulation.from_content,
    "recording": Recording.from_content,
}
"""Loaders by the kind of a file's content."""


@entrance
def load(path: str | os.PathLike[str]) -> Simulation | Recording:
    """Load a checkpoint or a recording.

        recording.save("cloth.npz")
        recording = pc.load("cloth.npz")

    A checkpoint gives a Simulation that continues with the same bits as the saved one.

    Raises:
        SceneError: the value is not a path.
        FileError: the file is missing, damaged, of another version, or not a file of physcore; the message tells the
            error in it.
    """
    named = file_path(path)
    kind, content = archive.read(named)
    try:
        return _KINDS[word(*_KINDS)(kind, "kind")](content)
    except PhyscoreError as error:
        raise FileError(f"{named}: cannot be read by this version of physcore: {error}") from error
