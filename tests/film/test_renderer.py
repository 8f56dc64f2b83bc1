"""What stands around the motion: the picture's format, its text and diagrams; and in how many passes it is found."""

from __future__ import annotations

import errno
import io
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import physcore as pc
from physcore._core import text_width
from physcore.film import DARK, LIGHT, Follow, Orbit, Window, frame_cache, gif_bytes
from physcore.film.colors.colormaps import COLORMAPS, LUMA, ramp, sequential
from physcore.film.colors.themes import LEGIBLE, contrast, legible
from physcore.film.film_renderer import FilmRenderer
from physcore.film.frame_cache import FrameCache
from physcore.film.labels.clock import Clock
from physcore.film.labels.footer import Footer, bars
from physcore.film.labels.heading import Heading
from physcore.film.labels.text import ends, text_height, wrapped
from physcore.film.styles.base import Scale
from physcore.simulation.energy import Drift
from physcore.simulation.sources import Running, sources

SIZE = (320, 240)


def rope(length: float = 1.0, direction: tuple[float, float] = (1.0, 0.0)) -> pc.Scene:
    body = pc.rope(10, length, stiffness=100.0, mass=0.01, pinned="start", direction=direction)
    return pc.Scene(body, pc.Gravity((0.0, -9.81)))


def dust(lower: tuple[float, ...], upper: tuple[float, ...]) -> pc.Recording:
    points = np.random.default_rng(5).uniform(lower, upper, (40, len(lower)))
    return pc.simulate(pc.Scene(pc.Particles(np.concatenate([points, [lower, upper]]))), 0.1)


def renderer(items: Any, size: Any = SIZE, **options: Any) -> FilmRenderer:
    found = sources(items, options.pop("duration", None), options.pop("fps", None), {})
    style, camera, theme = options.pop("style", None), options.pop("camera", None), options.pop("theme", DARK)
    return FilmRenderer(
        found, size, style, camera, theme, Heading(titles=tuple(options.pop("titles", ()))), False, **options
    )


def pictures(items: Any, size: Any = SIZE, **options: Any) -> list[np.ndarray]:
    with renderer(items, size, **options) as made:
        return [canvas.pixels().astype(int) for canvas in made.frames()]


# The format.


@pytest.mark.parametrize(
    ("upper", "format"),
    [
        ((4.0, 3.0), (640, 480)),
        ((1.0, 1.0), (554, 554)),
        ((1.0, 9.0), (416, 740)),
        ((2.0, 1.0), (740, 416)),
        ((16.0, 9.0), (640, 480)),
    ],
)
def test_the_format_suits_the_motion(upper: tuple[float, float], format: tuple[int, int]) -> None:
    recording = dust((0.0, 0.0), upper)
    with renderer(recording, None) as made:
        assert made.size == format
    with renderer(recording, (100, 300)) as made:
        assert made.size == (100, 300)
    with renderer(recording, None, camera=Window((0.0, 0.0), upper)) as made:
        assert made.size == format
    with Image.open(io.BytesIO(gif_bytes(recording))) as image:
        assert image.size == format


@pytest.mark.parametrize("panels", [1, 2, 3, 4, 7])
@pytest.mark.parametrize("upper", [(1.0, 1.0), (1.0, 9.0), (9.0, 1.0), (4.0, 3.0)])
def test_any_format_is_even_and_of_a_usual_size(panels: int, upper: tuple[float, float]) -> None:
    with renderer([dust((0.0, 0.0), upper)] * panels, None) as made:
        width, height = made.size
    assert width % 2 == height % 2 == 0
    assert width <= 1280 + 2
    most = min(panels, 2) if panels <= 4 else 4  # More than four are in several rows.
    assert 0.25 * 640 * 480 <= width * height <= 1.02 * 640 * 480 * most


def test_who_says_how_much_is_shown_gets_the_usual_format() -> None:
    tall = dust((0.0, 0.0, 0.0), (1.0, 1.0, 9.0))
    for camera in (Orbit(extent=3.0), Follow(0)):
        with renderer(tall, None, camera=camera) as made:
            assert made.size == (640, 480)
    with renderer(tall, None) as made:
        assert made.size == (416, 740)


# One pass, two, or cached.


