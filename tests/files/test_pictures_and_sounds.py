"""Pictures as ground, masks and outlines, and sounds as signals: files of Pillow, wave and scipy come back."""

from __future__ import annotations

import math
import wave

import numpy as np
import pytest
from PIL import Image

import physcore as pc

RAMP = np.linspace(0.0, 1.0, 256).reshape(1, -1).repeat(3, axis=0)
"""Brightness that grows along x, in three rows."""


def saved(path, values, mode=None):
    Image.fromarray(values, mode).save(path) if mode else Image.fromarray(values).save(path)
    return path


def test_brightness_is_indexed_as_a_field(tmp_path):
    pixels = np.zeros((2, 3), dtype=np.uint8)
    pixels[0, 2] = 255  # upper right
    pixels[1, 0] = 51  # lower left
    picture = pc.read(saved(tmp_path / "spots.png", pixels))
    assert picture.brightness.tolist() == [[0.2, 0.0], [0.0, 0.0], [0.0, 1.0]]
    assert picture.mask(0.5).tolist() == [[False, False], [False, False], [False, True]]
    assert picture.negative.brightness[0, 0] == pytest.approx(0.8)


@pytest.mark.parametrize("bits", [8, 16])
def test_all_bits_of_a_height_map_come_back(bits, tmp_path):
    top = 2**bits - 1
    pixels = np.random.default_rng(2).integers(0, top + 1, (5, 7)).astype(f"uint{bits}")
    pixels[0, :2] = 0, top
    ground = pc.read(saved(tmp_path / "map.png", pixels)).height_field(12.0, lowest=-1.0, highest=3.0, friction=0.1)
    assert ground.heights.shape == (7, 5)
    assert ground.spacing == 2.0
    assert ground.friction == 0.1
    np.testing.assert_allclose(ground.heights, -1.0 + 4.0 * pixels.T[:, ::-1] / top, rtol=0.0, atol=1e-14)


def test_a_float_map_keeps_its_values(tmp_path):
    values = np.array([[0.0, 2.5], [-1.0, 1e3]], dtype=np.float32)
    np.testing.assert_array_equal(pc.read(saved(tmp_path / "map.tif", values)).brightness, values.T[:, ::-1])


def test_a_transparent_picture_has_its_opacity(tmp_path):
    pixels = np.zeros((2, 2, 4), dtype=np.uint8)
    pixels[0, 0, 3] = 255
    assert pc.read(saved(tmp_path / "logo.png", pixels)).mask().tolist() == [[False, True], [False, False]]


def test_an_outline_is_that_of_the_mask(tmp_path):
    x, y = np.meshgrid(np.arange(60), np.arange(40))
    disc = np.hypot(x - 30.5, y - 20.5) < 15.0
    picture = pc.read(saved(tmp_path / "disc.png", (255 * disc).astype(np.uint8)))
    shape, direct = picture.outline(height=0.4), pc.polygon_from_mask(disc, height=0.4)
    assert shape.area == pytest.approx(direct.area)
    assert shape.area == pytest.approx(math.pi * 0.15**2, rel=0.02)  # a pixel more or less in each direction


def test_a_text_is_a_mask_and_an_outline():
    letters = pc.Picture.text("Li")
    assert letters.outline(0.3).area == pytest.approx(pc.polygon_from_mask("Li", 0.3).area)
    columns, rows = letters.mask().shape
    assert columns > 0.5 * rows
    grid = pc.Grid((columns, rows), 0.01)
    pc.Scene(pc.Wave(grid, 1.0, walls=letters.mask()))
    with pytest.raises(pc.SceneError, match=r"Picture.text: no face has the signs"):
        pc.Picture.text("\ue000")


