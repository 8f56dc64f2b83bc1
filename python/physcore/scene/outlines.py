"""Polygons in the plane: whether they cross themselves, outlines of masks, and simplification."""

from __future__ import annotations

import numpy as np

from physcore.arithmetic import dots, lengths
from physcore.checks import FloatArray, IntArray

LEVEL = 0.5
"""Value at an outline."""
INSIDE = 0.02
"""Least distance of an outline from the center of a pixel [pixels], so that no two vertices coincide."""

TOP, RIGHT, BOTTOM, LEFT = range(4)
CASES: dict[int, tuple[tuple[int, int], ...]] = {
    1: ((LEFT, TOP),),
    2: ((TOP, RIGHT),),
    3: ((LEFT, RIGHT),),
    4: ((RIGHT, BOTTOM),),
    5: ((LEFT, TOP), (RIGHT, BOTTOM)),
    6: ((TOP, BOTTOM),),
    7: ((LEFT, BOTTOM),),
    8: ((BOTTOM, LEFT),),
    9: ((BOTTOM, TOP),),
    10: ((TOP, RIGHT), (BOTTOM, LEFT)),
    11: ((BOTTOM, RIGHT),),
    12: ((RIGHT, LEFT),),
    13: ((RIGHT, TOP),),
    14: ((TOP, LEFT),),
}
"""Segments of a square, from side to side with the inside on the left, by the corners that are inside.

The corners are upper left 1, upper right 2, lower right 4, lower left 8. Opposite corners are not connected.
"""


def outlines(values: FloatArray) -> list[FloatArray]:
    """The closed curves on which values (rows, columns) are 1/2: vertices (K, 2) [pixels], y upward.

    The inside is on the left: outer curves are counterclockwise, and holes are clockwise. Outside of the array all is
    0. The center of the lower left pixel is at (0.5, 0.5).
    """
    padded = np.pad(values, 1)
    columns = padded.shape[1]
    inside = padded > LEVEL
    corners = (inside[:-1, :-1], inside[:-1, 1:], inside[1:, 1:], inside[1:, :-1])
    cases = np.sum([corner.astype(np.int64) << bit for bit, corner in enumerate(corners)], axis=0)
    following: dict[int, int] = {}
    for case, segments in CASES.items():
        row, column = np.nonzero(cases == case)
        first = 2 * (row * columns + column)
        sides = (first, first + 3, first + 2 * columns, first + 1)  # even: from a center to the right; odd: downward
        for start, end in segments:
            following.update(zip(sides[start].tolist(), sides[end].tolist(), strict=True))
    loops = []
    while following:
        first_side, side = following.popitem()
        loop = [first_side]
        while side != first_side:
            loop.append(side)
            side = following.pop(side)
        loops.append(_vertices(np.array(loop), padded))
    return loops


def _vertices(sides: IntArray, padded: FloatArray) -> FloatArray:
    """The points (K, 2) on sides between the centers of pixels."""
    rows, columns = padded.shape
    row, column = np.divmod(sides // 2, columns)
    down = sides % 2
    one, other = padded[row, column], padded[row + down, column + 1 - down]
    share = np.clip((LEVEL - one) / (other - one), INSIDE, 1.0 - INSIDE)
    # One row and one column of padding.
    return np.column_stack([column - 0.5 + (1 - down) * share, rows - 1.5 - row - down * share])


def cross(one: FloatArray, other: FloatArray) -> FloatArray:
    """Cross products (…) of vectors in the plane (…, 2)."""
    product: FloatArray = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return product


def crossing(points: FloatArray) -> tuple[int, int] | None:
    """The first pair of edges of a polygon, not neighbors, that meet; None if there is none."""
    ends = np.roll(points, -1, axis=0)
    number = len(points)
    for one in range(number - 2):
        others = np.arange(one + 2, number - (one == 0))
        if not len(others):
            continue
        a, b, c, d = points[one], ends[one], points[others], ends[others]
        sides = [cross(b - a, c - a), cross(b - a, d - a), cross(d - c, a - c), cross(d - c, b - c)]
        apart = (np.maximum(a, b) < np.minimum(c, d)).any(axis=1) | (np.maximum(c, d) < np.minimum(a, b)).any(axis=1)
        meets = (sides[0] * sides[1] <= 0.0) & (sides[2] * sides[3] <= 0.0) & ~apart
        if meets.any():
            return one, int(others[np.argmax(meets)])
    return None


def area(loop: FloatArray) -> float:
    """The area of a polygon (K, 2), negative if it is clockwise."""
    return 0.5 * float(cross(loop - loop[0], np.roll(loop, -1, axis=0) - loop[0]).sum())


def simplified(loop: FloatArray, tolerance: float) -> FloatArray:
    """A polygon with fewer vertices, none of which is left out if it is farther than `tolerance` from its side.

    The vertices that are farthest apart remain. A polygon that would cross itself is simplified less.
    """
    start = int(np.argmax(lengths(loop - loop.mean(axis=0))))
    loop = np.roll(loop, -start, axis=0)
    closed = np.concatenate([loop, loop[:1]])
    while True:
        kept = np.zeros(len(closed), dtype=np.bool_)
        far = int(np.argmax(lengths(loop - loop[0])))
        kept[[0, far]] = True
        pending = [(0, far), (far, len(loop))]
        while pending:
            first, last = pending.pop()
            if last - first < 2:
                continue
            away = _distances(closed[first + 1 : last], closed[first], closed[last])
            if away.max() > tolerance:
                middle = first + 1 + int(np.argmax(away))
                kept[middle] = True
                pending += [(first, middle), (middle, last)]
        found = loop[kept[:-1]]
        if tolerance < INSIDE or crossing(found) is None:
            return found
        tolerance *= 0.5


def _distances(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """The distances (K,) of points (K, 2) from a segment."""
    way = end - start
    size = float(dots(way, way))
    along = np.clip(((points - start) * way).sum(axis=1) / size, 0.0, 1.0) if size > 0.0 else np.zeros(len(points))
    return lengths(points - start - along[:, np.newaxis] * way)
