"""The opponents: the same work, done as well as we can with NumPy and with Numba, without audit or divergence check."""

from importlib import import_module
from typing import Any


def optional(name: str) -> Any:
    """A module, or None where it cannot be imported."""
    try:
        return import_module(name)
    except ImportError:
        return None
