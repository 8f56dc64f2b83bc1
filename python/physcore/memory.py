"""Memory: what there is, and refusing what would take more before it is allocated."""

from __future__ import annotations

import os
import sys

from physcore._core import available_memory
from physcore.errors import SceneError


def available() -> int:
    """Bytes that can be had without swapping, within the process's limits; all there are where nothing tells."""
    known = available_memory()
    if known is not None:
        return known
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return sys.maxsize


def require(needed: float, what: str, path: str, hint: str = "") -> None:
    """Refuse to begin what needs more bytes than are free.

    Args:
        needed: bytes; at most inf.
        what: it is that takes them, in the plural.
        path: of the parameter that asks for it.
        hint: what to do instead.

    Raises:
        SceneError: there are not so many.
    """
    free = available()
    if needed > free:
        advice = f"; {hint}" if hint else ""
        raise SceneError(f"{path}: {what} take {needed / 1e9:.4g} GB, and {free / 1e9:.1f} GB are free{advice}")
