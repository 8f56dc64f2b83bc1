"""Corners of boxes along the axes."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray


def corners(lower: FloatArray, upper: FloatArray) -> FloatArray:
    """The 2^D corners of an axis-aligned box. The bits of a corner's index tell along which axes it is upper."""
    upper_in = np.array(list(np.ndindex(*(2,) * len(lower))), dtype=bool)
    return np.where(upper_in, upper, lower)
