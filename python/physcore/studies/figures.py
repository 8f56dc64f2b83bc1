"""Figures of studies: axes and files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from physcore.checks import shown
from physcore.errors import PhyscoreError, SceneError
from physcore.storage.files import replacing, require_writable

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def require_plottable(path: str | os.PathLike[str] | None) -> None:
    """Check that a figure can be written, before the work begins.

    Raises:
        SceneError: the value is not a path, or has no suffix of a format of Matplotlib.
        FileError: the file cannot be written.
        PhyscoreError: Matplotlib is not installed.
    """
    try:
        from matplotlib.backend_bases import FigureCanvasBase
    except ImportError:
        raise PhyscoreError('plotting needs Matplotlib: pip install "physcore[plot]"') from None
    if path is None:
        return
    known, suffix = FigureCanvasBase.get_supported_filetypes(), _suffix(require_writable(path))
    if suffix not in known:
        raise SceneError(f"path: must end in {', '.join(f'.{each}' for each in known)}, got {shown(str(path))}")


def axes_for(path: str | os.PathLike[str] | None, axes: Axes | None) -> Axes:
    """The given axes, or those of a new figure.

    Raises:
        SceneError, FileError, PhyscoreError: as for `require_plottable`.
    """
    if path is not None or axes is None:
        require_plottable(path)
    if axes is None:
        from matplotlib.figure import Figure

        axes = Figure(figsize=(7.2, 4.8), layout="constrained").subplots()
    return axes


def save(axes: Axes, path: str | os.PathLike[str] | None) -> None:
    """Write the figure of some axes to a file; None: to none.

    Raises:
        FileError: the file cannot be written.
    """
    if path is not None:
        with replacing(path) as file:
            figure = axes.get_figure(root=True)
            assert figure is not None
            figure.savefig(file, format=_suffix(path), dpi=144)


def _suffix(path: str | os.PathLike[str]) -> str:
    """The format of a figure, from its suffix."""
    return Path(path).suffix.lstrip(".").lower() or "png"
