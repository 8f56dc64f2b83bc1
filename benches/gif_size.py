"""GIFs of demos beside those of ffmpeg and gifski from the same frames: bytes, SSIM, PSNR and time.

    python benches/gif_size.py            # the table of docs/films.md
    python benches/gif_size.py cloth lens # of some demos

SSIM (Z. Wang et al., 2004: brightness, Gaussian window of 11 pixels) and PSNR are means over the frames, of what Pillow
decodes against what was drawn. The tolerance of a film as large as an opponent's is found by bisection. ffmpeg is that
of `imageio-ffmpeg`, without dithering, which lowers both figures; gifski is found on the path (`cargo install gifski`).
"""

from __future__ import annotations

import io
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
from measure import table
from PIL import Image
from rivals import optional
from scipy.ndimage import gaussian_filter

from physcore._core import Canvas, Gif
from physcore.film.writers import gif
from physcore.film.writers.base import Film, FilmJob
from physcore.film.writers.budget import TOLERANCE
from physcore.gallery import demo

DEMOS = (
    "cloth", "drape", "flag", "spirals", "ripples", "dam_break", "turing", "galaxy", "butterfly", "vortex_street",
)  # fmt: skip
RATE = 25
PIXELS = 640 * 480
EVERY = 8
"""One of this many frames is compared."""
TRIALS = 4
"""Steps of the bisection."""
BRIGHTNESS = np.array([0.299, 0.587, 0.114], dtype=np.float32)


class Drawn(NamedTuple):
    """Frames of a demo as they are drawn, and what its palette is chosen from."""

    frames: np.ndarray
    samples: list[np.ndarray]
    reserved: list[tuple[int, int, int]]
    colors: list[tuple[int, int, int]]


def drawn(name: str) -> Drawn:
    """The film of a demo, in its whole size."""
    films: list[Drawn] = []

    def write(self: Any, job: FilmJob, target: Path) -> Film:
        samples = [canvas.pixels() for canvas in job.renderer.samples()]
        frames = np.array([canvas.pixels() for canvas in job.frames()])
        films.append(Drawn(frames, samples, job.renderer.reserved, job.renderer.colors))
        return Film(target, 0, job.renderer.size, len(frames), job.rate)

    usual, gif.GifWriter.write = gif.GifWriter.write, write  # type: ignore[method-assign]
    try:
        with TemporaryDirectory() as folder:
            demo(name).main(Path(folder) / "film.gif", False)
    finally:
        gif.GifWriter.write = usual  # type: ignore[method-assign]
    return films[-1]


