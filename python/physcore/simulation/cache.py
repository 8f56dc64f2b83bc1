"""Cache of recordings: files in a folder, named by the hash of all that the recording depends on."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from physcore.checks import file_path, is_word, text
from physcore.errors import FileError, FileWarning, SceneError, warn
from physcore.numerics.choices import Options, check, require_options
from physcore.scene.scene import Scene
from physcore.simulation.event import Approach, Crossing, Event, checked
from physcore.simulation.occurrences import Events
from physcore.simulation.provenance import version
from physcore.simulation.recording import Recording, check_channels
from physcore.simulation.serial import pack_numerics
from physcore.storage import archive
from physcore.storage.files import require_writable
from physcore.storage.identity import identity
from physcore.storage.schema import anything, record
from physcore.storage.schema import text as any_text

KIND = "cached recording"
"""Kind of the content of a cache's files."""
FREE = ("threads",)
"""Numerical options that change no bit of a recording."""


def scene_hash(scene: Scene, key: str | None) -> str:
    """The hash of a scene; `key` stands for its functions.

    Raises:
        SceneError: the scene has a function, and there is no key.
    """
    try:
        return scene.hash(key)
    except FileError as error:
        raise SceneError(
            f"key: must name the functions of this scene, which have no hash: key='…', another one whenever they "
            f"change ({error})"
        ) from None


def check_key(key: object, *, used: bool) -> str | None:
    """The name of the functions of scenes.

    Raises:
        SceneError: the value is not a text, or there is no use for it.
    """
    if key is not None and not used:
        raise SceneError("key: names the functions of a scene in files; give a folder too")
    return None if key is None else text(key, "key")


def cached(
    folder: str | os.PathLike[str],
    scene: Scene,
    options: Options,
    arguments: Mapping[str, object],
    channels: object,
    events: Sequence[Event],
    key: str | None,
    compute: Callable[[], Recording],
) -> Recording:
    """The recording of a scene from a cache, or from `compute`, whose result is then written to the cache.

    Args:
        folder: the folder of the cache, which is created if necessary.
        scene: the scene.
        options: the numerical options.
        arguments: other arguments of the run that are numbers or None.
        channels: the fields to record; None: the default ones.
        events: the events to look for.
        key: a text that stands for the functions of the scene.
        compute: gives the recording.

    Raises:
        SceneError: an argument is not valid, or the scene has a function and there is no key.
        FileError: the folder cannot be written.

    Warns:
        FileWarning: a file of the cache is damaged, or cannot be written after the run.
    """
    require_options(options, "simulate")
    given, place = checked(events, scene), file_path(folder, "cache")
    numerics = pack_numerics(check(options, scene))
    entry = archive.digest({
        "version": version(),
        "scene": scene_hash(scene, key),
        "numerics": {name: value for name, value in numerics.items() if name not in FREE},
        "chosen": is_word(options.get("integrator", "auto"), "auto"),
        "arguments": dict(arguments),
        "channels": None if channels is None else sorted(check_channels(channels, scene)),
        "events": [_identity(event, scene, f"events[{index}]") for index, event in enumerate(given)],
    })  # fmt: skip
    path = place / f"{entry}.npz"
    found = _read(path, entry, scene, given)
    if found is not None:
        return found
    _require(path)
    recording = compute()
    try:
        archive.write(path, KIND, {"entry": entry, "recording": recording.content()})
    except FileError as error:
        warn(f"cache: {error}; the recording is not kept", FileWarning)
    return recording


def _read(path: Path, entry: str, scene: Scene, events: tuple[Event, ...]) -> Recording | None:
    """The recording in a file; None if there is no such file, or it is damaged."""
    if not path.exists():
        return None
    try:
        kind, tree = archive.read(path)
        content = record(entry=any_text, recording=anything)(tree, "")
        if (kind, content["entry"]) != (KIND, entry):
            raise FileError("is the file of another recording")
        recording = Recording.from_content(content["recording"], scene)
    except FileError as error:
        warn(f"cache: {path} cannot be used, and is computed anew: {error}", FileWarning)
        return None
    return replace(recording, events=Events(recording.events.found, events))


def _require(path: Path) -> None:
    """Create the folder of a cache, and check that it can be written.

    Raises:
        FileError: it cannot.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        require_writable(path)
    except OSError as error:
        raise FileError(f"cache: {path.parent} cannot be used as a folder: {error.strerror or error}") from error


def _identity(event: Event, scene: Scene, path: str) -> archive.Tree:
    """The identity of an event. Bodies and systems are identified by their places in the scene."""
    function = event.function
    if isinstance(function, (Crossing, Approach)):
        owners = {name: each for name, each in vars(function).items() if name in ("body", "other")}
        places: dict[str, Any] = {name: scene.system(each) or scene.index(each) for name, each in owners.items()}
        event = replace(event, function=replace(function, **places))
    return identity(event, path)
