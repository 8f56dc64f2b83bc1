"""Films hold what happened, in real time, whole, and the same for the same recording."""

from __future__ import annotations

import base64
import io
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

import physcore as pc
from physcore._core import Canvas, Gif
from physcore.film import DARK, LIGHT, Orbit, Window, gif_bytes
from physcore.film.camera.view import fit
from physcore.film.colors.colormaps import COLORMAPS, look_up, oklab, sequential
from physcore.film.colors.themes import contrast
from physcore.film.styles.base import SystemStyle
from physcore.film.styles.strain import covered
from physcore.film.writers import delays

SIZE = (160, 120)


def recorded(
    scene: pc.Scene, motion: Callable[[np.ndarray, float], np.ndarray], count: int = 7, fps: float = 30.0
) -> Any:
    """A recording in which each particle goes where `motion` says from its initial position."""
    start = np.concatenate([body.positions for body in scene.bodies])
    times = np.arange(count) / fps
    positions = np.stack([motion(start, time) for time in times])
    velocities = np.gradient(positions, times, axis=0)
    channels = {"positions": positions, "velocities": velocities}
    return SimpleNamespace(
        scene=scene, times=times, positions=positions, velocities=velocities, fps=fps, channels=channels
    )


def shift(start: np.ndarray, time: float) -> np.ndarray:
    """Everything moves to the right."""
    return start + np.eye(start.shape[1])[0] * time


def frames(path: Path | bytes) -> tuple[list[np.ndarray], list[int]]:
    """The pictures of a GIF and their delays [ms], as Pillow reads them."""
    pictures, times = [], []
    with Image.open(io.BytesIO(path) if isinstance(path, bytes) else path) as image:
        for index in range(image.n_frames):
            image.seek(index)
            pictures.append(np.asarray(image.convert("RGB")).astype(int))
            times.append(image.info["duration"])
    return pictures, times


def ink(picture: np.ndarray, background: tuple[int, int, int] = DARK.background) -> np.ndarray:
    """Which pixels are not background."""
    return (np.abs(picture - np.array(background)) > 6).any(axis=2)


def dust(count: int, dimension: int = 2) -> pc.Particles:
    return pc.Particles(np.random.default_rng(1).uniform(size=(count, dimension)))


def net(dimension: int = 2) -> pc.SpringNetwork:
    axes = ((1.0, 0.0), (0.0, 1.0)) if dimension == 2 else ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    return pc.cloth((6, 5), spacing=0.1, stiffness=10.0, origin=(0.0,) * dimension, axes=axes, pinned="top")


SCENES = {
    "particles": pc.Scene(dust(50)),
    "one particle at rest": pc.Scene(pc.Particles([[2.0, 3.0]])),
    "no particle": pc.Scene(pc.Particles(np.empty((0, 2)))),
    "springs": pc.Scene(net(), pc.Floor(-1.0)),
    "mixed": pc.Scene(net(), dust(5), pc.Box((-0.2, -0.2), (1.5, 1.5)), pc.Sphere((0.5, 0.5), 0.2)),
    "central": pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce(center=(0.0, 0.0), strength=1.0, exponent=-2.0)),
    "3D": pc.Scene(
        net(3), dust(5, 3), pc.Floor(-0.1), pc.Sphere((0.2, 0.2, 0.1), 0.1), pc.Box((-1.0,) * 3, (2.0,) * 3)
    ),
    "grains": pc.Scene(
        pc.Particles(np.random.default_rng(1).uniform(size=(20, 2)), radius=0.05), pc.Periodic((0.0, 0.0), (1.0, 1.0))
    ),
    "strip": pc.Scene(dust(5), net(), pc.Periodic((0.0, -np.inf), (1.0, np.inf))),
    "periodic 3D": pc.Scene(net(3), dust(5, 3), pc.Periodic((0.0, 0.0, -np.inf), (1.0, 1.0, np.inf))),
    "water": pc.Scene(
        pc.Fluid.block((0.0, 0.0), (1.0, 0.5), 0.1, obstacles=False), dust(5), pc.Box((0.0, 0.0), (2.0, 1.0))
    ),
    "water 3D": pc.Scene(pc.Fluid(pc.ball((0.0, 0.0, 1.0), 0.3, 0.1), 0.1), pc.Floor()),
    "bowl": pc.Scene(dust(30, 3), pc.Sphere((0.5, 0.5, 0.5), 1.0, inside=True)),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("theme", ["dark", "light"])
def test_every_scene_gives_as_many_frames_as_were_recorded(name: str, theme: Any, tmp_path: Path) -> None:
    recording = recorded(SCENES[name], shift)
    pc.film(recording, tmp_path / "film.gif", size=SIZE, theme=theme)
    pictures, times = frames(tmp_path / "film.gif")
    assert len(pictures) == 7
    assert all(picture.shape == (120, 160, 3) for picture in pictures)
    assert set(times) <= {30, 40}


