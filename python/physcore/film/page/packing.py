"""Packing of the arrays of a film: quantized between their ends over time, predicted from frame to frame, deflated.

A stream holds one array of a track: each component over all frames, then the next one. It is one of these kinds:

- "still": the array is the same in all frames, and is kept as it is;
- "steps": whole numbers of 16 bits between the ends of each component. What is kept is the difference from a prediction
  by the frames before: of order 0 (none), 1 (the frame before) or 2 (a straight path). A frame with another number of
  rows than the one before begins anew, each row predicted by the row before. Low and high bytes are kept apart.
- "table": colors as indices of a table of at most 128, ordered by their main direction, so that neighbors are alike.

`packing.js` reverses this.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

BITS = (16, 14, 12)
"""Numbers of bits of a coordinate, the first that fits. Of 2048 pixels, 12 bits tell apart half a pixel."""
COLORS = 128
"""Largest number of colors of a table."""
TRIED = 100_000
"""Number of bytes from which the way of compression is chosen."""
WAYS = ((9, zlib.Z_HUFFMAN_ONLY), (9, zlib.Z_RLE), (6, zlib.Z_DEFAULT_STRATEGY))
"""Levels and strategies of zlib."""
EMPTY = b"\x03\x00"
"""Last block of a stream of deflate, with nothing in it."""
SAMPLE = 100_000
"""Number of values from which the order of the prediction is chosen."""


@dataclass
class Pack:
    """Bytes of many streams, with a description of each."""

    bits: int = BITS[0]
    content: bytearray = field(default_factory=bytearray)
    _ends: list[int] = field(default_factory=list)
    """Ends of the parts of the content that are compressed separately."""

    def still(self, values: NDArray[Any]) -> dict[str, Any]:
        """Keep an array as it is, in whole numbers or single precision."""
        if values.dtype.kind == "f":
            values = values.astype("<f4")
        self.content += bytes(-len(self.content) % 4)
        start = len(self.content)
        self.content += np.ascontiguousarray(values).tobytes()
        columns = values.shape[1] if values.ndim > 1 else 1
        return {"kind": "still", "at": start, "type": values.dtype.str[1:], "rows": len(values), "columns": columns}

    def moving(self, name: str, frames: list[NDArray[Any] | None], dimension: int = 0) -> dict[str, Any]:
        """Keep an array (N, C) of each frame; None where there is none.

        Columns that are the coordinates of several points in a space of some dimension share the ends of these.
        """
        known = [values for values in frames if values is not None]
        if all(values is known[0] or np.array_equal(values, known[0]) for values in known):
            return self.still(known[0]) | {"shown": None if len(known) == len(frames) else _spans(frames)}
        if name == "inks":
            return self._colors(frames)
        if known[0].dtype == np.uint8:
            return self._steps([None if each is None else each.astype(np.uint16) for each in frames], None, 8)
        if known[0].dtype.kind in "ui":
            split = [None if each is None else _halves(each) for each in frames]
            return self._steps(split, None, 16) | {"whole": True}
        every = np.concatenate(known)
        low, high = every.min(axis=0).astype(np.float64), every.max(axis=0).astype(np.float64)
        if dimension:
            low, high = (
                np.tile(pick(each.reshape(-1, dimension), axis=0), len(each) // dimension)
                for pick, each in ((np.min, low), (np.max, high))
            )
        whole = quantized(frames, low, high, self.bits)
        return self._steps(whole, (low, high), self.bits)

    def _steps(
        self,
        frames: list[NDArray[np.uint16] | None],
        ends: tuple[NDArray[np.float64], NDArray[np.float64]] | None,
        bits: int,
    ) -> dict[str, Any]:
        order = _order(frames, bits)
        parts = residuals(frames, order, bits)
        columns = next(each.shape[1] for each in frames if each is not None)
        start = len(self.content)
        self._ends.append(start)
        self.content += (parts & 255).astype(np.uint8).tobytes()
        self._ends.append(len(self.content))
        if bits > 8:
            self.content += (parts >> 8).astype(np.uint8).tobytes()
            self._ends.append(len(self.content))
        rows = [0 if each is None else len(each) for each in frames]
        even = rows[0] if len(set(rows)) == 1 else None
        found: dict[str, Any] = {"kind": "steps", "at": start, "order": order, "columns": columns, "bits": bits}
        found |= {"rows": rows if even is None else even, "size": int(parts.size)}
        if ends is not None:
            found |= {"low": ends[0].tolist(), "high": ends[1].tolist()}
        return found

    def _colors(self, frames: list[NDArray[np.uint8] | None]) -> dict[str, Any]:
        """Keep colors (N, 4 C) of each frame as indices (N, C)."""
        words = [None if each is None else np.ascontiguousarray(each).view("<u4") for each in frames]
        every = np.concatenate([each.ravel() for each in words if each is not None])
        values, inverse = np.unique(every, return_inverse=True)
        table, index = reduced(values.view(np.uint8).reshape(-1, 4), np.bincount(inverse))
        flat, at, indices = index[inverse].astype(np.uint16), 0, list[NDArray[np.uint16] | None]()
        for each in words:
            size = 0 if each is None else each.size
            indices.append(None if each is None else flat[at : at + size].reshape(each.shape))
            at += size
        return self._steps(indices, None, 8) | {"table": table.ravel().tolist()}

    def deflated(self, head: bytes) -> bytes:
        """Other bytes before all others, and all of these as one raw stream of deflate.

        Each plane is compressed in the way that suits a sample of it: noise has no repetitions, and the search for them
        takes a hundred times as long. No part refers to another, so that the parts can be joined.
        """
        ends = [0, *self._ends, len(self.content)]
        parts = [head, *(bytes(self.content[start:end]) for start, end in pairwise(ends) if end > start)]
        return b"".join(map(_deflated, parts)) + EMPTY


def _deflated(part: bytes) -> bytes:
    """A part of a raw stream of deflate, which ends at a byte and refers to no other part."""
    middle = max(0, (len(part) - TRIED) // 2)
    some = part[middle : middle + TRIED]

    def packed(content: bytes, way: tuple[int, int]) -> bytes:
        coder = zlib.compressobj(way[0], zlib.DEFLATED, -15, 9, way[1])
        return coder.compress(content) + coder.flush(zlib.Z_FULL_FLUSH)

    return packed(part, min(WAYS, key=lambda way: len(packed(some, way))))


def quantized(
    frames: list[NDArray[Any] | None], low: NDArray[np.float64], high: NDArray[np.float64], bits: int
) -> list[NDArray[np.uint16] | None]:
    """Values between ends (C,) as whole numbers from 0 to 2^bits − 1. The error is at most half a step."""
    scale = ((1 << bits) - 1) / np.where(high > low, high - low, 1.0)
    return [None if each is None else np.round((each - low) * scale).astype(np.uint16) for each in frames]


def residuals(frames: list[NDArray[np.uint16] | None], order: int, bits: int = 16) -> NDArray[Any]:
    """The differences of all frames from their predictions, zigzag: 0, −1, 1, −2, … are 0, 1, 2, 3, ….

    Differences are modulo 2¹⁶, or modulo 2⁸ for values of 8 bits.
    """
    before: list[NDArray[np.uint16]] = []
    parts: list[NDArray[np.uint16]] = []
    for values in frames:
        if values is None:
            before = []
            continue
        if before and before[-1].shape != values.shape:
            before = []
        if not before or order == 0:
            guess = np.concatenate([np.zeros_like(values[:1]), values[:-1]])
        elif order == 1 or len(before) == 1:
            guess = before[-1]
        else:
            guess = 2 * before[-1] - before[-2]
        parts.append(values - guess)
        before = [*before[-1:], values]
    word, signs = (np.uint8, np.int8) if bits <= 8 else (np.uint16, np.int16)
    signed: NDArray[np.signedinteger[Any]] = np.concatenate(parts).astype(word).T.ravel().view(signs)
    zigzag: NDArray[Any] = ((signed << 1) ^ (signed >> (8 * signed.itemsize - 1))).view(word)
    return zigzag


def reduced(colors: NDArray[np.uint8], counts: NDArray[np.int64]) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """At most COLORS colors (K, 4) for many (N, 4), and the index (N,) of the one that stands for each.

    Colors are rounded to larger and larger steps until they are few; each step has the mean of its colors.
    """
    for step in (1, 2, 4, 8, 16, 32, 64, 128):
        _, index = np.unique(colors // step, axis=0, return_inverse=True)
        index = index.ravel()
        if index.max(initial=0) < COLORS:
            break
    weights = np.bincount(index, weights=counts)
    sums = [np.bincount(index, weights=counts * channel) for channel in colors.T.astype(float)]
    means = np.stack(sums, axis=1) / weights[:, np.newaxis]
    centered = means - means.mean(axis=0)
    order = np.argsort(centered @ np.linalg.svd(centered, full_matrices=False)[2][0], kind="stable")
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return np.round(means[order]).astype(np.uint8), place[index]


def _order(frames: list[NDArray[np.uint16] | None], bits: int) -> int:
    """The order of the prediction with the smallest differences, by some frames from the middle."""
    rows = max((each.size for each in frames if each is not None), default=1)
    count = max(4, SAMPLE // max(rows, 1))
    start = max(0, (len(frames) - count) // 2)
    some = frames[start : start + count]
    cost = [float(np.log2(1.0 + residuals(some, order, bits).astype(float)).sum()) for order in (0, 1, 2)]
    return int(np.argmin(cost))


def _halves(values: NDArray[Any]) -> NDArray[np.uint16]:
    """Whole numbers (N, C) as their low and high 16 bits (N, 2 C)."""
    return np.ascontiguousarray(values.astype("<u4")).view("<u2")


def _spans(frames: list[NDArray[Any] | None]) -> list[int]:
    """Whether there is an array in each frame: 0 or 1."""
    return [int(each is not None) for each in frames]
