"""Values between the centers of cells."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray


def cubic(count: int, places: FloatArray, *, closed: bool = False, width: float = 1.0) -> FloatArray:
    """The weights (P, count) of values at 0, 1, … for those at places between them: of a cubic through four neighbors,
    or, stretched by a width above one, of a mean over more of them.

    Args:
        count: the number of values.
        places: where they are asked for, shape (P,).
        closed: whether the first value follows the last one.
        width: how far the places are apart, where that is more than one.

    Source: R. G. Keys, IEEE Trans. Acoust. Speech Signal Process. 29, 1153 (1981), with a = −½.
    """
    apart = places[:, np.newaxis] - np.arange(count)
    if closed:
        apart = (apart + 0.5 * count) % count - 0.5 * count
    distance = np.abs(apart) / max(1.0, width)
    near = 1.0 + distance**2 * (1.5 * distance - 2.5)
    far = 2.0 - distance * (4.0 - distance * (2.5 - 0.5 * distance))
    weights = np.where(distance < 1.0, near, np.where(distance < 2.0, far, 0.0))
    shares: FloatArray = weights / weights.sum(axis=1, keepdims=True)
    return shares
