"""Every format of films: whole, in real time, the same for the same scene, and with the provenance of what it shows."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

import physcore as pc
from forks import Forks
from physcore.film import frame_cache, gif_bytes, provenance
from physcore.film.writers import WRITERS, delays
from physcore.film.writers.beside import videos_beside
from physcore.simulation.energy import Drift
from physcore.simulation.serial import unpack_numerics

SIZE = (160, 120)
ALL = [kind.suffixes[0] for kind in WRITERS]
PICTURES = [suffix for suffix in ALL if suffix != ".html"]
"""Formats that hold pixels; `test_page.py` shows pages in a browser."""
MOVING = [suffix for suffix in PICTURES if suffix != ".png"]
TICKS = {".gif": 100, ".webp": 1000, ".apng": 1000}
"""How many units of a delay make a second."""

ROPE = pc.rope(10, length=1.0, stiffness=100.0, mass=0.01, pinned="start")
SCENE = pc.Scene(ROPE, pc.Gravity((0.0, -9.81)), pc.Drag(linear=1e-3))


def ffmpeg(*arguments: str) -> subprocess.CompletedProcess[bytes]:
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    return subprocess.run([imageio_ffmpeg.get_ffmpeg_exe(), *arguments], capture_output=True, check=False)


def pictures(path: Path) -> list[np.ndarray]:
    """The frames of a film, as Pillow or FFmpeg decode them."""
    if path.suffix == ".mp4":
        width, height = map(int, re.findall(rb", (\d+)x(\d+)", ffmpeg("-i", str(path)).stderr)[0])
        raw = ffmpeg(
            "-v", "error", "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-fps_mode", "passthrough", "-"
        )
        return list(np.frombuffer(raw.stdout, np.uint8).reshape(-1, height, width, 3).astype(int))
    with Image.open(path) as image:
        found = []
        for index in range(getattr(image, "n_frames", 1)):
            image.seek(index)
            found.append(np.asarray(image.convert("RGB")).astype(int))
        return found


def ends(path: Path) -> np.ndarray:
    """When each frame of a film ends [s]."""
    if path.suffix == ".mp4":
        # One line for each frame: stream, decoding time, presentation time, duration, …; in ticks of the first lines.
        table = ffmpeg("-v", "error", "-i", str(path), "-c", "copy", "-f", "framecrc", "-").stdout.decode()
        numerator, denominator = map(int, re.findall(r"#tb 0: (\d+)/(\d+)", table)[0])
        rows = [[int(cell) for cell in line.split(",")[:4]] for line in table.splitlines() if line[0] != "#"]
        return np.sort([(shown + lasts) * numerator / denominator for _, _, shown, lasts in rows])
    with Image.open(path) as image:
        shown = []
        for index in range(image.n_frames):
            image.seek(index)
            image.load()
            shown.append(image.info["duration"])
        return np.cumsum(shown) / 1000


@pytest.mark.parametrize("suffix", PICTURES)
def test_every_format_holds_what_was_drawn(suffix: str, tmp_path: Path) -> None:
    """APNG exactly, the others nearly. Video has 219 levels of luma and 224 of chroma, which blue weighs 1.9 times:
    after rounding there and back a flat color is off by up to 0.6 + 1.1 + 0.5 steps; edges, which lose more, are few.
    """
    path = tmp_path / f"film{suffix}"
    pc.film(SCENE, path, duration=0.5, fps=20, size=SIZE)
    found = pictures(path)
    pc.film(SCENE, tmp_path / "exact.apng", duration=0.5, fps=20, size=SIZE)
    drawn = pictures(tmp_path / "exact.apng")
    pc.film(SCENE, tmp_path / "still.png", duration=0.5, fps=20, size=SIZE)
    np.testing.assert_array_equal(drawn[-1], pictures(tmp_path / "still.png")[0])
    assert len(drawn) == 11
    if suffix == ".png":
        drawn = drawn[-1:]
    assert len(found) == len(drawn)
    for mine, exact in zip(found, drawn, strict=True):
        assert mine.shape == (120, 160, 3)
        error = np.abs(mine - exact).mean()
        assert error == 0.0 if suffix in (".apng", ".png") else error < 2.2
    for index, (one, other) in enumerate(pairwise(found)):  # They are in order, and none stands for two.
        assert np.abs(one - drawn[index]).mean() < np.abs(other - drawn[index]).mean()


@pytest.mark.parametrize("suffix", MOVING)
@pytest.mark.parametrize("rate", [7.3, 29.97, 30.0])
def test_every_format_keeps_real_time(suffix: str, rate: float, tmp_path: Path) -> None:
    """No frame ends later or earlier than by half a unit of its delay; an MP4's clock divides the rate exactly."""
    path = tmp_path / f"film{suffix}"
    pc.film(SCENE, path, duration=20.5 / rate, fps=rate, size=SIZE)
    half = 0.5 / TICKS[suffix] if suffix in TICKS else 1e-6
    np.testing.assert_allclose(ends(path), np.arange(1, 22) / rate, rtol=0, atol=half + 1e-9)


