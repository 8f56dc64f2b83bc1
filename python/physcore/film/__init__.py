"""Films of a recording or a running simulation, as GIF, WebP, APNG or MP4, and still pictures.

A film is drawn by `film`, a single state by `Renderer`. Folders: `styles` for the drawing styles of bodies, `camera`
for the views, `colors` for the themes, and `writers` for the file formats. To add a style or a format, add a file to
`styles/` or `writers/` and a line to its `__init__.py`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from physcore.entrance import entrances
from physcore.film.filming import film, gif_bytes
from physcore.film.notebook import full_html, html
from physcore.simulation.recording import show_with
from physcore.spelling import did_you_mean

if TYPE_CHECKING:
    from physcore.film import styles
    from physcore.film.camera.corotating import Corotating
    from physcore.film.camera.track import Follow, Keyframes
    from physcore.film.camera.view import Orbit, Window
    from physcore.film.colors.themes import DARK, LIGHT, Theme
    from physcore.film.labels.curves import Curve
    from physcore.film.metadata import provenance
    from physcore.film.renderer import Renderer

__all__ = [
    "DARK",
    "LIGHT",
    "Corotating",
    "Curve",
    "Follow",
    "Keyframes",
    "Orbit",
    "Renderer",
    "Theme",
    "Window",
    "film",
    "gif_bytes",
    "provenance",
    "styles",
]

_MODULES = {
    "DARK": "colors.themes",
    "LIGHT": "colors.themes",
    "Corotating": "camera.corotating",
    "Curve": "labels.curves",
    "Follow": "camera.track",
    "Keyframes": "camera.track",
    "Orbit": "camera.view",
    "Renderer": "renderer",
    "Theme": "colors.themes",
    "Window": "camera.view",
    "provenance": "metadata",
}
"""Modules of names that are imported on first use, because many scripts draw nothing."""


show_with(html, full_html)


def __getattr__(name: str) -> object:
    if name == "styles":
        return import_module(f"{__name__}.styles")
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{did_you_mean(name, __all__)}")
    found = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    entrances([found])
    return found


def __dir__() -> list[str]:
    return list(__all__)
