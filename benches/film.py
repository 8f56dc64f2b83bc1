"""The film of 5000 discs with trails beside other ways to write a GIF, all in one run: `python benches/film.py`.

Ours is `physcore.film` from the recording to the file: first pass, palette, drawing and encoding; then drawing alone,
and encoding alone in each quality, one frame after the other. ffmpeg, where imageio-ffmpeg is installed, encodes our
frames, with those of its statistics and dithering that keep them best. Pillow draws the same positions with ImageDraw,
without anti-aliasing and trails, and encodes them with its defaults (a palette for each frame) or with one palette for
all. Matplotlib, where it is installed, draws a scatter plot in FuncAnimation without trails, a tenth as many frames.
Before these, a million particles at 800×600 are drawn and encoded on one core, in processor time, after a first pass
that is not counted.

The last column is the peak signal-to-noise ratio of what Pillow decodes against the frames as they were drawn, the mean
over the frames [dB].
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import nan
from pathlib import Path
from typing import Literal

import numpy as np
from measure import table
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from rivals import optional

import physcore as pc
from physcore._core import Gif
from physcore.film.colors.themes import resolve
from physcore.film.film_renderer import FilmRenderer
from physcore.film.writers import delays
from physcore.film.writers.budget import TOLERANCE
from physcore.simulation.sources import sources

SIZE = (640, 480)
DISCS = 5000
LARGE, MILLION = (800, 600), 1_000_000
FPS = 30.0
DIAMETER = 5.0
TRAIL = 0.25
GROUND = (15, 18, 24)
STYLE = pc.styles.Points(size=DIAMETER, trail=TRAIL)


def bouncing(count: int, dimension: int, frames: int) -> pc.Recording:
    """Discs that fly straight and bounce off the sides of a box; simulating them is not timed."""
    generator = np.random.default_rng(1)
    shape = (count, dimension)
    discs = pc.Particles(generator.uniform(0.0, 1.0, shape), generator.normal(0.0, 0.2, shape))
    scene = pc.Scene(discs, pc.Box((0.0,) * dimension, (1.0,) * dimension))
    return pc.simulate(scene, (frames - 1) / FPS, FPS, progress=False)


def pillow_pictures(recording: pc.Recording) -> list[Image.Image]:
    """The discs drawn by ImageDraw, which has no anti-aliasing."""
    speed = np.linalg.norm(recording.velocities[0], axis=1)
    red = (255 * speed / speed.max()).astype(int)
    colors = [(int(value), 120, 255 - int(value)) for value in red]
    pictures = []
    for positions in recording.positions * 440 + (100, 20):
        picture = Image.new("RGB", SIZE, GROUND)
        draw = ImageDraw.Draw(picture)
        for (x, y), color in zip(positions.tolist(), colors, strict=True):
            draw.ellipse((x - DIAMETER / 2, y - DIAMETER / 2, x + DIAMETER / 2, y + DIAMETER / 2), fill=color)
        pictures.append(picture)
    return pictures


def pillow_defaults(pictures: list[Image.Image], path: Path) -> None:
    """A palette for each frame."""
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=33, loop=0)


def pillow_one_palette(pictures: list[Image.Image], path: Path) -> None:
    """One palette for all frames, found from the first."""
    palette = pictures[0].quantize(255)
    indexed = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    indexed[0].save(path, save_all=True, append_images=indexed[1:], duration=33, loop=0, optimize=False)


def matplotlib_animation(recording: pc.Recording, frames: int, path: Path) -> None:
    """A scatter plot in FuncAnimation."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import animation, pyplot

    figure = pyplot.figure(figsize=(6.4, 4.8), dpi=100)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0, 1), ylim=(0, 1))
    points = axes.scatter(recording.positions[0, :, 0], recording.positions[0, :, 1], s=9)

    def show(index: int) -> tuple[object, ...]:
        points.set_offsets(recording.positions[index])
        return (points,)

    film = animation.FuncAnimation(figure, show, frames=frames, blit=False)  # type: ignore[arg-type]
    film.save(path, writer="pillow", fps=30)
    pyplot.close(figure)


def renderer_of(recording: pc.Recording) -> FilmRenderer:
    """What `physcore.film` draws."""
    return FilmRenderer(sources(recording, None, None, {}), SIZE, STYLE, None, resolve("dark"), None, False)


@contextmanager
def one_core() -> Iterator[None]:
    """Run what follows on one core."""
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, cores)


def draw(recording: pc.Recording) -> None:
    """Draw all frames, and the first pass."""
    for _ in renderer_of(recording).frames():
        pass


def encode(recording: pc.Recording, path: Path, tolerance: float) -> float:
    """Wall time per frame of palette and encoding, one frame after the other, without drawing [ms]."""
    renderer = renderer_of(recording)
    gif = Gif(path, renderer.reserved)
    gif.tolerate(tolerance)
    spent = 0.0
    for canvas in renderer.samples():
        start = time.perf_counter()
        gif.observe(canvas)
        spent += time.perf_counter() - start
    for canvas, delay in zip(renderer.frames(), delays(renderer.count, FPS, 100), strict=True):
        start = time.perf_counter()
        gif.frame(canvas, delay)
        gif.written()  # waits for the other thread
        spent += time.perf_counter() - start
    gif.finish()
    return 1000.0 * spent / renderer.count


