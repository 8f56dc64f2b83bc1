"""Available memory, and checks before large allocations."""

from __future__ import annotations

import os
import sys

from physcore._core import available_memory
from physcore.errors import SceneError


def available() -> int:
    """Available memory without swapping, within the limits of the process [bytes]. If this is unknown: the total
    memory.
    """
    known = available_memory()
    if known is not None:
        return known
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return sys.maxsize


def require(needed: float, what: str, path: str, hint: str = "") -> None:
    """Check that enough memory is free.

    Args:
        needed: required memory [bytes]; may be inf.
        what: name of the objects that need it, in the plural.
        path: path of the parameter that causes it.
        hint: remedy, for the message.

    Raises:
        SceneError: less memory is free.
    """
    free = available()
    if needed > free:
        advice = f"; {hint}" if hint else ""
        raise SceneError(f"{path}: {what} take {needed / 1e9:.4g} GB, and {free / 1e9:.1f} GB are free{advice}")
