"""Reading back what was saved."""

from __future__ import annotations

import os

from physcore import storage
from physcore.errors import FileError, PhyscoreError
from physcore.recording import Recording
from physcore.simulation import Simulation


def load(path: str | os.PathLike[str]) -> Simulation | Recording:
    """Read a checkpoint or a recording.

    A checkpoint gives a Simulation that goes on with the same bits as the one that was saved.

    Raises:
        FileError: the file is missing, damaged, of another version, or no file of physcore.
    """
    kind, content = storage.read(path)
    try:
        return Simulation.from_content(content) if kind == "simulation" else Recording.from_content(content)
    except (KeyError, TypeError, ValueError, PhyscoreError) as error:
        raise FileError(f"{os.fspath(path)}: cannot be read by this version of physcore: {error}") from error
