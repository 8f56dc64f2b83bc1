"""Packing of the arrays of a page: the reverse, written out here, gives them back within half a step."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from physcore.film.page.packing import COLORS, Pack, reduced

FRAMES = st.lists(
    st.one_of(
        st.none(),
        st.integers(0, 5).flatmap(
            lambda rows: arrays(np.float32, (rows, 2), elements=st.floats(-1e6, 1e6, width=32, allow_subnormal=False))
        ),
    ),
    min_size=1,
    max_size=6,
).filter(lambda frames: any(each is not None and len(each) for each in frames))


def unpacked(spec: dict[str, Any], content: bytes, count: int) -> list[np.ndarray]:
    """The whole numbers of a stream, frame by frame: what `packing.js` does."""
    rows = spec["rows"] if isinstance(spec["rows"], list) else [spec["rows"]] * count
    word, columns = (np.uint8 if spec["bits"] <= 8 else np.uint16), spec["columns"]
    size, planes = spec["size"], range(np.dtype(word).itemsize)
    zigzag = sum(np.frombuffer(content, np.uint8, size, spec["at"] + k * size).astype(int) << (8 * k) for k in planes)
    steps = ((zigzag >> 1) ^ -(zigzag & 1)).reshape(columns, -1).T
    found: list[np.ndarray] = []
    before: list[np.ndarray] = []
    start = 0
    for number in rows:
        step, start = steps[start : start + number], start + number
        if not before or len(before[-1]) != number or number == 0:
            before = []
        if not before or spec["order"] == 0:
            values = np.cumsum(step, axis=0)
        elif spec["order"] == 1 or len(before) == 1:
            values = before[-1] + step
        else:
            values = 2 * before[-1].astype(int) - before[-2] + step
        found.append(values.astype(word))
        before = [*before, found[-1]] if number else []
    return found


def whole(pack: Pack) -> bytes:
    """The content of a pack, deflated and inflated."""
    return zlib.decompressobj(-15).decompress(pack.deflated(b"head"))[4:]


@given(FRAMES, st.sampled_from([12, 14, 16]))
def test_places_come_back_within_half_a_step(frames: list[np.ndarray | None], bits: int) -> None:
    """Frames of any numbers of rows, or none. A step is the extent over 2^bits − 1; a number of single precision is
    off by 2⁻²⁴ of the largest.
    """
    pack = Pack(bits)
    pack.content += b"others "
    spec = pack.moving("places", frames)
    content = whole(pack)
    assert content == bytes(pack.content)
    if spec["kind"] == "still":
        values = np.frombuffer(content, "<f4", spec["rows"] * spec["columns"], spec["at"]).reshape(spec["rows"], -1)
        for index, each in enumerate(frames):
            shown = spec["shown"] is None or spec["shown"][index]
            assert shown == (each is not None)
            assert each is None or np.array_equal(values, each)
        return
    low, high = np.array(spec["low"]), np.array(spec["high"])
    step = (high - low) / (2**bits - 1)
    for back, each in zip(unpacked(spec, content, len(frames)), frames, strict=True):
        assert len(back) == (0 if each is None else len(each))
        if each is not None:
            assert (np.abs(low + back * step - each) <= 0.5 * step + 1e-12 * (np.abs(low) + np.abs(high))).all()


def test_a_straight_path_costs_nothing() -> None:
    """Its second differences are zero but for rounding: 2⁻¹⁶ of 16 bits each, and little of that."""
    rng = np.random.default_rng(1)
    start, way = rng.random((1000, 2)), 0.01 * (rng.random((1000, 2)) - 0.5)
    pack = Pack()
    spec = pack.moving("places", [(start + k * way).astype(np.float32) for k in range(60)])
    assert spec["order"] == 2
    # Rounding of three places that are each off by up to half a step has a variance of 6/12: 1.6 bits of entropy.
    assert len(pack.deflated(b"")) < 1000 * 2 * (60 * 2.2 + 2 * 16) / 8


@pytest.mark.parametrize("count", [3, COLORS, 5000])
def test_colors_come_back(count: int) -> None:
    """Few ones exactly, many to the nearest of those that stand for them."""
    rng = np.random.default_rng(2)
    ramp = rng.integers(0, 256, (count, 4), dtype=np.uint8)
    frames = [ramp[rng.permutation(count)[: count // 2 + 1]] for _ in range(4)]
    pack = Pack()
    spec = pack.moving("inks", frames)
    table = np.array(spec["table"], dtype=np.uint8).reshape(-1, 4)
    assert len(table) <= COLORS
    for back, each in zip(unpacked(spec, whole(pack), 4), frames, strict=True):
        error = np.abs(table[back[:, 0]].astype(int) - each)
        assert error.max() == 0 if count <= COLORS else error.max() < 128


def test_many_shades_of_a_scale_are_hardly_off() -> None:
    """A scale of 1000 colors along a line: 128 of them are a step of 2 of 255 apart."""
    share = np.linspace(0.0, 1.0, 1000)[:, np.newaxis]
    colors = np.round(share * [200, 60, 90, 0] + [20, 120, 30, 255]).astype(np.uint8)
    table, index = reduced(colors, np.ones(1000, dtype=np.int64))
    assert np.abs(table[index].astype(int) - colors).max() <= 2
    assert (np.diff(index) >= 0).all() or (np.diff(index) <= 0).all()  # neighbors are alike