@pytest.mark.parametrize(("kind", "dimension"), [(kind, d) for kind in pc.styles.STYLES for d in kind.dimensions])
def test_every_style_draws_what_it_is_for_and_stays_inside_the_picture(
    kind: type[pc.styles.Style], dimension: int, tmp_path: Path
) -> None:
    corners = ((0.0,) * dimension, (0.5,) * dimension)
    if kind in (pc.styles.Trails, pc.styles.Density):
        count = 20 if kind is pc.styles.Trails else 2000
        cloud = np.random.default_rng(1).normal(size=(count, dimension))
        recording = pc.simulate(pc.Scene(pc.Tracers(cloud, pc.Flow(lambda time, x: -x))), 0.2)
    elif issubclass(kind, SystemStyle):
        grid = pc.Grid((12,) * dimension, 0.1)
        wave = pc.Wave(grid, 1.0, np.cos(np.sum(3.0 * grid.centers, axis=-1)), walls=grid.centers[..., 0] > 1.1)
        recording = pc.simulate(pc.Scene(wave), 0.2)
    elif kind in (pc.styles.FieldLines, pc.styles.Equipotentials):
        ions = pc.Particles(np.eye(dimension)[:2], charge=[1e-9, -1e-9])
        recording = recorded(pc.Scene(ions, pc.Coulomb()), shift)
    else:
        body = pc.Fluid(pc.block(*corners, 0.1), 0.1) if kind is pc.styles.Fluid else net(dimension)
        recording = recorded(pc.Scene(body), shift)
    pc.film(recording, tmp_path / "film.gif", size=SIZE, style=kind(), background=DARK.background)
    for picture in frames(tmp_path / "film.gif")[0]:
        drawn = ink(picture)
        assert drawn.sum() > 100
        if kind in (pc.styles.FieldLines, pc.styles.Equipotentials):
            continue  # a field has no end
        assert not drawn[0].any()
        assert not drawn[:, [0, -1]].any()


