"""Metadata of films: the provenance records of the panels, written into and beside films, and read back."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Sequence
from pathlib import Path

from physcore.checks import file_path
from physcore.entrance import entrance
from physcore.errors import FileError, SceneError
from physcore.film.writers import WRITERS
from physcore.simulation.provenance_record import ProvenanceRecord
from physcore.simulation.sources import Source
from physcore.storage.files import replacing
from physcore.storage.formats import format_of
from physcore.storage.schema import anything, several, table

SIDECAR = ".json"
"""Suffix of the metadata file beside a film."""


def metadata(found: Sequence[Source]) -> str:
    """The metadata of a film: everything on which its bits depend, and therefore without the machine."""
    panels = [{name: value for name, value in source.provenance.items() if name != "machine"} for source in found]
    return json.dumps(panels, allow_nan=False, separators=(",", ":"))


def sidecar_of(target: Path) -> Path:
    """The path of the metadata file beside a film."""
    return target.with_name(target.name + SIDECAR)


def write_sidecar(found: Sequence[Source], target: Path) -> None:
    """Write the metadata file beside a film.

    Raises:
        FileError: the file cannot be written.
    """
    text = json.dumps([source.provenance for source in found], allow_nan=False, indent=2)
    with replacing(sidecar_of(target)) as file:
        file.write(text.encode() + b"\n")


@entrance
def provenance(path: str | os.PathLike[str]) -> list[ProvenanceRecord]:
    """Provenance of a film, read from it or from the JSON file beside it: one dictionary for each panel.

        pc.film(recording, "cloth.png")
        pc.provenance("cloth.png")[0]["scene"] == recording.scene.hash()  # True

    The keys are those of `ProvenanceRecord`. To verify a film, compare "scene" with `scene.hash()`. Then simulate this
    scene with the same numerics and the same steps, and compare "state" with `Simulation.state_hash()`.

    Raises:
        SceneError: the file name has no suffix of a film.
        FileError: the file is missing or damaged, or has no provenance.
    """
    target = file_path(path)
    try:
        text = target.read_text("utf-8") if target.suffix == SIDECAR else format_of(target, WRITERS).provenance(target)
        if text is None:
            raise ValueError("holds no provenance")
        panels: list[ProvenanceRecord] = list(several(table(anything))(json.loads(text), "provenance"))
        return panels
    except SceneError:
        raise
    except OSError as error:
        raise FileError(f"{target}: cannot be read: {error.strerror or error}") from error
    except (ValueError, TypeError, IndexError, RecursionError, struct.error, MemoryError) as error:
        raise FileError(f"{target}: is damaged: {error}") from error