def test_the_same_bytes_spooled_simulated_again_and_recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fluid = pc.Fluid(pc.block((0.0, 0.0), (0.3, 0.3), 0.05), 0.05)
    scene = pc.Scene(fluid, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (1.0, 1.0)))
    options: dict[str, Any] = {"size": SIZE, "labels": ("time", "dt", "integrator", "energy"), "inset": "energy"}
    ways = []
    close, write = FrameCache.close, FrameCache._write

    def slow(self: FrameCache, frame: Any) -> None:
        time.sleep(0.02)  # a disk that takes its time
        write(self, frame)

    def watched(self: FrameCache) -> None:
        ways.append(self.whole)
        close(self)

    monkeypatch.setattr(FrameCache, "close", watched)
    for name, share, trial in (("cached", 1.0, np.inf), ("refused", 0.0, np.inf), ("slow", 1.0, -1.0)):
        monkeypatch.setattr(frame_cache, "SHARE", share)
        monkeypatch.setattr(frame_cache, "TRIAL", trial)
        if name == "slow":
            monkeypatch.setattr(FrameCache, "_write", slow)
        pc.film(scene, tmp_path / f"{name}.gif", duration=0.5, fps=20, **options)
    assert ways == [True, False, False, False]  # the slow one is closed at once, and again at the end
    pc.film(pc.simulate(scene, 0.5, fps=20), tmp_path / "recorded.gif", **options)
    assert len({(tmp_path / f"{name}.gif").read_bytes() for name in ("cached", "refused", "slow", "recorded")}) == 1


def test_what_was_spooled_is_exact() -> None:
    fluid = pc.Fluid(pc.block((0.0, 0.0), (0.3, 0.3), 0.05), 0.05)
    scene = pc.Scene(fluid, rope().bodies[0], pc.Gravity((0.0, -9.81)), pc.Box((-1.0, -1.0), (1.5, 1.0)))
    found = FrameCache(Running(scene, 0.3, 20.0, {}))
    first = list(found.first())
    assert found.whole
    again = list(found.again())
    found.close()
    assert len(first) == len(again) == 7
    for one, other in zip(first, again, strict=True):
        assert (one.time, one.dt, vars(one.energy)) == (other.time, other.dt, vars(other.energy))
        np.testing.assert_array_equal(one.positions, other.positions)
        assert one.fields.keys() == other.fields.keys()
        for name in one.fields:
            np.testing.assert_array_equal(one.fields[name], other.fields[name])  # what is no number stays none


