"""Frayed edges of woven cloth: threads that stick out where it has torn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physcore.checks import BoolArray, FloatArray, IntArray

LENGTHS = (0.3, 1.1)
"""Least and greatest length of a loose thread, in lengths of the torn edge."""
CURL = 0.35
"""Largest sideways deviation of the end of a thread, over its length."""
PARTS = 3
"""Number of straight parts of a thread."""
SPACED = 1.25
"""Least distance of loose threads [pixels]; of finer ones every second is drawn, or fewer."""


@dataclass(frozen=True)
class Frays:
    """Loose threads of one frame."""

    points: FloatArray
    """Points along each thread (K, PARTS + 1, D) [m]."""
    faces: IntArray
    """The face (K,) from which each hangs."""


def torn_edges(faces: IntArray, shown: BoolArray) -> tuple[IntArray, IntArray]:
    """The edges along which a cloth has torn: ends and opposite corner (M, 3), and the face (M,) on the side that is
    left. An edge has torn if only one of its two faces (T, 3) is shown.
    """
    corners = faces[:, [[0, 1, 2], [1, 2, 0], [2, 0, 1]]].reshape(-1, 3)
    keys = np.sort(corners[:, :2], axis=1) @ [int(faces.max(initial=0)) + 1, 1]
    _, edge = np.unique(keys, return_inverse=True)
    seen = np.repeat(shown, 3)
    torn = seen & (np.bincount(edge)[edge] > 1) & (np.bincount(edge, weights=seen)[edge] == 1.0)
    return corners[torn], np.flatnonzero(torn) // 3


def frays(positions: FloatArray, threads: FloatArray, faces: IntArray, shown: BoolArray, width: float) -> Frays:
    """The loose threads of a torn cloth.

    Each thread that crosses a torn edge sticks out of it, in its own direction in the cloth. Lengths and curls are
    different for each thread, and the same in all frames.

    Args:
        positions: particles (N, D) [m].
        threads: coordinates of the particles (N, 2) across the two sets of threads [threads].
        faces: corners of the faces (T, 3).
        shown: the faces that are left (T,).
        width: width of a thread in the picture [pixels].
    """
    ends, owners = torn_edges(faces, shown)
    stride = max(1, int(np.ceil(SPACED / max(width, 1e-9))))
    found, where = [np.empty((0, PARTS + 1, positions.shape[1]))], [np.empty(0, dtype=np.int64)]
    for axis in (0, 1):
        edge, share, number = _crossings(threads[ends[:, :2], axis], stride)
        corners, places = positions[ends[edge]], threads[ends[edge]]
        along, across = _derivatives(corners, places)[:, [1 - axis, axis]].swapaxes(0, 1)
        # The opposite corner is inside: the thread leaves on the other side of the edge.
        side = places[:, 1] - places[:, 0]
        inward = places[:, 2] - places[:, 0]
        turn = side[:, 0] * inward[:, 1] - side[:, 1] * inward[:, 0]
        outward = np.sign(turn * (side[:, 1] if axis == 1 else -side[:, 0]))
        chance = _chances(ends[edge, 0] + ends[edge, 1], number, axis)
        reach = np.linalg.norm(side, axis=1) * (LENGTHS[0] + (LENGTHS[1] - LENGTHS[0]) * chance[0])
        sideways = CURL * (2.0 * chance[1:] - 1.0) * reach
        root = corners[:, 0] + share[:, np.newaxis] * (corners[:, 1] - corners[:, 0])
        straight = (outward * reach)[:, np.newaxis] * along
        curl = sideways[0][:, np.newaxis] * across
        if positions.shape[1] == 3:
            normal = np.cross(along, across)
            size = np.sqrt(np.maximum(np.linalg.norm(normal, axis=1), 1e-300))  # its square is an area
            curl = curl + (sideways[1] / size)[:, np.newaxis] * normal
        steps = (np.arange(PARTS + 1) / PARTS)[np.newaxis, :, np.newaxis]
        found.append(root[:, np.newaxis] + steps * straight[:, np.newaxis] + steps * steps * curl[:, np.newaxis])
        where.append(owners[edge])
    return Frays(np.concatenate(found), np.concatenate(where))


def _crossings(places: FloatArray, stride: int) -> tuple[IntArray, FloatArray, IntArray]:
    """The threads between two coordinates (M, 2): edges (K,), fractions (K,) along them, and numbers of threads (K,).
    The middles of threads are half a thread beside whole numbers.
    """
    low, high = places.min(axis=1), places.max(axis=1)
    first = np.ceil((low - 0.5) / stride).astype(np.int64)
    counts = np.floor((high - 0.5) / stride).astype(np.int64) - first + 1
    counts = np.where(high > low, np.maximum(counts, 0), 0)
    edge = np.repeat(np.arange(len(places)), counts)
    number = stride * (first[edge] + np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts))
    start, end = places[edge].T
    return edge, (number + 0.5 - start) / (end - start), number


def _derivatives(corners: FloatArray, places: FloatArray) -> FloatArray:
    """The derivatives (K, 2, D) of the position in triangles with respect to the coordinates of threads."""
    steps = places[:, 1:] - places[:, :1]
    ways = corners[:, 1:] - corners[:, :1]
    area = steps[:, 0, 0] * steps[:, 1, 1] - steps[:, 0, 1] * steps[:, 1, 0]
    area = np.where(np.abs(area) < 1e-12, np.inf, area)[:, np.newaxis]
    first = (ways[:, 0] * steps[:, 1, 1, np.newaxis] - ways[:, 1] * steps[:, 0, 1, np.newaxis]) / area
    second = (ways[:, 1] * steps[:, 0, 0, np.newaxis] - ways[:, 0] * steps[:, 1, 0, np.newaxis]) / area
    return np.stack([first, second], axis=1)


def _chances(edge: IntArray, number: IntArray, axis: int) -> FloatArray:
    """Three numbers (3, K) from 0 to 1 for each thread of an edge: bits of a product, as of a hash."""
    mixed: NDArray[np.uint64] = edge.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= (number * 2 + axis).astype(np.uint64) * np.uint64(0xC2B2AE3D27D4EB4F)
    mixed ^= mixed >> np.uint64(29)
    mixed *= np.uint64(0xBF58476D1CE4E5B9)
    parts = [(mixed >> np.uint64(shift)) & np.uint64(0xFFFF) for shift in (16, 32, 48)]
    return np.stack(parts).astype(float) / 0xFFFF