@pytest.mark.parametrize("suffix", MOVING)
def test_a_frame_like_the_one_before_is_still_a_frame(suffix: str, tmp_path: Path) -> None:
    scene = pc.Scene(pc.Particles([[2.0, 3.0]]))
    shape = (5, 1, 2)
    channels = {"positions": np.full(shape, 2.0), "velocities": np.zeros(shape)}
    still = SimpleNamespace(
        scene=scene, times=np.zeros(5), positions=channels["positions"], fps=10.0, channels=channels
    )
    path = tmp_path / f"film{suffix}"
    pc.film(still, path, size=(33, 47))  # type: ignore[arg-type]
    assert len(pictures(path)) == 5
    np.testing.assert_allclose(ends(path), np.arange(1, 6) / 10.0, atol=1e-9)


def test_odd_sides_are_made_even_where_the_format_wants_it(tmp_path: Path) -> None:
    pc.film(SCENE, tmp_path / "film.mp4", duration=0.1, size=(101, 51))
    found = pictures(tmp_path / "film.mp4")[0]
    assert found.shape == (52, 102, 3)
    assert np.abs(found[-1] - found[-2]).max() <= 8  # the row that was there already, up to the loss


@pytest.mark.parametrize("suffix", ALL)
def test_the_same_scene_gives_the_same_bytes_for_any_number_of_threads(suffix: str, tmp_path: Path) -> None:
    content = []
    for number, threads in enumerate((1, 2, 2)):
        path = tmp_path / f"film{number}{suffix}"
        pc.film(SCENE, path, duration=0.3, size=SIZE, threads=threads)
        content.append(path.read_bytes())
    assert content[0] == content[1] == content[2]


