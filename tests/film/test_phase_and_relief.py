"""Wave functions as hue and brightness, fields as lit surfaces: colors of known values, sizes, and bad arguments."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import physcore as pc
from physcore.film import DARK, LIGHT, Orbit, Window
from physcore.film.styles.phase import circle
from physcore.simulation.sources import sources

SIZE = (240, 180)
PLAIN: dict[str, Any] = {"size": SIZE, "labels": (), "color_bar": False, "sidecar": False}
WINDOW = Window((0.0, 0.0), (4.0, 3.0))
"""60 pixels per meter."""


def still(item: pc.System, path: Path, **options: Any) -> np.ndarray:
    """A picture (H, W, 3) of a system that stands still."""
    recording = pc.simulate(pc.Scene(item), 0.02, 100.0, dt=0.001, progress=False)
    pc.film(recording, path / "still.png", **{**PLAIN, **options})
    with Image.open(path / "still.png") as image:
        return np.asarray(image.convert("RGB")).astype(float)


def function(values: Any, **options: Any) -> pc.Schrodinger:
    """ψ over 4 m × 3 m, of a mass that does not let it change, nor its phase by more than 1e-6 rad."""
    grid = pc.Grid.over((0.0, 0.0), (4.0, 3.0), 0.05, periodic=True)
    return pc.Schrodinger(grid, values, **{"mass": 1e9, **options})


def linear(colors: np.ndarray) -> np.ndarray:
    """sRGB, 0 to 255, as light. Source: IEC 61966-2-1."""
    share = colors / 255.0
    return np.where(share > 0.04045, ((share + 0.055) / 1.055) ** 2.4, share / 12.92)


def oklab(colors: np.ndarray) -> np.ndarray:
    """Lightness, green to red, blue to yellow. Source: B. Ottosson, "A perceptual color space for image processing",
    2020: the matrices there that go from colors to Oklab, where the film goes back.
    """
    cones = np.array(
        [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566],
         [0.0883024619, 0.2817188376, 0.6299787005]]
    )  # fmt: skip
    mixed = np.array(
        [[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099],
         [0.0259040371, 0.7827717662, -0.8086757660]]
    )  # fmt: skip
    return np.cbrt(linear(colors) @ cones.T) @ mixed.T


@pytest.mark.parametrize("turns", [0, 1, 2, 3])
def test_the_hue_is_the_phase(turns: int, tmp_path: Path) -> None:
    """Four quarters of the plane, a quarter of a turn apart: at full density the hue angle in Oklab is the phase,
    within a step of the table, and lightness and chroma are those of all hues, within the rounding of pixels.
    """
    picture = still(
        function(lambda x, y: np.exp(0.5j * np.pi * (turns + (x > 2.0) + 2.0 * (y > 1.5)))),
        tmp_path,
        style=pc.styles.Phase(range=1.0),
        camera=WINDOW,
    )
    for row, column, quarter in ((135, 60, 0), (135, 180, 1), (45, 60, 2), (45, 180, 3)):
        light, red, yellow = oklab(picture[row, column])
        off = np.angle(np.exp(1j * (np.arctan2(yellow, red) - 0.5 * np.pi * (turns + quarter))))
        assert abs(off) < 2.0 * np.pi / 256 + 0.01
        assert light == pytest.approx(0.74, abs=0.005)
        assert np.hypot(red, yellow) == pytest.approx(0.125, abs=0.005)


def test_the_brightness_is_the_density(tmp_path: Path) -> None:
    """From the background, where nothing is, up to the hue; a density above the range is no brighter. Four stripes of
    densities 0, 1/4, 1 and 4 with the range 1, and the same of a quarter of them with a quarter of the range.
    """
    stripes = np.array([0.0, 0.5, 1.0, 2.0])

    def amplitude(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.exp(0.3j) * stripes[np.minimum(x, 3.9).astype(int)] * np.ones_like(y)

    pictures = [
        still(function(amplitude), tmp_path, style=pc.styles.Phase(range=1.0), camera=WINDOW),
        still(function(lambda x, y: 0.5 * amplitude(x, y)), tmp_path, style=pc.styles.Phase(range=0.25), camera=WINDOW),
    ]
    assert np.array_equal(*pictures)
    nothing, faint, full, beyond = pictures[0][90, [30, 90, 150, 210]]
    ground = np.array(DARK.background, dtype=float)
    np.testing.assert_allclose(nothing, ground, atol=1.0)
    np.testing.assert_allclose(beyond, full)
    share = (faint - ground) @ (full - ground) / ((full - ground) @ (full - ground))
    assert share == pytest.approx(0.25**0.55, abs=0.01)
    np.testing.assert_allclose(faint, ground + share * (full - ground), atol=1.0)


def test_without_a_range_the_film_s_largest_density_is_full_brightness(tmp_path: Path) -> None:
    for scale in (1e-3, 1e3):
        picture = still(function(lambda x, y, scale=scale: scale + 0.0 * x * y), tmp_path, camera=WINDOW)
        np.testing.assert_allclose(oklab(picture[90, 120])[0], 0.74, atol=0.01)


DEFICIENCIES = {
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
}
"""What is seen without one kind of cones, of linear light. Source: G. M. Machado, M. M. Oliveira, L. A. F. Fernandes,
IEEE Trans. Vis. Comput. Graph. 15, 1291 (2009), severity 1."""


@pytest.mark.parametrize("deficiency", DEFICIENCIES)
def test_the_color_blind_tell_phases_apart_in_blue_and_yellow(deficiency: str) -> None:
    """Eight phases of "blue-yellow" stay apart by more than 0.05 in Oklab, a quarter of the circle's radius; those of
    "hues" do not.
    """

    def least(palette: Any) -> float:
        phases = circle(palette)[16::32]
        seen = np.clip(linear(phases) @ np.array(DEFICIENCIES[deficiency]).T, 0.0, 1.0)
        encoded = np.where(seen > 0.0031308, 1.055 * seen ** (1 / 2.4) - 0.055, 12.92 * seen) * 255.0
        places = oklab(encoded)
        apart = np.linalg.norm(places[:, np.newaxis] - places, axis=2)
        return float(apart[np.triu_indices(8, 1)].min())

    assert least("blue-yellow") > 0.05
    assert least("hues") < 0.05


@pytest.mark.parametrize("palette", ["hues", "blue-yellow"])
def test_the_circle_of_phases_is_closed_and_even(palette: Any) -> None:
    """No step between neighbors, over the seam at ±π too, is more than twice the mean one."""
    table = oklab(circle(palette))
    steps = np.linalg.norm(table - np.roll(table, 1, axis=0), axis=1)
    assert steps.max() < 2.0 * steps.mean()


@pytest.mark.parametrize(("theme", "colors"), [("dark", DARK), ("light", LIGHT)])
def test_a_picture_of_a_wave_function_is_where_its_cells_are(theme: Any, colors: Any, tmp_path: Path) -> None:
    """From 1 m to 3 m and 1 m to 2 m of a window of 4 m × 3 m; a line around it where it is shut, none where not."""
    for periodic in (False, True):
        grid = pc.Grid((40, 20), 0.05, origin=(1.0, 1.0), periodic=periodic)
        wave = pc.Schrodinger(grid, lambda x, y: 1.0 + 0.0 * x * y, mass=1e9)
        picture = still(wave, tmp_path, style=pc.styles.Phase(range=1.0), camera=WINDOW, theme=theme)
        assert picture.shape == (180, 240, 3)
        apart = np.abs(picture - np.array(colors.background)).max(axis=2) > 3.0
        rows, columns = np.flatnonzero(apart.any(axis=1)), np.flatnonzero(apart.any(axis=0))
        edge = 1 if not periodic else 0
        assert rows[0] in (60 - edge, 60)
        assert rows[-1] in (119, 119 + edge)
        assert columns[0] in (60 - edge, 60)
        assert columns[-1] in (179, 179 + edge)
        middle = picture[90, 120]
        assert (np.abs(picture[90, [60, 179]] - middle).max() > 3.0) is np.bool_(not periodic)


def test_a_potential_shows_faintly(tmp_path: Path) -> None:
    """Where there is no density, the higher side of a step is brighter; a level one is not seen."""
    quiet = {"style": pc.styles.Phase(range=1e6), "camera": WINDOW}
    step = still(function(lambda x, y: 1.0 + 0.0 * x * y, potential=lambda x, y: 1e-6 * (x > 2.0)), tmp_path, **quiet)
    level = still(function(lambda x, y: 1.0 + 0.0 * x * y, potential=1e-6), tmp_path, **quiet)
    ground = np.array(DARK.background, dtype=float)
    np.testing.assert_allclose(level[90, [60, 180]], [ground, ground], atol=2.0)
    np.testing.assert_allclose(step[90, 60], ground, atol=2.0)
    rise = (step[90, 180] - ground) / (np.array(DARK.text) - ground)
    np.testing.assert_allclose(rise, 0.22, atol=0.02)


@pytest.mark.parametrize(
    ("style", "message"),
    [
        (lambda: pc.styles.Phase("rainbow"), r"Phase\.palette: must be 'hues' or 'blue-yellow', got 'rainbow'"),
        (lambda: pc.styles.Phase(range=0.0), r"Phase\.range: must be > 0"),
        (lambda: pc.styles.Phase(range="all"), r"Phase\.range: must be a number"),
        (lambda: pc.styles.Phase(on=3), r"Phase\.on: must be a system of the scene"),
        (lambda: pc.styles.Relief(height=0.0), r"Relief\.height: must be > 0"),
        (lambda: pc.styles.Relief(range=-1.0), r"Relief\.range: must be > 0"),
        (lambda: pc.styles.Relief(gloss=2.0), r"Relief\.gloss: must be ≤ 1"),
        (lambda: pc.styles.Relief(gloss=-0.1), r"Relief\.gloss: must be ≥ 0"),
        (lambda: pc.styles.Relief(sky=1.5), r"Relief\.sky: must be ≤ 1"),
        (lambda: pc.styles.Relief(sky="blue"), r"Relief\.sky: must be a number"),
        (lambda: pc.styles.Relief(colormap="rainbow cake"), r"Relief\.colormap: "),
    ],
)
def test_what_is_wrong_with_a_style_is_said(style: Any, message: str) -> None:
    with pytest.raises(pc.SceneError, match=message):
        style()


def test_a_system_that_a_style_cannot_draw_is_refused(tmp_path: Path) -> None:
    line = pc.Schrodinger(pc.Grid((8,), 0.5), np.ones(8))
    sea = pc.Wave(pc.Grid((8, 6), 0.5), 1.0)
    for item, style, message in (
        (
            line,
            pc.styles.Phase(on=line),
            r"Phase\.on: .* is no wave function in 2D; use Field\(\) in 3D, Line\(\) in 1D",
        ),
        (sea, pc.styles.Phase(on=sea), r"Phase\.on: .* is no wave function in 2D"),
        (line, pc.styles.Relief(on=line), r"Relief\.on: .* no field on a grid in 2D; .* Line\(\) in 1D"),
        (
            sea,
            pc.styles.Relief("density", on=sea),
            r"Relief\.quantity: must be one of displacement, rate, got 'density'",
        ),
    ):
        with pytest.raises(pc.SceneError, match=message):
            still(item, tmp_path, style=style)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("colormap", [None, "viridis"])
def test_level_ground_of_a_relief_has_the_colors_of_its_scale(colormap: Any, share: float, tmp_path: Path) -> None:
    """The lamp's light on it is 1, and nothing shines with gloss 0 and sky 0. A wave is signed: −1 is at the lower end
    of the scale, 0 in its middle. Haze mixes the middle of the block with the background, by up to a fifth.
    """
    wave = pc.Wave(pc.Grid((40, 30), 0.1, periodic=True), 0.0, share)
    style = pc.styles.Relief(range=1.0, colormap=colormap, gloss=0.0, sky=0.0)
    recording = pc.simulate(pc.Scene(wave), 0.02, 100.0, dt=0.001, progress=False)
    (source,) = sources(recording, None, None, {})  # type: ignore[arg-type]
    (painter,) = style.painters(source, recording.scene.systems, DARK)
    scale = painter.scale
    assert scale is not None
    assert scale.ends == (-1.0, 1.0)
    assert np.abs(np.diff(scale.table, axis=0)).max() < 8.0, "the bar is smooth"
    picture = still(wave, tmp_path, style=style, camera=Orbit(elevation=60.0))
    assert picture.shape == (180, 240, 3)
    haze = np.linspace(0.0, 0.2, 41)[:, np.newaxis, np.newaxis]
    apart = np.linalg.norm((1.0 - haze) * scale.table + haze * np.array(DARK.background) - picture[90, 120], axis=2)
    assert apart.min(axis=0).argmin() / len(scale.table) == pytest.approx(0.5 + 0.5 * share, abs=0.04)
    assert apart.min() < 3.0


def test_a_pond_reflects_the_sky_most_at_flat_angles(tmp_path: Path) -> None:
    """Water reflects 2 % from above and 42 % at 8° (the fifth power of Schlick); the sky is brighter than the pond. A
    color scale is not covered by reflections unless that is asked for.
    """
    wave = pc.Wave(pc.Grid((40, 30), 0.1, periodic=True), 0.0, 0.5)

    def middle(elevation: float, **values: Any) -> float:
        style, camera = pc.styles.Relief(range=1.0, gloss=0.0, **values), Orbit(elevation=elevation)
        return float(still(wave, tmp_path, style=style, camera=camera)[90, 120].mean())

    from_above, flat = (middle(angle, sky=1.0) - middle(angle, sky=0.0) for angle in (89.0, 8.0))
    assert 0.0 < from_above < 0.25 * flat
    assert middle(30.0) == middle(30.0, sky=1.0) != middle(30.0, sky=0.0)
    assert middle(30.0, colormap="viridis") == middle(30.0, colormap="viridis", sky=0.0)


def test_a_density_rises_from_zero_in_a_relief(tmp_path: Path) -> None:
    """Half of the range is half as high, though ψ goes below zero: bodies float there."""
    grid = pc.Grid((40, 30), 0.1, periodic=True)
    wave = pc.Schrodinger(grid, lambda x, y: -np.sqrt(0.5) + 0.0 * x * y, mass=1e9)
    floats = pc.Particles([[1.0, 1.0], [2.5, 2.0]])
    recording = pc.simulate(pc.Scene(wave, floats), 0.02, 100.0, dt=0.001, progress=False)
    (source,) = sources(recording, None, None, {})  # type: ignore[arg-type]
    style = pc.styles.Relief("density", range=1.0, height=2.0)
    (painter,) = style.painters(source, recording.scene.systems, DARK)
    assert painter.scale is not None
    assert painter.scale.ends == (0.0, 1.0)
    del tmp_path
    frame = next(iter(source.frames()))
    frame.fields["positions"] = np.pad(frame.positions, ((0, 0), (0, 3 - frame.positions.shape[1])))
    np.testing.assert_allclose(painter.raised(frame).positions[:, 2], 1.0, rtol=1e-6)


def test_walls_of_a_relief_are_level(tmp_path: Path) -> None:
    """A pond at the end of its scale, 1 m high, with a wall over x > 2: nothing of the wall rises above zero."""
    wave = pc.Wave(pc.Grid((40, 30), 0.1), 0.0, 1.0, edges="free", walls=lambda x, y: x > 2.0 + 0.0 * y)
    style = pc.styles.Relief(range=1.0, height=1.0, gloss=0.0)
    picture = still(wave, tmp_path, style=style, camera=Orbit(azimuth=-90.0, elevation=0.0))
    seen = np.abs(picture - np.array(DARK.background)).max(axis=2) > 12.0
    columns = np.flatnonzero(seen.any(axis=0))
    tops = seen.argmax(axis=0)
    pond, wall = tops[columns[len(columns) // 4]], tops[columns[3 * len(columns) // 4]]
    assert wall > pond + 10