def test_a_picture_without_contrast_is_refused(tmp_path):
    picture = pc.read(saved(tmp_path / "flat.png", np.full((4, 4), 100, dtype=np.uint8)))
    with pytest.raises(pc.SceneError, match=r"height_field: .*flat.png has no contrast: all pixels are 0.392"):
        picture.height_field(1.0, 0.0, 1.0)
    with pytest.raises(pc.SceneError, match=r"mask.level: no pixels of .*flat.png .*the picture has no contrast"):
        picture.mask()
    with pytest.raises(pc.SceneError, match="the picture has no contrast"):
        picture.outline(1.0)
    faint = pc.read(saved(tmp_path / "faint.png", (20 + 40 * RAMP).astype(np.uint8)))
    with pytest.raises(pc.SceneError, match=r"from 0.0784 to 0.235, so that 0.157 would divide them"):
        faint.mask()


def test_a_damaged_picture_is_an_error_with_its_name(tmp_path):
    (tmp_path / "bad.png").write_bytes(b"nonsense")
    with pytest.raises(pc.FileError, match=r"bad.png: "):
        pc.read(tmp_path / "bad.png")


def test_a_sound_of_the_standard_library_comes_back(tmp_path):
    pytest.importorskip("scipy", reason="scipy, which reads sounds, is not installed")
    samples = np.array([0, 16384, -32768, 32767], dtype="<i2")
    with wave.open(str(tmp_path / "click.wav"), "wb") as file:
        file.setparams((1, 2, 8000, 4, "NONE", None))
        file.writeframes(samples.tobytes())
    signal = pc.read(tmp_path / "click.wav")
    assert signal.values.tolist() == [0.0, 0.5, -1.0, 32767 / 32768]
    assert signal.rate == 8000.0
    assert signal.duration == 0.0005


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.int32, np.float32, np.float64])
def test_sounds_of_scipy_come_back(kind, tmp_path):
    wavfile = pytest.importorskip("scipy.io.wavfile", reason="scipy, which reads sounds, is not installed")
    values = np.sin(np.arange(50.0))[:, None] * [1.0, 0.5]
    if np.dtype(kind).kind == "f":
        samples = values.astype(kind)
    else:
        full = float(np.iinfo(kind).max // (2 if kind is np.uint8 else 1))
        samples = (np.rint(full * values) + (128 if kind is np.uint8 else 0)).astype(kind)
    wavfile.write(tmp_path / "tone.wav", 100, samples)
    signal = pc.read(tmp_path / "tone.wav")
    step = {np.uint8: 1 / 128, np.int16: 2.0**-15, np.int32: 2.0**-31}.get(kind, 1e-7)
    # A sample is rounded by half a step, and scaled by 127/128 or less.
    np.testing.assert_allclose(signal.values, values, rtol=0.0, atol=1.5 * step)
    left = signal.channel(0)
    assert left(0.1) == left.values[10]
    assert left(0.105) == pytest.approx(0.5 * (left.values[10] + left.values[11]))
    assert left([-0.1, 0.6]).tolist() == [0.0, 0.0]
    with pytest.raises(pc.SceneError, match="2 channels; take one"):
        signal(0.0)
    with pytest.raises(pc.SceneError, match=r"channel.index: must be ≤ 1, got 2"):
        signal.channel(2)


def test_a_signal_drives_a_wave():
    """Linear between its values, it is the function of np.interp."""
    values = np.sin(np.linspace(0.0, 6.0, 40))
    signal, times = pc.Signal(values, rate=40.0), np.arange(40) / 40.0
    fields = []
    for drive in (signal, lambda time: np.interp(time, times, values, right=0.0)):
        wave_field = pc.Wave(pc.Grid((30, 20), 0.1), 1.0, sources=[pc.Source((1.0, 1.0), 1.0, signal=drive)])
        fields.append(pc.simulate(pc.Scene(wave_field), 0.5, dt=0.02)[wave_field].displacement)
    np.testing.assert_array_equal(*fields)
    assert abs(fields[0]).max() > 1e-3


@pytest.mark.parametrize("content", [b"", b"nonsense", b"RIFF    WAVE"])
def test_a_damaged_sound_is_an_error_with_its_name(content, tmp_path):
    pytest.importorskip("scipy", reason="scipy, which reads sounds, is not installed")
    (tmp_path / "bad.wav").write_bytes(content)
    with pytest.raises(pc.FileError, match=r"bad.wav: "):
        pc.read(tmp_path / "bad.wav")
