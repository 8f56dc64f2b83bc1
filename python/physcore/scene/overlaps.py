"""Search for points that are too close together, in N log N."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from physcore.arithmetic import dots
from physcore.checks import FloatArray, IntArray

FARTHEST = 1e300
"""Largest index of a cell along an axis; points farther away are put into the last cell."""
LARGEST_KEY = 2.0**62
"""Upper bound of the keys of cells, such that sums of a few keys fit into 64 bits."""


def closer_than(points: FloatArray, distance: float) -> tuple[int, int] | None:
    """Two points whose distance is below a bound, or None.

    Args:
        points: points [m], shape (N, D).
        distance: the bound [m], above zero.

    The points are sorted into cells of this size, so that only neighboring cells are compared.
    """
    if len(points) < 2:
        return None
    with np.errstate(over="ignore"):  # An overflow to infinity means a large distance.
        return _closer_than(points, distance)


def _closer_than(points: FloatArray, distance: float) -> tuple[int, int] | None:
    for first, second, _ in close_pairs(points, distance):
        one, other = sorted((int(first[0]), int(second[0])))
        return one, other
    return None


def close_pairs(points: FloatArray, distance: float) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
    """All pairs of points whose distance is below a bound, in batches: two arrays of indices, and the distances [m].
    Each pair occurs once.
    """
    keys, strides = _keys(points, distance)
    order = np.argsort(keys, kind="stable")
    keys, sorted_points = keys[order], points[order]
    for first, second in _candidates(keys, strides):
        separation = sorted_points[first] - sorted_points[second]
        squared = dots(separation, separation)
        close = squared < distance * distance
        if close.any():
            yield order[first[close]], order[second[close]], np.sqrt(squared[close])


def _keys(points: FloatArray, size: float) -> tuple[IntArray, IntArray]:
    """A key for the cell of each point (N,), and its increment for a step along each axis (D,)."""
    cells = np.minimum(np.floor((points - points.min(axis=0)) / size), FARTHEST)
    if np.prod(cells.max(axis=0) + 3.0) > LARGEST_KEY:
        # For points far apart, empty rows of cells are removed, except one that separates their neighbors.
        for axis in range(points.shape[1]):
            rows, inverse = np.unique(cells[:, axis], return_inverse=True)
            steps = np.minimum(np.diff(rows, prepend=rows[0]), 2.0)
            cells[:, axis] = np.cumsum(steps)[inverse]
    counts = cells.max(axis=0).astype(np.int64) + 3
    strides = np.concatenate([[1], np.cumprod(counts[:-1])]).astype(np.int64)
    return ((cells.astype(np.int64) + 1) * strides).sum(axis=1), strides


def _candidates(keys: IntArray, strides: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Candidate pairs of indices in the same cell or in half of its neighbors, in batches."""
    here = np.arange(len(keys))
    for offset in product((-1, 0, 1), repeat=len(strides)):
        step = int((np.array(offset) * strides).sum())
        if step < 0 or (step == 0 and any(offset)):
            continue
        # Points in a cell are consecutive: advance through all cells at once, until all are exhausted.
        first, second = here, here + 1 if step == 0 else np.searchsorted(keys, keys + step)
        while True:
            there = second < len(keys)
            first, second = first[there], second[there]
            same = keys[second] == keys[first] + step
            first, second = first[same], second[same]
            if len(first) == 0:
                break
            yield first, second
            second = second + 1
