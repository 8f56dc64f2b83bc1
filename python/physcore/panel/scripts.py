"""Panels of demos and of users' scripts, for the command line."""

from __future__ import annotations

import inspect
import os
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

from physcore.errors import FileError, SceneError
from physcore.panel.controls import Control
from physcore.panel.opening import live
from physcore.panel.panel import Panel, open_panels
from physcore.scene.scene import Scene

NAMES = ("build", "scene")
"""Names of what a script may define in place of a call of `live`."""


def play_script(path: str | os.PathLike[str], port: int = 0) -> list[Panel]:
    """Run a script, and return the panels that it opens by `pc.live`.

    If there are none, one is opened of its function `build` or `scene`, or of its Scene of this name. Arguments of the
    function with a Slider, Switch or Choice as their default are controls.

    Raises:
        FileError: there is no such script.
        SceneError: the script opens no panel, and has neither of these names.
    """
    if not Path(path).is_file():
        raise FileError(f"{path}: there is no such script")
    before = open_panels()
    namespace = runpy.run_path(os.fspath(path), run_name="__main__")
    opened = [panel for panel in open_panels() if panel not in before]
    if opened:
        return opened
    found = next((namespace[name] for name in NAMES if isinstance(namespace.get(name), Scene)), None)
    if found is not None:
        return [live(lambda: found, port=port)]
    built = next((namespace[name] for name in NAMES if inspect.isfunction(namespace.get(name))), None)
    if built is None:
        raise SceneError(f"{path}: opens no panel by pc.live(…), and has no function or Scene called build or scene")
    return [live(built, port=port, **_controls(built))]


def _controls(build: Callable[..., Scene]) -> dict[str, Any]:
    """The controls that a function has as defaults of its arguments."""
    parameters = inspect.signature(build).parameters.values()
    return {each.name: each.default for each in parameters if isinstance(each.default, Control)}