def encoded(film: Drawn, tolerance: float) -> tuple[bytes, float]:
    """The bytes of a GIF, and the processor time per frame of 640 × 480 pixels [ms]."""
    _, height, width, _ = film.frames.shape
    writer = Gif(None, film.reserved)
    for picture in film.samples:
        sample = Canvas(picture.shape[1], picture.shape[0], (0, 0, 0))
        sample.picture(np.ascontiguousarray(picture), 0, 0)
        writer.observe(sample)
    writer.include(film.colors)
    writer.tolerate(tolerance)
    canvas, spent = Canvas(width, height, (0, 0, 0)), 0.0
    for picture in film.frames:
        canvas.picture(picture, 0, 0)
        start = time.process_time()
        writer.frame(canvas, 100 // RATE)
        writer.written()  # waits for the other thread
        spent += time.process_time() - start
    return writer.finish() or b"", _per_frame(spent, film.frames)


def as_large(film: Drawn, size: int) -> bytes:
    """The GIF whose size is nearest to another one's."""
    low, high, best = 0.0, 4.0 * TOLERANCE, encoded(film, TOLERANCE)[0]
    for _ in range(TRIALS):
        middle = 0.5 * (low + high)
        content, _ = encoded(film, middle)
        low, high = (middle, high) if len(content) > size else (low, middle)
        best = min(best, content, key=lambda each: abs(len(each) - size))
    return best


def ffmpeg(frames: np.ndarray) -> tuple[bytes, float] | None:
    """The GIF of ffmpeg with one palette for all frames, and the time; None if it is not installed."""
    module = optional("imageio_ffmpeg")
    if module is None:
        return None
    _, height, width, _ = frames.shape
    raw = f"-v error -threads 1 -f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {RATE} -i -".split()
    graph = "split[a][b];[a]palettegen=stats_mode=full[p];[b][p]paletteuse=dither=none"
    return _run([module.get_ffmpeg_exe(), *raw, "-filter_complex", graph, "-f", "gif", "-"], frames, frames.tobytes())


def gifski(frames: np.ndarray) -> tuple[bytes, float] | None:
    """The GIF of gifski at its default quality, and the time; None if it is not installed."""
    command = shutil.which("gifski")
    if command is None:
        return None
    with TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{index:04}.png" for index in range(len(frames))]
        for path, picture in zip(paths, frames, strict=True):
            Image.fromarray(picture).save(path, compress_level=0)
        size = "--width", str(frames.shape[2]), "--height", str(frames.shape[1])
        return _run([command, "--quiet", "--fps", str(RATE), *size, "-o", "-", *map(str, paths)], frames)


def _run(command: list[str], frames: np.ndarray, given: bytes = b"") -> tuple[bytes, float]:
    """The output of a program, and its processor time per frame [ms]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    content = subprocess.run(command, input=given, check=True, stdout=subprocess.PIPE).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return content, _per_frame(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, frames)


def _per_frame(seconds: float, frames: np.ndarray) -> float:
    count, height, width, _ = frames.shape
    return 1000.0 * seconds / count * PIXELS / (width * height)


def similarity(one: np.ndarray, other: np.ndarray) -> float:
    """Structural similarity of two pictures in gray."""

    def mean(values: np.ndarray) -> np.ndarray:
        return np.asarray(gaussian_filter(values, 1.5, radius=5))

    first, second = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    p, q = mean(one), mean(other)
    squares, product = mean(one * one) - p * p + mean(other * other) - q * q, mean(one * other) - p * q
    return float(np.mean((2 * p * q + first) * (2 * product + second) / ((p * p + q * q + first) * (squares + second))))


def figures(frames: np.ndarray, content: bytes) -> tuple[float, float, float]:
    """Megabytes, SSIM and PSNR of a GIF [dB]."""
    alike, ratios = [], []
    with Image.open(io.BytesIO(content)) as film:
        for index in range(0, min(len(frames), film.n_frames), EVERY):  # type: ignore[attr-defined]
            film.seek(index)
            shown, picture = np.asarray(film.convert("RGB"), dtype=np.float32), frames[index].astype(np.float32)
            alike.append(similarity(shown @ BRIGHTNESS, picture @ BRIGHTNESS))
            ratios.append(10.0 * np.log10(255.0**2 / max(float(np.mean((shown - picture) ** 2)), 1e-3)))
    return len(content) / 1e6, float(np.mean(alike)), float(np.mean(ratios))


def ways(name: str) -> Iterator[tuple[object, ...]]:
    """Rows of a demo."""

    def row(way: str, content: bytes, spent: float | None = None) -> tuple[object, ...]:
        size, alike, ratio = figures(film.frames, content)
        return name, way, f"{size:.2f}", f"{alike:.4f}", f"{ratio:.1f}", "" if spent is None else f"{spent:.1f}"

    film = drawn(name)
    yield row("physcore", *encoded(film, TOLERANCE))
    for way, found in (("ffmpeg", ffmpeg(film.frames)), ("gifski", gifski(film.frames))):
        if found is not None:
            yield row(way, *found)
            yield row(f"physcore, as large as {way}", as_large(film, len(found[0])))


def main(names: list[str]) -> None:
    """Print the table."""
    columns = ("demo", "", "MB", "SSIM", "PSNR [dB]", "ms per frame of 640×480")
    table("GIFs of the same frames", columns, (row for name in names for row in ways(name)))


if __name__ == "__main__":
    main(sys.argv[1:] or list(DEMOS))