def test_a_gif_holds_exactly_what_was_drawn() -> None:
    """Few colors need no approximation, and Pillow shares no code with the writer."""
    canvas = Canvas(64, 48, (10, 20, 30))
    gif = Gif(None, [(10, 20, 30)])
    generator = np.random.default_rng(2)
    drawn = []
    for _ in range(12):
        corners = generator.uniform(0, 60, size=(4, 1, 2)).round() + np.array([[0, 0], [9, 0], [9, 7], [0, 7]])
        for index, corner in enumerate(corners.astype(np.float32)):
            canvas.polygon(corner, (40 * index + 60, 200 - 40 * index, 128, 255))
        gif.observe(canvas)
        drawn.append(canvas.pixels())
    for picture in drawn:
        _paste(canvas, picture)
        gif.frame(canvas, 3)
        gif.frame(canvas, 4)  # a frame like the last one is still a frame
    content = gif.finish()
    assert content is not None
    pictures, times = frames(content)
    assert times == [30, 40] * len(drawn)
    for index, picture in enumerate(pictures):
        np.testing.assert_array_equal(picture, drawn[index // 2])


def test_a_gif_has_a_number_of_colors() -> None:
    canvas = Canvas(64, 48, (10, 20, 30))
    generator = np.random.default_rng(3)
    for corner in generator.uniform(0, 48, size=(60, 3, 2)).astype(np.float32):
        canvas.polygon(corner, (*generator.integers(0, 256, 3).tolist(), 200))
    errors = {}
    for colors in (255, 8, 2):
        gif = Gif(None, [(10, 20, 30)], colors=colors)
        gif.observe(canvas)
        assert gif.written() == 0
        gif.frame(canvas, 3)
        written = gif.written()
        content = gif.finish()
        assert content is not None
        assert len(content) == written + 1, "all but the trailer"
        picture = frames(content)[0][0]
        assert len(np.unique(picture.reshape(-1, 3), axis=0)) <= colors
        errors[colors] = float(np.square(picture - canvas.pixels().astype(float)).mean())
    assert errors[255] < errors[8] < errors[2]
    for colors in (-1, 0, 1, 256):
        with pytest.raises(ValueError, match=f"colors: must be from 2 to 255, got {colors}"):
            Gif(None, [], colors=colors)


def _paste(canvas: Canvas, picture: np.ndarray) -> None:
    """Copy a picture pixel by pixel."""
    for row, column in np.ndindex(picture.shape[:2]):
        red, green, blue = (int(value) for value in picture[row, column])
        square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float32) + np.array(
            [column, row], dtype=np.float32
        )
        canvas.polygon(square, (red, green, blue, 255))


@pytest.mark.parametrize("rate", [1.0, 7.3, 12.5, 24.0, 25.0, 29.97, 30.0, 48.0, 50.0])
def test_delays_keep_real_time(rate: float) -> None:
    """Each frame ends within half a hundredth of a second of its time, so the sum of 1000 does too."""
    found = delays(1000, rate, 100)
    late = np.cumsum(found) / 100 - np.arange(1, 1001) / rate
    assert np.abs(late).max() <= 0.005 + 1e-9
    assert max(found) - min(found) <= 1


def test_the_same_recording_gives_the_same_bytes() -> None:
    recording = recorded(SCENES["3D"], shift)
    assert gif_bytes(recording, size=SIZE) == gif_bytes(recording, size=SIZE)


def test_panels_stand_side_by_side_and_share_their_camera(tmp_path: Path) -> None:
    still = recorded(SCENES["central"], lambda start, time: start)
    far = recorded(SCENES["central"], lambda start, time: start + 9.0 * time)
    pc.film([still, far, still], tmp_path / "film.gif", size=(300, 100), titles=["a", "b", "c"])
    picture = frames(tmp_path / "film.gif")[0][0]
    left, middle, right = (ink(picture)[32:78, start : start + 100] for start in (0, 100, 200))
    # All start at one position, in pixels too, but for rounding where the ink of a rim is about the least that counts.
    assert (left != middle).sum() + (left != right).sum() <= 6


def test_a_panel_that_ends_early_keeps_its_last_frame(tmp_path: Path) -> None:
    short, long = recorded(SCENES["central"], shift, 3), recorded(SCENES["central"], shift, 8)
    pc.film([short, long], tmp_path / "film.gif", size=(200, 100))
    pictures = frames(tmp_path / "film.gif")[0]
    assert len(pictures) == 8
    np.testing.assert_array_equal(ink(pictures[-1])[:75, :100], ink(pictures[-2])[:75, :100])


def test_a_still_is_the_last_frame(tmp_path: Path) -> None:
    recording = recorded(SCENES["particles"], shift)
    pc.film(recording, tmp_path / "film.png", size=SIZE)
    pc.film(recording, tmp_path / "film.gif", size=SIZE)
    with Image.open(tmp_path / "film.png") as image:
        still = np.asarray(image).astype(int)
    # The film's 255 colors are near the still's: a mean difference of one step in 255 is far from visible.
    assert np.abs(still - frames(tmp_path / "film.gif")[0][-1]).mean() < 1.0


def test_strain_is_blue_when_compressed_and_red_when_stretched(tmp_path: Path) -> None:
    rope = pc.rope(2, length=1.0, stiffness=1.0)
    for factor, strong, weak in [(1.3, 0, 2), (0.7, 2, 0)]:
        recording = recorded(pc.Scene(rope), lambda start, time, factor=factor: start * factor)
        pc.film(recording, tmp_path / "film.png", size=SIZE, style=pc.styles.Strain())
        with Image.open(tmp_path / "film.png") as image:
            row = np.asarray(image).astype(int)[20:90].reshape(-1, 3)
        color = row[np.abs(row - np.array(DARK.background)).sum(axis=1).argmax()]
        assert color[strong] > color[weak] + 80


def picture_of(recording: Any, path: Path, **options: Any) -> np.ndarray:
    pc.film(recording, path, size=SIZE, **options)
    with Image.open(path) as image:
        return np.asarray(image).astype(int)


def test_grains_have_their_true_size(tmp_path: Path) -> None:
    """A disc of 0.25 m in a window of 1 m. Between all pixels that it covers and all that it touches: a rim of one."""
    recording = recorded(pc.Scene(pc.Particles([[0.5, 0.5]], radius=0.25)), lambda start, time: start)
    picture = picture_of(recording, tmp_path / "film.png", camera=Window((0.0, 0.0), (1.0, 1.0)))
    drawn = ink(picture)[:, 30:130].sum()
    radius = 0.25 * (120 - round(1.3 * 16))  # the line with the time stands below
    assert np.pi * radius**2 <= drawn <= np.pi * (radius + 1.0) ** 2


def test_a_fluid_is_colored_by_speed_pressure_or_density(tmp_path: Path) -> None:
    """On two lumps: the scale goes from zero, or from the density at rest, and the one with more is lighter."""
    scene = pc.Scene(pc.Fluid([[0.0, 0.0], [1.0, 0.0]], 1.0))
    recording = recorded(scene, lambda start, time: start + time * start)
    recording.channels["pressures"] = np.tile([0.0, 1e4], (7, 1))
    recording.channels["densities"] = np.tile([990.0, 1010.0], (7, 1))
    for color in ("speed", "pressure", "density"):
        picture = picture_of(recording, tmp_path / "film.png", style=pc.styles.Fluid(color, "viridis", surface=False))
        row = picture[:90].sum(axis=2).max(axis=0)
        assert row[100:].max() > row[:60].max() + 100, color
    bright, dim = (
        picture_of(recording, tmp_path / "film.png", style=pc.styles.Fluid("pressure", top=top, surface=False))[:90]
        .sum(axis=2)
        .max()
        for top in (1e4, 2e4)
    )
    assert bright > dim + 100
    with pytest.raises(pc.SceneError, match=r"Fluid\.top"):
        pc.styles.Fluid(top=0.0)
    del recording.channels["pressures"]
    with pytest.raises(pc.SceneError, match=r"'pressure' needs pressures, which were not recorded; .*channels="):
        picture_of(recording, tmp_path / "film.png", style=pc.styles.Fluid("pressure"))


def test_a_spring_and_a_trail_across_a_face_do_not_cross_the_picture(tmp_path: Path) -> None:
    domain = pc.Periodic((0.0, 0.0), (1.0, 1.0))
    options = {"camera": Window((0.0, 0.0), (1.0, 1.0)), "background": "#000000"}
    rope = pc.rope(2, length=0.2, stiffness=1.0, start=(0.9, 0.5))
    recording = recorded(pc.Scene(rope, domain), lambda start, time: domain.wrap(start))
    assert not ink(picture_of(recording, tmp_path / "rope.png", **options), (0, 0, 0))[20:80, 60:100].any()
    ball = pc.Particles([[0.8, 0.5]])
    recording = recorded(pc.Scene(ball, domain), lambda start, time: domain.wrap(start + np.array([2.0 * time, 0.0])))
    style = pc.styles.Points(color="body", trail=1.0)
    assert not ink(picture_of(recording, tmp_path / "ball.png", style=style, **options), (0, 0, 0))[20:80, 75:100].any()


def test_springs_along_two_others_are_not_drawn() -> None:
    """In a 6 × 5 cloth those are exactly the bending springs: 4 in each of 5 rows and 3 in each of 6 columns."""
    cloth = net()
    hidden = covered(cloth.pairs, cloth.rest_length)
    assert hidden.sum() == 4 * 5 + 3 * 6
    np.testing.assert_allclose(cloth.rest_length[hidden], 0.2)
    assert not covered(cloth.pairs[:0], cloth.rest_length[:0]).any()


@pytest.mark.parametrize(
    "camera", [Orbit(), Orbit(field_of_view=0.0), Orbit(azimuth=120.0, elevation=-70.0, field_of_view=100.0)]
)
def test_nothing_leaves_the_picture_in_perspective(camera: Orbit) -> None:
    points = np.random.default_rng(3).normal(size=(500, 3)) * (3.0, 0.2, 1.0) + 100.0
    local = points @ camera.axes.T
    view = fit(camera, local.min(axis=0), local.max(axis=0), (20.0, 10.0, 220.0, 110.0), 5.0)
    pixels, depth, _ = view.project(points)
    rounding = 1e-3  # pixels are float32: an ulp of 220 is 1.5e-5
    assert (pixels >= np.array([25.0, 15.0]) - rounding).all()
    assert (pixels <= np.array([215.0, 105.0]) + rounding).all()
    assert depth is not None
    # What is nearer to the eye has the smaller depth.
    assert np.argmin(depth) == np.argmax(local[:, 2])


def test_up_is_z_and_a_window_is_shown_whole(tmp_path: Path) -> None:
    toward = Orbit(azimuth=-90.0, elevation=0.0).axes
    np.testing.assert_allclose(toward, [[1, 0, 0], [0, 0, 1], [0, -1, 0]], atol=1e-15)
    recording = recorded(SCENES["one particle at rest"], lambda start, time: start)
    pc.film(recording, tmp_path / "film.png", size=SIZE, camera=Window((0.0, 0.0), (4.0, 6.0)))
    with Image.open(tmp_path / "film.png") as image:
        _, columns = np.nonzero(ink(np.asarray(image).astype(int))[:90])
    assert columns.mean() == pytest.approx(79.5, abs=0.6)  # the particle is in the middle of the window


def test_colormaps_grow_evenly_lighter() -> None:
    """Luma never falls along a map, which is what makes it readable in print and to the color-blind."""
    for name in COLORMAPS:
        luma = sequential(name, (0.0, 1.0), "colormap") @ np.array([0.2126, 0.7152, 0.0722])
        assert (np.diff(luma) > -0.2).all()
    table = sequential("viridis", (0.0, 1.0), "colormap")
    np.testing.assert_array_equal(look_up(table, np.array([-1.0, 0.0, 2.0])), table[[0, 0, 255]])


@pytest.mark.parametrize("name", [*COLORMAPS, "gray", "hot", "afmhot"])
def test_ramps_stand_out_from_their_ground(name: str) -> None:
    """They begin at middle lightness on a dark ground, and end no lighter than a light one."""
    if name not in COLORMAPS:
        pytest.importorskip("matplotlib")
    dark, light = (sequential(name, theme.part, "colormap") for theme in (DARK, LIGHT))
    assert oklab(dark)[0, 0] > 0.49
    assert oklab(light)[0, 0] < oklab(dark)[0, 0]
    assert contrast(tuple(np.round(dark[0]).astype(int).tolist()), DARK.background) > 2.7


def test_high_quality_smooths_outlines_in_space_and_changes_nothing_in_the_plane(tmp_path: Path) -> None:
    """It is nearer to the means of a picture that is four times as large along each side."""

    def still(body: Any, times: int, quality: Any, camera: Any) -> np.ndarray:
        path, style = tmp_path / "still.png", pc.styles.Surface("tomato")
        options: dict[str, Any] = {
            "size": (160 * times, 120 * times),
            "style": style,
            "camera": camera,
            "background": "#101010",
        }
        pc.film(pc.Scene(body), path, duration=0.1, quality=quality, labels=(), **options)
        with Image.open(path) as image:
            pixels = np.asarray(image.convert("RGB")).astype(float)
        return pixels.reshape(120, times, 160, times, 3).mean(axis=(1, 3))

    camera = Orbit(-72.0, 16.0, target=(0.2, 0.2, 0.2), extent=0.8)
    exact, fast, high = (
        still(pc.soft_body((5, 5, 5), 0.1, 100.0), *each, camera) for each in ((4, "fast"), (1, "fast"), (1, "high"))
    )
    assert np.square(high - exact).mean() < 0.5 * np.square(fast - exact).mean()
    sheet, window = pc.cloth((6, 5), 0.1, 100.0), Window((-0.1, -0.1), (0.7, 0.5))
    np.testing.assert_array_equal(still(sheet, 1, "fast", window), still(sheet, 1, "high", window))


def test_a_color_that_is_seen_for_a_moment_is_in_the_palette(tmp_path: Path) -> None:
    """A sheet shows its orange back in one frame of thirty, which is none of those that the palette is chosen from."""
    sheet = pc.cloth((6, 5), 0.1, 100.0, axes=((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    start, times = sheet.positions - sheet.positions.mean(axis=0), np.arange(30) / 20
    positions = np.tile(start, (30, 1, 1))
    positions[15, :, 0] *= -1.0  # turned around
    positions[15, :, 1] += 1e-3 * start[:, 0]
    channels = {"positions": positions, "velocities": np.zeros_like(positions)}
    recording: Any = SimpleNamespace(
        scene=pc.Scene(sheet), times=times, fps=20.0, positions=positions, channels=channels
    )
    style = pc.styles.Surface("#7a3fd0", back="#ff8c1a")
    pc.film(recording, tmp_path / "film.gif", size=(160, 120), style=style, camera=Orbit(-90.0, 0.0), labels=())
    seen = []
    with Image.open(tmp_path / "film.gif") as image:
        for frame in (14, 15):
            image.seek(frame)
            red, green, blue = np.asarray(image.convert("RGB")).astype(int)[60, 80]
            seen.append(red > 1.3 * green > 1.3 * 1.3 * blue)
    assert seen == [False, True]


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "film.gif"
    path.write_bytes(b"old")
    recording = recorded(SCENES["particles"], shift)
    recording.positions = recording.positions[:5]  # the film breaks off in the middle
    with pytest.raises(IndexError):
        pc.film(recording, path, size=SIZE)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_that_cannot_be_written_is_a_file_error(tmp_path: Path) -> None:
    recording = recorded(SCENES["particles"], shift)
    for name in ("none/film.gif", "none/film.png"):
        with pytest.raises(pc.FileError, match=f"{name}: cannot be written: no such folder"):
            pc.film(recording, tmp_path / name, size=SIZE)
    for name in ("folder.gif", "folder.png"):
        (tmp_path / name).mkdir()
        with pytest.raises(pc.FileError, match=f"{name}: cannot be written") as caught:
            pc.film(recording, tmp_path / name, size=SIZE)
        assert isinstance(caught.value.__cause__, OSError)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder.gif", "folder.png"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"path": "film.avi"}, r"path: must end in \.gif, \.webp, \.apng, \.mp4, \.html or \.png"),
        ({"size": (10, 10)}, r"size\[0\]"),
        ({"size": 640}, "size: must be"),
        ({"style": pc.styles.Points}, r"write Points\(\)"),
        ({"theme": "blue"}, "theme: must be one of 'dark', 'light'"),
        ({"background": "reed"}, "background"),
        ({"camera": Orbit()}, "camera: must be a Window in 2D"),
        ({"titles": ["a", "b"]}, "titles: must be one for each"),
        ({"speed": 10.0}, "at most 50 frames per second, got 300"),
        ({"duration": 1.0}, "duration: is for a scene, and this is a recording"),
        ({"dt": 0.1}, "dt: is for a scene, and this is a recording"),
        ({"size": (100, 70_000)}, r"size\[1\]: must be ≤ 16384"),
        ({"title": 3}, "title: must be a string"),
        ({"formula": 3}, "formula: must be a string"),
        ({"figure": ["a"]}, "figure: must be a string"),
        ({"theme": ["dark"]}, "theme: must be one of 'dark', 'light'"),
        ({"speed": 2.5}, "slower: speed=50/30"),
        ({"speed": 1e-6}, "at most 655 s, got 33333.3 s; play it faster: speed=1"),
        ({"style": pc.styles.Strain(on=SCENES["particles"].bodies[0])}, "no springs"),
        ({"style": pc.styles.Points(on=dust(3))}, r"Points\.on: Particles\(3 .* is not in what is filmed"),
        ({"style": pc.styles.Fluid(on=SCENES["particles"].bodies[0])}, "is no fluid"),
    ],
)
def test_what_cannot_be_filmed_is_refused(options: dict[str, Any], message: str, tmp_path: Path) -> None:
    path = tmp_path / options.pop("path", "film.gif")
    with pytest.raises(pc.SceneError, match=message):
        pc.film(recorded(SCENES["particles"], shift), path, **options)
    assert not list(tmp_path.iterdir())


def test_a_scene_is_filmed_while_it_runs_like_its_recording(tmp_path: Path) -> None:
    """Streaming looks twice at the same bits, so it draws what the recording shows."""
    scene = pc.Scene(pc.rope(10, length=1.0, stiffness=100.0, mass=0.01, pinned="start"), pc.Gravity((0.0, -9.81)))
    pc.film(scene, tmp_path / "streamed.gif", duration=0.5, fps=20, size=SIZE)
    pc.film(pc.simulate(scene, 0.5, fps=20), tmp_path / "recorded.gif", size=SIZE)
    assert (tmp_path / "streamed.gif").read_bytes() == (tmp_path / "recorded.gif").read_bytes()


def test_a_scene_that_cannot_be_filmed_is_refused_before_it_is_simulated(tmp_path: Path) -> None:
    def never(time: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        raise AssertionError("it was simulated")

    scene, path = pc.Scene(dust(3), pc.CustomForce(never)), tmp_path / "film.gif"
    for options, message in [
        ({}, "duration: .*say how long"),
        ({"duration": "2"}, "duration: must be a number"),
        ({"duration": -1.0}, "duration: must be ≥ 0"),
        ({"duration": 1.0, "fps": 0}, "fps: must be > 0"),
        ({"duration": 1.0, "fps": 60, "speed": 1.0}, "at most 50 frames per second"),
    ]:
        with pytest.raises(pc.SceneError, match=message):
            pc.film(scene, path, **options)
    with pytest.raises(pc.FileError, match="no such folder"):
        pc.film(scene, tmp_path / "none" / "film.gif", duration=1.0)


def test_more_frames_than_a_format_shows_play_slower_and_it_says_so(tmp_path: Path) -> None:
    with pytest.warns(pc.SceneWarning, match="at most 50 frames per second, so that this film of 60 plays at 0.83"):
        film = pc.film(pc.Scene(dust(3)), tmp_path / "film.gif", duration=0.1, fps=60)
    assert (film.rate, film.frames) == (50.0, 7)


DAYS = pc.units.system(length=pc.units.AU, time=pc.units.day, mass=pc.units.solar_mass)


@pytest.mark.parametrize(
    ("units", "second"), [(pc.units.SI, "s"), (DAYS, "d"), (pc.units.dimensionless, "unit of time")]
)
def test_frames_that_last_for_seconds_are_warned_of(units: Any, second: str, tmp_path: Path) -> None:
    path, scene = tmp_path / "film.gif", pc.Scene(dust(3), units=units)
    message = rf"lasts 5 s, because 0\.2 are recorded per {second}, .* speed=150 for 30 .* or speed=1 if this is meant"
    with pytest.warns(pc.SceneWarning, match=message):
        assert pc.film(scene, path, duration=10.0, fps=0.2).rate == 0.2
    assert pc.film(scene, path, duration=10.0, fps=0.2, speed=1.0).rate == 0.2
    assert pc.film(scene, path, duration=10.0, fps=0.2, speed=150.0).rate == pytest.approx(30.0)
    assert pc.film(scene, path, duration=2.0, fps=0.5).rate == 0.5
    assert pc.film(scene, tmp_path / "film.png", duration=10.0, fps=0.2).frames == 1


@pytest.mark.parametrize("item", [SCENES["particles"], "recording"])
def test_an_unknown_argument_is_called_that(item: Any, tmp_path: Path) -> None:
    item = recorded(SCENES["particles"], shift) if item == "recording" else item
    with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
        pc.film(item, tmp_path / "film.gif", colour="red")


@pytest.mark.filterwarnings("ignore:duration. 518400 s are")
@pytest.mark.parametrize(
    ("fps", "delay"), [(20.0, 50.0), (30.0, 40.0), (75.0, 40.0), (400.0, 40.0), (1.0 / 86400.0, 100.0)]
)
def test_a_notebook_plays_any_recording_as_near_to_real_time_as_it_can(fps: float, delay: float) -> None:
    recording = pc.simulate(pc.Scene(dust(2)), 6 / fps, fps)
    html = recording._repr_html_()
    assert html is not None
    content = base64.b64decode(html.split("base64,")[1].split('"')[0])
    assert np.mean(frames(content)[1]) == pytest.approx(delay, abs=10 / 7 / 2 + 0.1)  # half a hundredth in all


def test_a_preview_is_bounded_however_long_the_recording(monkeypatch: pytest.MonkeyPatch) -> None:
    """Noise, of which each frame of 640 × 480 would take a hundred kilobytes."""
    generator = np.random.default_rng(1)
    quiet = pc.simulate(pc.Scene(dust(3000)), 400 / 30, 30, dt=0.1)
    noise = generator.uniform(size=(401, 3000, 2))
    recording = replace(quiet, channels={"positions": noise, "velocities": 0.0 * noise})
    html = recording._repr_html_()
    assert html is not None
    content = base64.b64decode(html.split("base64,")[1].split('"')[0])
    assert 1_000_000 < len(content) <= 2_000_000
    with Image.open(io.BytesIO(content)) as image:
        assert max(image.size) <= 480
        assert 1 < image.n_frames <= 150
    assert "in full" in html
    monkeypatch.setattr(sys.modules["physcore.film.notebook"], "gif_bytes", None)  # it is not made again
    assert recording._repr_html_() == html


def test_a_notebook_shows_the_whole_when_it_is_asked() -> None:
    recording = pc.simulate(pc.Scene(dust(2)), 0.2)
    html = recording.show()._repr_html_()
    content = base64.b64decode(html.split("base64,")[1].split('"')[0])
    with Image.open(io.BytesIO(content)) as image:
        assert image.n_frames == len(recording)
    with pytest.raises(pc.SceneError, match="show: needs the channel 'positions'"):
        pc.simulate(pc.Scene(dust(2)), 0.1, channels=("velocities",)).show()


def test_films_energies_and_plans_are_shown_in_notebooks(tmp_path: Path) -> None:
    recording = pc.simulate(pc.Scene(dust(2)), 0.2)
    film = pc.film(recording, tmp_path / "a film & more.gif", size=SIZE)
    assert base64.b64encode(film.path.read_bytes()).decode() in film._repr_html_()
    assert "a film &amp; more.gif" in film._repr_html_()
    film.path.unlink()
    assert "<img" not in film._repr_html_()
    for table in (recording.energy._repr_html_(), recording.energy.at(0)._repr_html_()):
        assert "<table>" in table
        assert "kinetic" in table
    assert recording.plan.integrator in recording.plan._repr_html_()


def test_a_sign_that_no_face_has_is_warned_of(tmp_path: Path) -> None:
    recording = recorded(SCENES["particles"], shift)
    with pytest.warns(pc.SceneWarning, match=r"title: no face has 😀 \(U\+1F600\)"):
        pc.film(recording, tmp_path / "film.png", size=SIZE, title="v₀ 😀")
    pictures = []
    for title in ("抛体运动 v₀ α ∇", "弹簧摆动 v₀ α ∇", "???? v? ? ?"):
        pc.film(recording, tmp_path / "film.png", size=SIZE, title=title, subtitle="ω = √(k/m)", credit="© 한글")
        with Image.open(tmp_path / "film.png") as image:
            pictures.append(np.asarray(image.convert("RGB"), dtype=int))
    for one, other in ((0, 1), (0, 2), (1, 2)):
        assert np.abs(pictures[one] - pictures[other])[:30].max() > 60
        assert (pictures[one] == pictures[other])[40:].all()


@pytest.mark.parametrize("suffix", [".png", ".gif"])
@pytest.mark.parametrize(("name", "size"), [("square", (480, 480)), ("wide", (640, 360)), ("story", (360, 640))])
def test_common_formats_have_names(name: Any, size: tuple[int, int], suffix: str, tmp_path: Path) -> None:
    recording = recorded(SCENES["particles"], shift, 2)
    assert pc.film(recording, tmp_path / f"film{suffix}", format=name).size == size
    with pytest.raises(pc.SceneError, match="format: give a format or a size, not both"):
        pc.film(recording, tmp_path / "film.gif", format=name, size=SIZE)
    with pytest.raises(pc.SceneError, match="format: must be 'square', 'wide' or 'story'"):
        pc.film(recording, tmp_path / "film.gif", format="tall")


def assert_alike(one: np.ndarray, other: np.ndarray) -> None:
    """Pixels may keep the color of the frame before, within the tolerance: frames depend on it."""
    difference = np.abs(one.astype(int) - other)
    assert difference.max() <= 8
    assert difference.mean() < 0.1


def test_a_film_that_holds_bounces_or_fades(tmp_path: Path) -> None:
    recording, path = recorded(SCENES["particles"], shift, 12, fps=10.0), tmp_path / "film.gif"
    pc.film(recording, path, size=SIZE, labels=(), hold=1.5)
    plain, delays = frames(path)
    assert delays == [100] * 11 + [1600]
    film = pc.film(recording, path, size=SIZE, labels=(), loop="bounce", hold=0.5)
    bounced, delays = frames(path)
    assert film.frames == len(bounced) == 22
    assert delays == [100] * 11 + [600] + [100] * 10
    for forward, backward in zip(plain[1:11], bounced[:11:-1], strict=True):
        assert_alike(forward, backward)
    film = pc.film(recording, path, size=SIZE, labels=(), loop="crossfade")
    faded = frames(path)[0]
    assert film.frames == len(faded) == 8  # a third of the film is blended
    assert_alike(faded[0], plain[4])
    # Weights go from 1/5 to 4/5 of the start; a palette lies between.
    mixture = np.array(plain[8]) * 0.8 + np.array(plain[0]) * 0.2
    assert np.abs(np.array(faded[4]) - mixture).mean() < 4.0
    for wrong in ({"loop": "again"}, {"hold": -1.0}, {"hold": 1e4}, {"loop": "crossfade", "hold": 1.0}):
        with pytest.raises(pc.SceneError, match=r"^(loop|hold)"):
            pc.film(recording, path, size=SIZE, **wrong)


def test_a_still_is_held_anyway_and_does_not_begin_again(tmp_path: Path) -> None:
    recording = pc.simulate(pc.Scene(pc.Particles([[0.0, 0.0]], [[1.0, 0.0]])), 0.2, progress=False)
    still, held = (picture_of(recording, tmp_path / "film.png", hold=seconds) for seconds in (0.0, 1e6))
    np.testing.assert_array_equal(still, held)
    with pytest.raises(pc.SceneError, match="loop: needs more than one frame, and a PNG has only the last"):
        pc.film(recording, tmp_path / "film.png", size=SIZE, loop="bounce")


def test_the_subject_is_shown_and_not_the_box_around_it(tmp_path: Path) -> None:
    """Two balls in a corner of a hall of a hundred meters: what takes 2 m of it takes a quarter of the picture."""
    balls = pc.Particles([[0.5, 0.5], [2.5, 1.0]], radius=0.3)
    picture = picture_of(
        recorded(pc.Scene(balls, pc.Box((0.0, 0.0), (100.0, 80.0))), lambda start, time: start), tmp_path / "film.png",
        style=pc.styles.Points(color="tomato", shading=False), labels=(),
    )  # fmt: skip
    drawn = np.abs(picture - np.array([255, 99, 71])).max(axis=2) < 20
    columns = np.flatnonzero(drawn.any(axis=0))
    assert columns[-1] - columns[0] > picture.shape[1] / 4


def test_a_notebook_shows_text_where_there_is_nothing_to_draw() -> None:
    assert pc.simulate(pc.Scene(dust(2)), 0.1, channels=("velocities",))._repr_html_() is None


def test_the_time_shown_moves_with_every_frame(tmp_path: Path) -> None:
    recording = recorded(SCENES["one particle at rest"], lambda start, time: start, 3, fps=1e6)
    pc.film(recording, tmp_path / "film.gif", size=SIZE, speed=1e-6)
    pictures = frames(tmp_path / "film.gif")[0]
    assert (pictures[0] != pictures[1]).any()


def test_a_trail_may_be_longer_than_the_film() -> None:
    recording = recorded(SCENES["central"], shift)
    whole, beyond = (gif_bytes(recording, size=SIZE, style=pc.styles.Points(trail=trail)) for trail in (7 / 30, 1e300))
    assert whole == beyond


def test_the_light_theme_is_light(tmp_path: Path) -> None:
    pc.film(recorded(SCENES["particles"], shift), tmp_path / "film.gif", size=SIZE, theme=LIGHT)
    np.testing.assert_array_equal(frames(tmp_path / "film.gif")[0][0][0, 0], LIGHT.background)