def test_an_mp4_can_begin_before_it_is_loaded_and_plays_everywhere(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    pc.film(SCENE, path, duration=0.3, size=SIZE)
    content = path.read_bytes()
    assert content.index(b"moov") < content.index(b"mdat")
    assert b"h264" in ffmpeg("-i", str(path)).stderr
    assert b"yuv420p" in ffmpeg("-i", str(path)).stderr


def never(time: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
    raise AssertionError("it was simulated")


@pytest.mark.parametrize(("suffix", "fastest"), [(".gif", 50), (".webp", 90), (".apng", 90), (".mp4", 240)])
def test_what_a_format_cannot_show_is_refused_before_anything_is_simulated(
    suffix: str, fastest: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, path = pc.Scene(ROPE, pc.CustomForce(never)), tmp_path / f"film{suffix}"
    with pytest.raises(pc.SceneError, match=f"at most {fastest} frames per second, got {fastest + 1}; record fewer"):
        pc.film(scene, path, duration=1.0, fps=fastest + 1, speed=1.0)
    with pytest.raises(pc.SceneError, match=r"shows a frame for at most \d+ s"):
        pc.film(scene, path, duration=1e5, fps=1e-5)
    with pytest.raises(pc.FileError, match="no such folder"):
        pc.film(scene, tmp_path / "none" / path.name, duration=1.0)
    if suffix == ".mp4":
        monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
        with pytest.raises(pc.PhyscoreError, match=re.escape("pip install 'physcore[video]'")):
            pc.film(scene, path, duration=1.0)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", ALL)
def test_a_device_is_not_replaced_and_a_link_stays_a_link(suffix: str, tmp_path: Path) -> None:
    link, film = tmp_path / f"link{suffix}", tmp_path / f"film{suffix}"
    link.symlink_to("/dev/full")
    with pytest.raises(pc.FileError, match=f"link{suffix}: cannot be written: not a regular file"):
        pc.film(SCENE, link, duration=0.1, size=SIZE)
    assert Path("/dev/full").is_char_device()
    link.unlink()
    film.write_bytes(b"old")
    link.symlink_to(film)
    pc.film(SCENE, link, duration=0.1, size=SIZE)
    assert link.is_symlink()
    assert film.stat().st_size > 100


FILMING = """
import resource, sys
import physcore as pc
path, limit, duration = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
if limit:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
rope = pc.rope(10, length=1.0, stiffness=100.0, mass=0.01, pinned="start")
try:
    pc.film(pc.Scene(rope, pc.Gravity((0.0, -9.81))), path, duration=duration, size=(320, 240))
except pc.FileError as error:
    sys.exit(str(error))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""
"""Films a rope for some seconds; it may write so many bytes into a file, if any number is given."""


@pytest.mark.parametrize("suffix", ALL)
def test_a_full_disk_leaves_the_old_film_and_nothing_else(suffix: str, tmp_path: Path, forks: Forks) -> None:
    path = tmp_path / f"film{suffix}"
    path.write_bytes(b"old")
    status, _, error = forks.run(FILMING, path, 2000, 1.0)
    assert status == 1, error
    assert re.search(rf"film{re.escape(suffix)}: cannot be written: (File too large|File size limit exceeded)", error)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("suffix", MOVING)
def test_a_kill_in_the_middle_leaves_the_old_film(suffix: str, tmp_path: Path, forks: Forks) -> None:
    path = tmp_path / f"film{suffix}"
    path.write_bytes(b"old")
    process = forks.start(FILMING, path, 0, 100.0)
    while not any(entry.stat().st_size > 0 for entry in tmp_path.iterdir() if entry != path):
        os.kill(process, 0)  # It is there.
        time.sleep(0.02)
    os.kill(process, signal.SIGKILL)
    assert forks.end().returncode == -signal.SIGKILL
    assert path.read_bytes() == b"old"


@pytest.mark.parametrize("suffix", MOVING)
def test_memory_does_not_grow_with_the_number_of_frames(suffix: str, tmp_path: Path, forks: Forks) -> None:
    """180 more frames of 320 × 240 take 41 MB where they are kept, and 4 MB where one byte of ten of them is."""
    most = []
    for duration in (1.0, 7.0):
        _, output, error = forks.run(FILMING, tmp_path / f"film{suffix}", 0, duration)
        most.append(int(output or pytest.fail(error)))
    assert most[1] - most[0] < 10_000  # [kB]


@pytest.mark.parametrize("suffix", ALL)
def test_the_provenance_travels_with_the_film(suffix: str, tmp_path: Path) -> None:
    """In the film and beside it, the same for a recording and for a scene that is simulated while it is filmed."""
    recorded, streamed = tmp_path / f"recorded{suffix}", tmp_path / f"streamed{suffix}"
    recording = pc.simulate(SCENE, 0.5, dt=1e-3)
    pc.film(recording, recorded, size=SIZE, sidecar=True)
    pc.film(SCENE, streamed, duration=0.5, dt=1e-3, size=SIZE)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == [
        recorded.name,
        f"{recorded.name}.json",
        streamed.name,
    ]
    (panel,) = provenance(recorded)
    assert provenance(streamed) == [panel]
    assert recorded.read_bytes() == streamed.read_bytes()
    (beside,) = provenance(f"{recorded}.json")
    assert beside.pop("machine") == {"threads": recording.plan.threads, "simd": recording.plan.simd}
    assert beside == panel
    assert panel["physcore"] == pc.__version__
    assert panel["scene"] == SCENE.hash()
    assert panel["segments"] == [{"start": 0.0, "steps": 500, "dt": 1e-3}]
    assert panel["energy_drift"] == np.abs(recording.energy.drift).max() > 0.0
    assert (panel["duration"], panel["fps"], panel["substeps"], panel["seed"]) == (0.5, 30.0, 0, None)
    assert panel["momentum"] == [recording.momentum[0].tolist(), recording.momentum[-1].tolist()]


def meeting() -> pc.Scene:
    """Two atoms that fly at each other, too fast for their steps, which are taken again in parts."""
    atoms = pc.Particles([[-2.0, 0.0], [2.0, 0.0]], velocities=[[6.0, 0.0], [-6.0, 0.0]])
    return pc.Scene(atoms, pc.LennardJones(epsilon=1.0, sigma=1.0))


def fluid() -> pc.Scene:
    """A block of water that falls into a box."""
    water = pc.Fluid(pc.block((0.0, 0.2), (0.5, 0.7), 0.05), 0.05)
    return pc.Scene(water, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (1.0, 1.0)))


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@pytest.mark.parametrize(
    ("scene", "numerics", "segments"),
    [
        (SCENE, {"dt": 1e-3}, 1),
        (SCENE, {"integrator": pc.PEFRL()}, 1),
        (fluid(), {"precision": "f32", "fluids": pc.WeaklyCompressible(sound_speed=80.0)}, 1),
        (meeting(), {"dt": 0.02, "on_divergence": "substep"}, 3),
    ],
)
def test_the_provenance_is_enough_to_do_it_again(scene: pc.Scene, numerics: Any, segments: int, tmp_path: Path) -> None:
    path = tmp_path / "film.gif"
    pc.film(scene, path, duration=0.6, size=SIZE, **numerics)
    (panel,) = provenance(path)
    assert scene.hash() == panel["scene"]
    assert len(panel["segments"]) >= segments
    simulation = None
    for segment in panel["segments"]:
        options = unpack_numerics({**panel["numerics"], "threads": None})
        again = pc.Simulation(scene, **{**options, "dt": segment["dt"]})
        if simulation is not None:
            again._world.restore(simulation._world.capture())
        again.step(segment["steps"])
        simulation = again
    assert simulation is not None
    assert simulation.state_hash() == panel["state"]


def test_the_drift_is_the_same_from_one_budget_at_a_time() -> None:
    """To the bit: the formula of `EnergySeries.drift`, with every part of the budget in motion."""
    random = np.random.default_rng(3)
    parts = {name: random.normal(size=50) for name in ("kinetic", "internal", "dissipated", "work", "times")}
    by_term = {name: random.normal(size=50) for name in ("springs", "gravity")}
    series = pc.EnergySeries(by_term=by_term, dissipated_by={}, **{**parts, "kinetic": abs(parts["kinetic"])})
    for frames in (1, 2, 50):
        some = {entry.name: getattr(series, entry.name) for entry in dataclasses.fields(series)}
        some = {name: value[:frames] for name, value in some.items() if isinstance(value, np.ndarray)}
        part = pc.EnergySeries(by_term={k: v[:frames] for k, v in by_term.items()}, dissipated_by={}, **some)
        drift = Drift()
        for index in range(frames):
            drift.add(part.at(index))
        assert drift.largest == np.abs(part.drift).max()


def test_each_panel_has_its_provenance(tmp_path: Path) -> None:
    path = tmp_path / "film.gif"
    coarse, fine = pc.simulate(SCENE, 0.2, dt=2e-3), pc.simulate(SCENE, 0.2, dt=1e-3)
    pc.film([coarse, fine], path, size=SIZE)
    assert [panel["segments"][0]["dt"] for panel in provenance(path)] == [2e-3, 1e-3]
    assert [panel["state"] for panel in provenance(path)] == [each.provenance.state_hash for each in (coarse, fine)]  # type: ignore[union-attr]


def test_a_film_in_memory_has_the_provenance_too(tmp_path: Path) -> None:
    recording = pc.simulate(SCENE, 0.2)
    path = tmp_path / "film.gif"
    path.write_bytes(gif_bytes(recording, size=SIZE))
    assert provenance(path)[0]["scene"] == SCENE.hash()


def test_a_scene_with_code_has_no_hash_and_says_so(tmp_path: Path) -> None:
    scene = pc.Scene(pc.Particles([[0.0, 0.0]]), pc.CustomForce(lambda time, x, v: -x))
    pc.film(scene, tmp_path / "film.gif", duration=0.1, size=SIZE)
    assert provenance(tmp_path / "film.gif")[0]["scene"] is None


def test_a_scene_that_does_not_repeat_itself_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frame_cache, "SHARE", 0.0)  # frames that were put aside are drawn as they were
    random = np.random.default_rng(1)
    scene = pc.Scene(pc.Particles([[0.0, 0.0]]), pc.CustomForce(lambda time, x, v: random.normal(size=x.shape)))
    with pytest.raises(pc.InternalError, match="CustomForce"):
        pc.film(scene, tmp_path / "film.gif", duration=0.1, size=SIZE)
    assert not list(tmp_path.iterdir())


def test_adaptive_steps_leave_their_range(tmp_path: Path) -> None:
    orbit = pc.Particles([[1.0, 0.0]], velocities=[[0.0, 0.5]])
    scene = pc.Scene(orbit, pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0))
    pc.film(scene, tmp_path / "film.gif", duration=2.0, fps=10, size=SIZE, dt=pc.AdaptiveStep())
    (segment,) = provenance(tmp_path / "film.gif")[0]["segments"]
    assert 0.0 < segment["dt"][0] < segment["dt"][1]


def test_equal_scenes_have_one_hash_and_others_another() -> None:
    def build(stiffness: float = 100.0, gravity: float = -9.81) -> pc.Scene:
        rope = pc.rope(10, length=1.0, stiffness=stiffness, mass=0.01, pinned="start")
        return pc.Scene(rope, pc.Gravity((0.0, gravity)), pc.Drag(linear=1e-3))

    assert build().hash() == build().hash() == SCENE.hash()
    assert len({build().hash(), build(101.0).hash(), build(gravity=-9.80).hash(), fluid().hash()}) == 4
    script = (
        "import physcore as pc; rope = pc.rope(10, length=1.0, stiffness=100.0, mass=0.01, pinned='start');"
        "print(pc.Scene(rope, pc.Gravity((0.0, -9.81)), pc.Drag(linear=1e-3)).hash())"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONHASHSEED": "7"},
    )
    assert done.stdout.strip() == SCENE.hash()


@pytest.mark.parametrize("suffix", ALL)
def test_what_says_nothing_is_no_provenance(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"film{suffix}"
    with pytest.raises(pc.FileError, match="cannot be read: No such file"):
        provenance(path)
    path.write_bytes(b"rubbish" * 10)
    with pytest.raises(pc.FileError, match=f"film{suffix}: "):
        provenance(path)


def test_delays_are_whole_units_that_add_up() -> None:
    for ticks in TICKS.values():
        found = delays(1000, 29.97, ticks)
        late = np.cumsum(found) / ticks - np.arange(1, 1001) / 29.97
        assert np.abs(late).max() <= 0.5 / ticks + 1e-9


def test_a_sidecar_is_json_that_others_read(tmp_path: Path) -> None:
    pc.film(SCENE, tmp_path / "film.gif", duration=0.1, size=SIZE)
    assert not (tmp_path / "film.gif.json").exists()  # it is made for those who ask
    pc.film(SCENE, tmp_path / "film.gif", duration=0.1, size=SIZE, sidecar=True)
    assert json.loads((tmp_path / "film.gif.json").read_text())[0]["fps"] == 30.0


def busy() -> pc.Recording:
    """Two hundred colored discs that fly about for a second."""
    generator = np.random.default_rng(1)
    discs = pc.Particles(generator.uniform(size=(200, 2)), generator.normal(size=(200, 2)))
    return pc.simulate(pc.Scene(discs, pc.Box((0.0, 0.0), (1.0, 1.0))), 1.0, fps=40, progress=False)


def test_a_film_fits_into_the_bytes_that_it_may_have(tmp_path: Path) -> None:
    """What is given up comes in its order: near colors, the width to a half, frames, colors, and all of these again."""
    recording, path = busy(), tmp_path / "film.gif"
    whole = pc.film(recording, path, size=(320, 240))
    assert (whole.size, whole.frames, whole.rate, whole.colors) == ((320, 240), 41, 40.0, 255)
    assert whole.bytes == path.stat().st_size
    assert pc.film(recording, path, size=(320, 240), max_bytes=2 * whole.bytes) == whole
    last = whole
    for share in (0.8, 0.3, 0.07):
        film = pc.film(recording, path, size=(320, 240), max_bytes=int(share * whole.bytes))
        assert film.bytes == path.stat().st_size <= share * whole.bytes
        assert film.bytes >= 0.7 * share * whole.bytes or film.colors == 31  # what may be used is used
        assert film.size[0] * film.frames <= last.size[0] * last.frames
        assert film.colors is not None
        assert film.colors == 255 or film.frames < 41
        assert film.size[0] >= 160 or film.colors <= 63
        with Image.open(path) as image:
            assert (image.size, image.n_frames) == (film.size, film.frames)
            times = []
            for index in range(image.n_frames):
                image.seek(index)
                times.append(image.info["duration"])
        assert sum(times) == pytest.approx(1000.0 * film.frames / film.rate, abs=10)  # it stays in real time
        last = film
    with pytest.raises(pc.SceneError, match=r"max_bytes: 5000 are too few: at a quarter of the width, 10 frames"):
        pc.film(recording, tmp_path / "none.gif", size=(320, 240), max_bytes=5000)
    assert not (tmp_path / "none.gif").exists()


def test_other_formats_than_gifs_are_only_measured(tmp_path: Path) -> None:
    with pytest.warns(pc.SceneWarning, match="is larger than max_bytes; only GIFs are made to fit"):
        pc.film(busy(), tmp_path / "film.png", size=(320, 240), max_bytes=100)
    pc.film(busy(), tmp_path / "film.png", size=(320, 240), max_bytes=1_000_000)


def test_a_cut_film_of_a_scene_is_that_of_its_recording(tmp_path: Path) -> None:
    recording = busy()
    one = pc.film(recording, tmp_path / "one.gif", size=(200, 150), max_bytes=60_000)
    pc.film(recording.scene, tmp_path / "two.gif", duration=1.0, fps=40, size=(200, 150), max_bytes=60_000)
    assert one.size < (200, 150)
    pictures = []
    for name in ("one.gif", "two.gif"):
        with Image.open(tmp_path / name) as image:
            image.seek(image.n_frames - 1)
            pictures.append(np.asarray(image.convert("RGB")))
    assert (pictures[0] == pictures[1]).all()


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("film.gif", {"quality": "best"}, r"quality: must be 'fast' or 'high', got 'best'"),
        ("film.gif", {"max_bytes": 0}, r"max_bytes: must be ≥ 1"),
        ("film.gif", {"max_bytes": 1e6}, r"max_bytes: must be a whole number"),
    ],
)
def test_a_budget_that_makes_no_sense_is_refused(
    name: str, options: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with pytest.raises(pc.SceneError, match=message):
        pc.film(busy(), tmp_path / name, **options)


def test_a_film_says_what_was_written(tmp_path: Path) -> None:
    film = pc.film(busy(), tmp_path / "film.gif", size=(64, 48), quality="high")
    assert repr(film).startswith(f"{tmp_path / 'film.gif'}: 64×48, 41 frames, 40 per second, 255 colors, 0.")
    still = pc.film(busy(), tmp_path / "still.png", size=(64, 48))
    assert repr(still) == f"{tmp_path / 'still.png'}: 64×48, {still.bytes / 1e6:.2f} MB"


def test_a_gif_beside_its_video_has_the_same_frames(tmp_path: Path) -> None:
    """Within the context each GIF is followed by a video of the whole size; without it there is none."""
    recording = busy()
    with videos_beside() as films:
        pc.film(recording, tmp_path / "film.gif", size=(320, 240), max_bytes=30_000)
    gif, video = films
    assert gif.path == tmp_path / "film.gif"
    assert gif.size < (320, 240) == video.size
    assert (video.frames, video.bytes) == (41, video.path.stat().st_size)
    assert video.path.suffix in (".mp4", ".webp")
    assert "<video" in video._repr_html_() or video.path.suffix == ".webp"
    pc.film(recording, tmp_path / "other.gif", size=(64, 48))
    assert not (tmp_path / f"other{video.path.suffix}").exists()
