"""Finding points that are too close together, in N log N."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from physcore.arithmetic import dots
from physcore.checks import FloatArray, IntArray

FARTHEST = 1e300
"""Numbers of cells along an axis; what is farther away is in the last one."""
LARGEST_KEY = 2.0**62
"""Numbers of cells stay below this, so that sums of a few of them fit into 64 bits."""


def closer_than(points: FloatArray, distance: float) -> tuple[int, int] | None:
    """Two points that are closer together than a distance, or None.

    Args:
        points: [m], shape (N, D).
        distance: [m], above zero.

    The points are sorted into cells as large as the distance, so that only neighboring cells need to be compared.
    """
    if len(points) < 2:
        return None
    with np.errstate(over="ignore"):  # What is infinitely far away is not too close.
        return _closer_than(points, distance)


def _closer_than(points: FloatArray, distance: float) -> tuple[int, int] | None:
    for first, second, _ in close_pairs(points, distance):
        one, other = sorted((int(first[0]), int(second[0])))
        return one, other
    return None


def close_pairs(points: FloatArray, distance: float) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
    """All pairs of points that are closer together than a distance, each once: indices, and how far apart [m]; a few
    of them at a time.
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
    """A number for the cell of each point (N,), and what a step along each axis adds to it (D,)."""
    cells = np.minimum(np.floor((points - points.min(axis=0)) / size), FARTHEST)
    if np.prod(cells.max(axis=0) + 3.0) > LARGEST_KEY:
        # Far apart: empty rows of cells are left out, but for one that keeps their neighbors apart.
        for axis in range(points.shape[1]):
            rows, inverse = np.unique(cells[:, axis], return_inverse=True)
            steps = np.minimum(np.diff(rows, prepend=rows[0]), 2.0)
            cells[:, axis] = np.cumsum(steps)[inverse]
    counts = cells.max(axis=0).astype(np.int64) + 3
    strides = np.concatenate([[1], np.cumprod(counts[:-1])]).astype(np.int64)
    return ((cells.astype(np.int64) + 1) * strides).sum(axis=1), strides


def _candidates(keys: IntArray, strides: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Index pairs, each cell with itself and with half of its neighbors; a few of them at a time."""
    here = np.arange(len(keys))
    for offset in product((-1, 0, 1), repeat=len(strides)):
        step = int((np.array(offset) * strides).sum())
        if step < 0 or (step == 0 and any(offset)):
            continue
        # Points in a cell are consecutive: go through them until no cell has any left.
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
