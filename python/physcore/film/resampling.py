"""Interpolation of values between cell centers."""

from __future__ import annotations

import numpy as np

from physcore.checks import FloatArray


def cubic(count: int, places: FloatArray, *, closed: bool = False, width: float = 1.0) -> FloatArray:
    """Weights (P, count) of cubic convolution, for values at 0, 1, … and interpolated places between them. A width
    above one stretches the kernel, so that it averages over more neighbors.

    Args:
        count: the number of values.
        places: the places of the interpolated values, shape (P,).
        closed: whether the values are periodic: the first follows the last.
        width: the distance between places, if it is larger than one.

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