@pytest.mark.parametrize("room", [0, 500, 3000])
@pytest.mark.parametrize("when", ["writing", "flushing", "reading"])
def test_a_full_disk_does_not_fail_the_film(room: int, when: str, monkeypatch: pytest.MonkeyPatch) -> None:
    class Small(io.BytesIO):
        def write(self, data: Any) -> int:
            if when == "writing" and self.tell() + len(data) > room:
                raise OSError(errno.ENOSPC, "No space left on device")
            return super().write(data)

        def flush(self) -> None:
            if when == "flushing":
                raise OSError(errno.ENOSPC, "No space left on device")

        def seek(self, offset: int, whence: int = 0) -> int:
            self.truncate(room)  # somebody cut it off
            return super().seek(offset, whence)

    monkeypatch.setattr(tempfile, "TemporaryFile", lambda **options: Small())
    monkeypatch.setattr(frame_cache, "TRIAL", np.inf)
    found = FrameCache(Running(rope(), 0.5, 20.0, {}))
    first = [frame.positions for frame in found.first()]
    assert found.whole == (when == "reading")
    np.testing.assert_array_equal(first, [frame.positions for frame in found.again()])


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many frames each run of a simulation gave."""
    counts: list[int] = []
    frames = Running.frames

    def counted(self: Running) -> Iterator[Any]:
        counts.append(0)
        for frame in frames(self):
            counts[-1] += 1
            yield frame

    monkeypatch.setattr(Running, "frames", counted)
    return counts


def test_a_film_that_depends_on_nothing_is_simulated_once(
    runs: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(frame_cache, "SHARE", 0.0)
    closed: dict[str, Any] = {"camera": Window((-1.0, -2.0), (2.0, 1.0)), "style": pc.styles.Strain(range=0.5)}
    for options, expected in [
        (closed, 1),
        ({**closed, "labels": ("time", "energy")}, 1),
        ({**closed, "camera": lambda time: Window((-1.0 - time, -2.0), (2.0, 1.0))}, 1),
        ({**closed, "camera": None}, 2),
        ({**closed, "style": pc.styles.Strain()}, 2),
        ({**closed, "camera": Follow(0, closed["camera"])}, 2),
        ({**closed, "inset": "energy"}, 2),
        ({**closed, "labels": ("dt",)}, 2),
    ]:
        runs.clear()
        pc.film(rope(), tmp_path / "film.gif", duration=0.5, fps=20, **options)
        assert runs == [11] * expected, options
    pc.film(rope(), tmp_path / "once.gif", duration=0.5, fps=20, **closed)
    pc.film(pc.simulate(rope(), 0.5, fps=20), tmp_path / "recorded.gif", **closed)
    assert (tmp_path / "once.gif").read_bytes() == (tmp_path / "recorded.gif").read_bytes()
    runs.clear()
    monkeypatch.setattr(frame_cache, "SHARE", 1.0)
    monkeypatch.setattr(frame_cache, "TRIAL", np.inf)
    pc.film(rope(), tmp_path / "film.gif", duration=0.5, fps=20)
    assert runs == [11]


def test_swatches_make_as_good_a_palette_as_the_film(tmp_path: Path) -> None:
    """Mean errors of the GIF's pixels where something is drawn. In the first frame, all that one pass has seen, all is
    at rest, and one color of the scale occurs (more of them in the color bar, which is therefore left out).
    """
    body = pc.Particles(np.random.default_rng(1).uniform(-1.0, 1.0, (300, 2)))
    scene = pc.Scene(body, pc.CentralForce(center=(0.0, 0.0), strength=20.0, exponent=1.0))
    errors = []
    for top in (5.0, None):
        options: dict[str, Any] = {
            "style": pc.styles.Points(top=top, size=9.0),
            "camera": Window((-1.0, -1.0), (1.0, 1.0)),
            "color_bar": False,
        }
        pc.film(scene, tmp_path / "film.gif", duration=1.0, fps=10, size=SIZE, **options)
        drawn = pictures(scene, duration=1.0, fps=10, **options)
        with Image.open(tmp_path / "film.gif") as image:
            image.seek(len(drawn) - 1)
            shown = np.asarray(image.convert("RGB")).astype(int)
        inked = np.abs(drawn[-1] - np.array(DARK.background)).sum(axis=2) > 6
        errors.append(np.abs(shown - drawn[-1])[inked].mean())
    assert errors[0] < 1.5 * errors[1] + 0.5  # and half a step of 255 that nobody sees


FILM = """
import time, physcore as pc
body = pc.Particles([[0.0, 0.0]] * 2000)
force = pc.CustomForce(lambda time, x, v: (globals()["time"].sleep(0.002), 0.0 * x)[1])
pc.film(pc.Scene(body, force), {path!r}, duration=100.0, fps=20, dt=0.05)
"""


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="looks into /proc for the open file")
def test_no_temporary_file_is_left_when_the_process_is_killed(tmp_path: Path) -> None:
    room, path = tmp_path / "tmp", tmp_path / "film.gif"
    room.mkdir()
    process = subprocess.Popen(
        [sys.executable, "-c", FILM.format(path=str(path))], env=os.environ | {"TMPDIR": str(room)}
    )
    try:
        deadline = time.monotonic() + 3600.0  # against hanging alone
        while not any(str(room) in target and "deleted" in target for target in _open_files(process.pid)):
            assert process.poll() is None, "the film ended before it could be killed"
            assert time.monotonic() < deadline, "no frame was cached"
            time.sleep(0.01)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert list(room.iterdir()) == []
    assert list(tmp_path.iterdir()) == [room]


def _open_files(pid: int) -> list[str]:
    found = []
    for link in Path(f"/proc/{pid}/fd").iterdir():
        try:
            found.append(os.readlink(link))
        except FileNotFoundError:
            continue
    return found


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="looks into /proc for open files")
def test_no_temporary_file_is_left_after_an_exception(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(time: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.full_like(x, np.nan) if time > 0.3 else 0.0 * x

    (tmp_path / "tmp").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "tmp"))
    before = len(_open_files(os.getpid()))
    with pytest.raises(pc.SimulationDiverged, match="returns"):
        pc.film(pc.Scene(pc.Particles([[0.0, 0.0]]), pc.CustomForce(fails)), tmp_path / "film.gif", duration=1.0)
    assert len(_open_files(os.getpid())) == before
    assert list((tmp_path / "tmp").iterdir()) == []


# What stands below the picture.


def test_text_is_as_wide_as_it_is_said_to_be() -> None:
    for height in (16, 25, 40):
        canvas = pc._core.Canvas(600, 60, (0, 0, 0))
        canvas.text("|抛体 v₀|", 0, 0, height, (255, 255, 255, 255), -1)
        columns = np.flatnonzero(canvas.pixels().sum(axis=(0, 2)))
        side = text_width("|", height)
        assert columns[-1] - columns[0] == pytest.approx(text_width("|抛体 v₀|", height) - side, abs=2)


@pytest.mark.parametrize("size", [(640, 480), (480, 480), (360, 640), (1920, 1080), (320, 240), (1280, 480)])
def test_text_can_be_read_where_pictures_are_360_pixels_wide(size: tuple[int, int]) -> None:
    """A line of 14 pixels has capitals of 7; in a wide and low picture it takes at most a fourteenth of the height."""
    height = text_height(*size)
    assert height * 360 / size[0] >= 14 or height == size[1] // 14
    assert height <= max(size[1] / 14, 16)


@given(low=st.floats(-1e8, 1e8), span=st.floats(1e-6, 1e8))
def test_the_ends_of_a_scale_are_told_apart_in_a_few_digits(low: float, span: float) -> None:
    """Two digits of the difference: each is off by at most a twentieth of it, or by that of the larger value."""
    texts = ends(low, low + span)
    most = max(abs(low), abs(low + span))
    tolerance = max(0.05 * span, 0.05 * most if most >= 1e5 or most < 1e-3 else 0.0) * 1.01 + 1e-12 * most
    for text, value in zip(texts, (low, low + span), strict=True):
        assert float(text) == pytest.approx(value, abs=tolerance)
        assert len(text) <= 16
    assert ends(0.0, 4.23) == ("0", "4.2")
    assert ends(-0.031, 0.031) == ("-0.031", "0.031")
    assert ends(0.987, 1.013) == ("0.987", "1.013")
    assert ends(0.0, 1.2345e6) == ("0", "1.2e6")


def test_a_color_bar_shows_the_scale_and_equal_scales_once() -> None:
    table = sequential("viridis", (0.0, 1.0), "colormap")
    speed = Scale("speed", "m/s", (0.0, 4.23), table)
    strain = Scale("strain", "", (-0.031, 0.031), table)
    still = Scale("speed", "m/s", (0.0, 0.0), table)
    made = bars([speed, None, strain, Scale("speed", "m/s", (0.0, 4.23), table.copy()), still])
    assert [(bar.name, bar.low, bar.high) for bar in made] == [
        ("speed [m/s]", "0", "4.2"),
        ("strain [%]", "-3.1", "3.1"),
    ]
    recording = pc.simulate(rope(), 0.3)
    with_bar, without = (pictures(recording, color_bar=shown)[-1][-18:] for shown in (True, False))
    colors = (
        np.abs(with_bar - np.array(DARK.stretched)).sum(axis=2).min(),
        np.abs(without - DARK.stretched).sum(axis=2).min(),
    )
    assert colors[0] < 12 < colors[1]
    assert (with_bar[:, :60] == without[:, :60]).all()  # the time stands where it was
    twice = pictures([recording, recording], (640, 240))[-1][-18:]
    assert (np.abs(twice[8] - np.array(DARK.stretched)).sum(axis=1) < 12).sum() < 20


def test_labels_keep_their_width() -> None:
    clock = Clock(np.linspace(0.0, 119.0, 1191), 10.0, 10.0, None)
    footer = Footer(("time", "dt", "integrator", "energy"), clock, [("RungeKutta4", 1e-3)], [])
    lines = [footer._lines(16, 640, [error], time) for time, error in ((0.0, 0.0), (9.9, 3.21e-17), (119.0, 0.5))]
    assert len({text_width(line, 16) for _, line in lines}) == 1
    assert lines[1][1] == "\u2007\u20079.90 s   dt 0.001 s   RungeKutta4   energy error 3.2e−17"
    narrow = footer._lines(16, 200, [0.0], 0.0)[0][0]
    assert len(narrow) > 1
    assert all(text_width(line, 16) <= 200 for line in narrow)
    assert wrapped(["aa", "bb", "cc"], 16, text_width("aa   bb", 16)) == [["aa", "bb"], ["cc"]]


@pytest.mark.parametrize(
    ("duration", "unit", "written"),
    [(4.0, None, "4.00 s"), (90.0 * 86400.0, None, "90 d"), (2e-5, None, "20.00 µs"), (3600.0, "min", "60.00 min")],
)
def test_time_is_written_in_the_unit_of_the_motion(duration: float, unit: str | None, written: str) -> None:
    fps = 30.0 / duration if duration > 1e4 else 3.0 / duration
    clock = Clock(np.array([0.0, duration]), fps, fps, unit)
    number, sign = clock.text(clock.times[1]).replace("\u2007", "").split()
    assert float(number) == pytest.approx(float(written.split()[0]))
    assert sign == written.split()[1]


@pytest.mark.parametrize(
    ("per_second", "unit", "pace"),
    [
        (1.0, None, ""),
        (90.0 * 86400.0, "d", "1 s = 90 d"),
        (0.25, None, "4 × slower"),
        (2.5e-4, None, "1 s = 0.25 ms"),
    ],
)
def test_a_film_that_is_not_in_real_time_says_so(per_second: float, unit: str | None, pace: str) -> None:
    assert Clock(np.array([0.0, 10.0 * per_second]), 1.0, per_second, unit).pace == pace


def test_the_energy_error_so_far_ends_as_that_of_the_recording() -> None:
    recording = pc.simulate(rope(), 1.0, dt=2e-3)
    drift = Drift()
    (source,) = sources(recording, None, None, {})
    errors = [drift.add(frame.energy) for frame in source.frames() if frame.energy is not None]
    assert errors[0] == 0.0
    assert errors[-1] == pytest.approx(abs(recording.energy.drift[-1]), rel=1e-9)
    assert errors[-1] > 0.0


def test_without_labels_and_bars_the_picture_is_all_motion() -> None:
    recording = dust((0.0, 0.0), (4.0, 3.0))
    style = pc.styles.Points(color="body")
    bare, labeled = (pictures(recording, labels=labels, style=style)[0] for labels in ((), ("time",)))
    rows = [
        np.flatnonzero((np.abs(p - np.array(DARK.background)).sum(axis=2) > 60).any(axis=1)) for p in (bare, labeled)
    ]
    assert rows[0].max() > 225
    dark = [np.abs(p[-14:] - np.array(DARK.label)).sum(axis=2).min() for p in (bare, labeled)]
    assert dark[0] > 60 > dark[1]


def test_panels_say_below_each_what_differs() -> None:
    scene = rope()
    two = [pc.simulate(scene, 0.2, integrator=each, dt=1e-3) for each in (pc.VelocityVerlet(), pc.RungeKutta4())]
    labels = ("time", "integrator", "dt", "energy")
    told, silent = (pictures(two, (800, 240), labels=each, color_bar=False)[-1] for each in (labels, ("time",)))
    band = np.abs(told[200:220] - np.array(DARK.label)).sum(axis=2) < 60
    assert band[:, :400].any()
    assert band[:, 400:].any()
    assert (told[-20:, :100] == silent[-20:, :100]).all()  # the time is in the last line


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"labels": "time"}, "labels: must be a tuple of 'time', 'dt'"),
        ({"labels": ("speed",)}, "labels: must be a tuple of"),
        ({"inset": "speed"}, "inset: must be 'energy', a Curve"),
        ({"inset": "energy", "size": (100, 80)}, "size: a panel with 1 inset needs"),
        ({"size": "large"}, "size: must be"),
    ],
)
def test_what_cannot_be_shown_is_refused(options: dict[str, Any], message: str, tmp_path: Path) -> None:
    recording = dust((0.0, 0.0), (1.0, 1.0))
    with pytest.raises(pc.SceneError, match=message):
        pc.film(recording, tmp_path / "film.gif", **options)
    bare = SimpleNamespace(**{n: getattr(recording, n) for n in ("scene", "times", "positions", "fps", "channels")})
    for unknown in ({"inset": "energy"}, {"labels": ("energy",)}, {"labels": ("dt",)}):
        with pytest.raises(pc.SceneError, match="is known of a Scene and of what simulate"):
            pc.film(bare, tmp_path / "film.gif", **unknown)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


# The inset.


@pytest.mark.parametrize("theme", [DARK, LIGHT])
@pytest.mark.parametrize("size", [(320, 240), (640, 480), (1280, 720)])
def test_the_curves_of_the_energy_grow_from_left_to_right(theme: Any, size: tuple[int, int]) -> None:
    """A falling stone: its kinetic energy is a parabola, which ends as high as the diagram is."""
    stone = pc.simulate(pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Gravity((0.0, -10.0))), 1.0, fps=10)
    style = pc.styles.Points(color="body", size=1.0, trail=0.0)
    camera = Window((50.0, 50.0), (51.0, 51.0))  # the stone is out of sight
    with renderer(stone, size, inset="energy", theme=theme, camera=camera, style=style) as made:
        diagram = made._panels[0].diagrams[0]
        found = [canvas.pixels().astype(int) for canvas in made.frames()]
    curve = diagram._lines[0]
    # T = m (g t)²/2: each tenth of the way it has risen with the square; exact but for the rounding of g·t, 1e-15.
    risen = (curve[0, 1] - curve[:, 1]) / (curve[0, 1] - curve[-1, 1])
    np.testing.assert_allclose(risen, np.linspace(0.0, 1.0, 11) ** 2, atol=1e-12)
    left, top, right, bottom = diagram._box
    assert left < curve[:, 0].min() < left + 0.1 * size[0]
    assert right - 0.1 * size[0] < curve[:, 0].max() < right
    assert top + 2 * diagram._text <= curve[:, 1].min() < curve[:, 1].max() < bottom
    for frame, picture in enumerate(found):
        for index, (x, y) in enumerate(curve):
            near = picture[int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2].reshape(-1, 3)
            drawn = np.abs(near - np.array(theme.bodies[0])).sum(axis=1).min() < 90
            if index <= frame or abs(x - curve[frame, 0]) > 8.0:
                assert drawn == (index <= frame)


# Colors.


@pytest.mark.parametrize("background", ["#000000", "#ffffff", "#808080", "#767676", "#ff0000", "#1040a0", "#e8d090"])
@pytest.mark.parametrize("theme", ["dark", "light"])
def test_text_stands_out_from_any_background(theme: Any, background: str, tmp_path: Path) -> None:
    for plain in (DARK, LIGHT):
        assert contrast(plain.text, plain.background) >= LEGIBLE
        assert contrast(plain.label, plain.background) >= LEGIBLE
        assert legible(plain) == plain
    recording = dust((0.0, 0.0), (1.0, 1.0))
    camera = Window((50.0, 50.0), (51.0, 51.0))
    pc.film(recording, tmp_path / "film.png", size=SIZE, theme=theme, background=background, camera=camera)
    with Image.open(tmp_path / "film.png") as image:
        picture = np.asarray(image.convert("RGB"))
    ground = tuple(int(value) for value in picture[0, 0])
    assert max(contrast(ground, tuple(map(int, color))) for color in picture[-20:, :80].reshape(-1, 3)) >= LEGIBLE
    assert contrast((0, 0, 0), (255, 255, 255)) == pytest.approx(21.0)


def test_maps_by_name_are_whole_and_defaults_suit_the_theme() -> None:
    """Magma begins black (S. van der Walt, N. Smith, 2015). A theme cuts its own defaults alone."""
    whole = sequential("magma", (0.0, 1.0), "c")
    np.testing.assert_array_equal(ramp("magma", "plasma", DARK.part, "c"), whole)
    assert whole[0].max() <= 4.0
    default = ramp(None, "magma", DARK.part, "c")
    np.testing.assert_array_equal(default, sequential("magma", DARK.part, "c"))
    assert default[0] @ LUMA > whole[0] @ LUMA + 30.0


def test_matplotlib_lends_its_color_maps(monkeypatch: pytest.MonkeyPatch) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    for name, table in ((name, matplotlib.colormaps[name]) for name in COLORMAPS if name in matplotlib.colormaps):
        exact = 255.0 * table(np.linspace(0.0, 1.0, 256))[:, :3]
        assert np.abs(sequential(name, (0.0, 1.0), "colormap") - exact).max() < 5.6, name
    # Of a map that goes from light to dark the same part is taken, of one that does neither all.
    up, down = (sequential(name, (0.3, 1.0), "c") for name in ("gray", "gray_r"))
    np.testing.assert_allclose(down, up[::-1], atol=1.5)  # one of the 256 steps
    whole = 255.0 * matplotlib.colormaps["twilight"](np.linspace(0.0, 1.0, 256))[:, :3]
    np.testing.assert_allclose(sequential("twilight", (0.3, 1.0), "c"), whole, atol=1e-9)
    assert pc.styles.Points(colormap="coolwarm").colormap == "coolwarm"
    with pytest.raises(
        pc.SceneError, match=r"Points\.colormap: must be one of 'viridis', .*a name that Matplotlib knows"
    ):
        pc.styles.Points(colormap="nothing")
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(pc.SceneError, match=r"pip install 'physcore\[plot\]'"):
        pc.styles.Points(colormap="coolwarm")
    pc.styles.Points(colormap="cividis")