def million(dimension: int) -> float:
    """Processor time per frame of drawing and encoding a million particles on one core, the best of five [ms]."""
    with one_core():
        found = sources(bouncing(MILLION, dimension, 6), None, None, {})
        renderer = FilmRenderer(found, LARGE, None, None, resolve("dark"), None, False)
        gif = Gif(None, renderer.reserved)
        for canvas in renderer.samples():
            gif.observe(canvas)
        best, start = float("inf"), time.process_time()
        for canvas in renderer.frames():
            gif.frame(canvas, 3)
            gif.written()  # waits for the other thread
            end = time.process_time()
            best, start = min(best, end - start), end
        gif.finish()
    return 1000.0 * best


def ffmpeg(frames: NDArray[np.uint8], path: Path, statistics: str, dither: str) -> None:
    """One palette for all frames."""
    from imageio_ffmpeg import get_ffmpeg_exe

    size = "x".join(map(str, SIZE))
    raw = f"-v error -y -f rawvideo -pix_fmt rgb24 -s {size} -r {FPS:g} -i -".split()
    graph = f"split[a][b];[a]palettegen=stats_mode={statistics}[p];[b][p]paletteuse=dither={dither}"
    subprocess.run([get_ffmpeg_exe(), *raw, "-filter_complex", graph, path], input=frames.tobytes(), check=True)


def best_ffmpeg(frames: NDArray[np.uint8], path: Path) -> tuple[str, float]:
    """The settings that keep the frames best, left under `path`, and their time per frame [ms]."""
    found = []
    for statistics in ("full", "diff"):
        for dither in ("none", "bayer:bayer_scale=5", "sierra2_4a"):
            spent = milliseconds(lambda s=statistics, d=dither: ffmpeg(frames, path, s, d), len(frames), 1)  # type: ignore[misc]
            found.append((fidelity(frames, path), spent, statistics, dither))
    _, spent, statistics, dither = max(found)
    ffmpeg(frames, path, statistics, dither)
    return f"ffmpeg, encoding alone: stats_mode={statistics}, dither={dither}", spent


def fidelity(frames: NDArray[np.uint8], path: Path) -> float:
    """Peak signal-to-noise ratio of a GIF against the frames that it was made from, the mean over the frames [dB]."""
    ratios = []
    with Image.open(path) as film:
        for index, frame in enumerate(frames):
            film.seek(index)
            error = np.asarray(film.convert("RGB"), dtype=np.float32) - frame
            ratios.append(10.0 * np.log10(255.0**2 / float(np.mean(error**2))))
    return float(np.mean(ratios))


def milliseconds(
    work: Callable[[], object], frames: int, repetitions: int, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Time per frame, the best of some repetitions [ms]; wall time, or that of another clock."""
    best = float("inf")
    for _ in range(repetitions):
        start = clock()
        work()
        best = min(best, clock() - start)
    return 1000.0 * best / frames


def ways(frames: int) -> Iterator[tuple[object, ...]]:
    """Each way, its time per frame [ms], the size of its file [MB] and how true that is [dB]."""
    recording = bouncing(DISCS, 2, frames)
    drawn = np.array([canvas.pixels() for canvas in renderer_of(recording).frames()])[..., :3]
    with tempfile.TemporaryDirectory() as folder:

        def row(name: str, spent: float, path: Path | None = None, *, ours: bool = True) -> tuple[object, ...]:
            size = path.stat().st_size / 1e6 if path else ""
            return name, spent, size, fidelity(drawn, path) if path and ours else ""

        path = Path(folder) / "film.gif"
        qualities: tuple[Literal["fast", "high"], ...] = ("fast", "high")
        for quality in qualities:
            options = {"size": SIZE, "style": STYLE, "quality": quality}
            spent = milliseconds(lambda options=options: pc.film(recording, path, **options), frames, 3)  # type: ignore[misc]
            yield row(f"physcore.film, quality={quality!r}", spent, path)
        yield row("drawing alone", milliseconds(lambda: draw(recording), frames, 3))
        with one_core():
            spent = milliseconds(lambda: draw(recording), frames, 3, time.process_time)
        yield row("drawing alone, processor time on one core", spent)
        for quality in qualities:
            spent = min(encode(recording, path, TOLERANCE) for _ in range(3))
            yield row(f"encoding alone, quality={quality!r}", spent, path)
        absent = (nan, "", "")
        yield row(*best_ffmpeg(drawn, path), path) if optional("imageio_ffmpeg") else ("ffmpeg, not installed", *absent)
        for dimension in (2, 3):
            name = f"{MILLION} particles in {dimension}D, {LARGE[0]}×{LARGE[1]}, drawing and encoding on one core"
            yield row(name, million(dimension), ours=False)
        start = time.perf_counter()
        pictures = pillow_pictures(recording)
        drawing = 1000.0 * (time.perf_counter() - start) / frames
        for name, write in (("Pillow, defaults", pillow_defaults), ("Pillow, one palette", pillow_one_palette)):
            spent = milliseconds(lambda write=write: write(pictures, path), frames, 1)  # type: ignore[misc]
            yield row(f"{name}: {drawing:.1f} drawing + {spent:.1f} encoding", drawing + spent, path, ours=False)
        if optional("matplotlib"):
            few = max(frames // 10, 2)
            spent = milliseconds(lambda: matplotlib_animation(recording, few, path), few, 1)
            yield row("Matplotlib, FuncAnimation, a tenth of the frames", spent, path, ours=False)
        else:
            yield "Matplotlib, not installed", *absent


def main(frames: int = 120) -> None:
    """Print a row for each way."""
    title = f"{DISCS} discs with trails, {SIZE[0]}×{SIZE[1]}, {frames} frames: from positions to a GIF"
    table(title, ("", "ms per frame", "MB", "dB"), ways(frames))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
