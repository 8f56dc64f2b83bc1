"""Shapes from masks, images and texts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from PIL import Image

import physcore as pc
from physcore.scene.outlines import area, outlines, simplified

N = 200
X, Y = np.meshgrid((np.arange(N) + 0.5) / N, 1.0 - (np.arange(N) + 0.5) / N)
"""Centers of the pixels of a mask of height 1 m [m]; y points up."""


def coverage(radius: float, x: float = 0.5, y: float = 0.5) -> np.ndarray:
    """Values of a disc with an edge one pixel wide, 1/2 at the radius."""
    return np.clip(0.5 + N * (radius - np.hypot(X - x, Y - y)), 0.0, 1.0)


@pytest.mark.parametrize("tolerance", [0.0005, 0.002, 0.01])
def test_a_disc_has_its_area_center_and_moment_within_the_tolerance(tolerance):
    """All points of the outline are within the tolerance, and the bend of the circle in a pixel, of the circle."""
    shape = pc.polygon_from_mask(coverage(0.3, 0.45, 0.55), tolerance=tolerance)
    assert isinstance(shape, pc.Polygon)
    off = tolerance + 0.02 / N
    assert abs(np.hypot(*(shape.vertices - (0.45, 0.55)).T) - 0.3).max() < off
    assert math.pi * (0.3 - off) ** 2 < shape.area < math.pi * (0.3 + off) ** 2
    assert shape.center == pytest.approx((0.45, 0.55), abs=off)
    # A chord of an arc a has the sagitta r a²/8; splits at the farthest point make up to twice as many chords.
    assert len(shape.vertices) <= 2.5 * 2.0 * math.pi / math.sqrt(8.0 * tolerance / 0.3)


def test_a_bool_mask_has_straight_sides_through_the_edges_of_its_pixels():
    mask = np.zeros((10, 20), dtype=bool)
    mask[2:9, 3:17] = True
    shape = pc.polygon_from_mask(mask, height=10.0, tolerance=0.0)
    assert np.ptp(shape.vertices, axis=0) == pytest.approx((14.0, 7.0))
    assert shape.vertices.min(axis=0) == pytest.approx((3.0, 1.0))
    assert shape.area == pytest.approx(14.0 * 7.0 - 4 * 0.125)  # a corner is the half of a quarter of a pixel less


def test_a_ring_keeps_its_hole_and_its_symmetry():
    """Parts abut at the cut, where each of its four corners lacks at most half a pixel squared."""
    shape = pc.polygon_from_mask(coverage(0.4) - coverage(0.2), tolerance=1e-4)
    assert isinstance(shape, pc.Compound)
    assert len(shape.shapes) == 2
    assert shape.area == pytest.approx(math.pi * (0.16 - 0.04), abs=8.0 / N**2 + 2.0 * math.pi * 0.6 * 1.2e-4)
    assert shape.center == pytest.approx((0.5, 0.5), abs=2.0 / N)
    assert shape.moment == pytest.approx(0.5 * math.pi * (0.4**4 - 0.2**4), rel=5e-3)


def test_pieces_and_nested_holes_are_parts():
    mask = (coverage(0.45) - coverage(0.35) + coverage(0.25) - coverage(0.1)) > 0.5
    shape = pc.polygon_from_mask(mask, height=1.0)
    pixels = mask.sum() / N**2
    assert shape.area == pytest.approx(pixels, rel=0.01)


@pytest.mark.parametrize("seed", range(20))
def test_outlines_of_noise_are_closed_and_enclose_its_pixels(seed):
    """The curves of a bool mask enclose its pixels: a corner takes or gives an eighth of one."""
    mask = np.random.default_rng(seed).random((12, 15)) < 0.5
    loops = outlines(mask.astype(float))
    for loop in loops:
        assert len(loop) >= 4
        assert np.abs(np.roll(loop, -1, axis=0) - loop).max() <= 1.0
    padded = np.pad(mask, 1)
    squares = sum(padded[i : i + 13, j : j + 16].astype(int) for i in (0, 1) for j in (0, 1))
    diagonal = padded[:-1, :-1] & padded[1:, 1:] | padded[1:, :-1] & padded[:-1, 1:]
    inside = np.select([squares == 1, squares == 2, squares == 3, squares == 4], [0.125, 0.5, 0.875, 1.0])
    inside[(squares == 2) & diagonal] = 0.25
    assert sum(map(area, loops)) == pytest.approx(inside.sum())


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("tolerance", [0.1, 0.5, 2.0])
def test_simplified_polygons_are_near_and_do_not_cross(seed, tolerance):
    rng = np.random.default_rng(seed)
    angles = 2.0 * math.pi * np.arange(200) / 200
    radius = 20.0 + np.cumsum(rng.normal(size=200)) * np.sin(0.5 * angles)
    loop = np.maximum(radius, 2.0)[:, np.newaxis] * np.column_stack([np.cos(angles), np.sin(angles)])
    found = simplified(loop, tolerance)
    pc.Polygon(found)
    ends = np.roll(found, -1, axis=0) - found
    for point in loop:
        along = np.clip(((point - found) * ends).sum(axis=1) / (ends**2).sum(axis=1), 0.0, 1.0)
        assert np.hypot(*(found + along[:, np.newaxis] * ends - point).T).min() <= tolerance * (1.0 + 1e-12)


def test_an_image_is_its_opacity_or_its_darkness(tmp_path):
    values = coverage(0.3)
    dark = Image.fromarray((255.0 * (1.0 - values)).astype(np.uint8))
    clear = Image.new("RGBA", dark.size, (200, 200, 200, 0))
    clear.putalpha(Image.fromarray((255.0 * values).astype(np.uint8)))
    dark.save(tmp_path / "dark.png")
    clear.save(tmp_path / "clear.png")
    for name in ("dark.png", "clear.png"):
        for path in (tmp_path / name, str(tmp_path / name)):
            assert pc.polygon_from_mask(path, height=2.0).area == pytest.approx(4.0 * math.pi * 0.09, rel=0.02)


def test_letters_have_their_pieces_and_a_common_line():
    bar, dot, ring = (pc.polygon_from_mask(text, height=0.2) for text in ("l", ".", "O"))
    assert isinstance(bar, pc.Polygon)
    assert isinstance(ring, pc.Compound)
    assert bar.vertices[:, 1].min() == pytest.approx(dot.vertices[:, 1].min(), abs=0.005)
    assert bar.vertices[:, 1].max() > 3.0 * np.ptp(dot.vertices[:, 1])
    ring = pc.RigidBody(ring, (0.0, 0.3), friction=0.5)
    recording = pc.simulate(pc.Scene(ring, pc.Gravity(), pc.Floor(0.0, restitution=0.0)), 1.0, dt=1 / 480)
    assert recording[ring].positions[-1, 0, 1] > 0.05  # it stands on its outline
    assert abs(recording.energy.drift).max() < 1e-3


@pytest.mark.parametrize(
    ("mask", "message"),
    [
        (np.zeros((5, 5)), "must have a piece that is larger than the tolerance, got none"),
        ("", "must have a piece"),
        (" ", "must have a piece"),
        ("\U0001f600", "no face has the signs"),
        ("no such file.png", "there is no file 'no such file.png'"),
        (np.full((3, 3), 2.0), "from 0 to 1"),
        (np.full((3, 3), np.nan), "from 0 to 1, got nan"),
        (np.zeros(3), r"must be an array \(rows, columns\)"),
        (None, "mask"),
    ],
)
def test_what_has_no_outline_is_refused(mask, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.polygon_from_mask(mask)


def test_a_file_that_is_no_image_is_refused(tmp_path):
    (tmp_path / "note.png").write_text("no image")
    with pytest.raises(pc.SceneError, match=r"polygon_from_mask.mask: .*note\.png: cannot be read"):
        pc.polygon_from_mask(tmp_path / "note.png")


def test_a_picture_that_is_too_large_to_be_opened_is_refused(tmp_path, monkeypatch):
    """Pillow warns of more pixels than a limit, and refuses twice as many."""
    Image.new("L", (20, 20)).save(tmp_path / "map.png")
    for limit in (300, 150):
        monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", limit)
        with pytest.raises(pc.SceneError, match=r"polygon_from_mask.mask: .*map\.png: .*decompression bomb"):
            pc.polygon_from_mask(tmp_path / "map.png")


@pytest.mark.parametrize(("name", "value"), [("height", 0.0), ("height", math.inf), ("tolerance", -1.0)])
def test_sizes_out_of_range_are_refused(name, value):
    with pytest.raises(pc.SceneError, match=f"polygon_from_mask.{name}"):
        pc.polygon_from_mask(np.ones((3, 3)), **{name: value})
