"""What makes GIFs small: the bytes of demos' films by tolerance, rate, colors and size, with the error that each makes.

    python benches/gif_size.py            # the table of docs/films.md
    python benches/gif_size.py cloth lens # of some demos

The error is the root mean square over all pixels and channels, in levels of 255, from what was drawn; it holds what the
palette of 255 colors leaves out. Frames that are left out are compared with the last one shown.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from measure import table

from physcore._core import Canvas, Gif
from physcore.film.writers import gif
from physcore.film.writers.base import Film, FilmJob
from physcore.gallery import demo

DEMOS = ("cloth", "lens", "galaxy", "flag")
WAYS: dict[str, dict[str, Any]] = {
    "nearest color": {},
    "within 10 levels": {"tolerance": 10},
    "within 18 levels": {"tolerance": 18},
    "within 28 levels": {"tolerance": 28},
    "63 colors": {"colors": 63},
    "every second frame": {"stride": 2},
    "¾ of the width": {"scale": 0.75},
}


def drawn(name: str) -> list[np.ndarray]:
    """The frames of a demo's film as they are drawn."""
    pictures: list[np.ndarray] = []

    def write(self: Any, job: FilmJob, target: Path) -> Film:
        pictures.extend(canvas.pixels() for canvas in job.frames())
        return Film(target, 0, job.renderer.size, len(pictures), job.rate)

    usual, gif.GifWriter.write = gif.GifWriter.write, write  # type: ignore[method-assign]
    try:
        with TemporaryDirectory() as folder:
            demo(name).main(Path(folder) / "film.gif", False)
    finally:
        gif.GifWriter.write = usual  # type: ignore[method-assign]
    return pictures


def encoded(
    pictures: list[np.ndarray], tolerance: int = 0, colors: int = 255, stride: int = 1, scale: float = 1.0
) -> bytes:
    """The bytes of a GIF."""
    chosen = [_shrunk(picture, scale) for picture in pictures[::stride]]
    height, width, _ = chosen[0].shape
    canvas, film = Canvas(width, height, (0, 0, 0)), Gif(None, [tuple(map(int, chosen[0][0, 0]))], colors=colors)
    for index in np.linspace(0, len(chosen) - 1, 8).astype(int):
        canvas.picture(chosen[index], 0, 0)
        film.observe(canvas)
    film.tolerate(tolerance)
    for picture in chosen:
        canvas.picture(picture, 0, 0)
        film.frame(canvas, 4)
    return film.finish() or b""


def error(pictures: list[np.ndarray], content: bytes, stride: int) -> float:
    """The root mean square of what a film changes [levels of 255]."""
    import io

    from PIL import Image

    total = 0.0
    with Image.open(io.BytesIO(content)) as image:
        for index, picture in enumerate(pictures):
            image.seek(index // stride)
            shown = image.convert("RGB").resize(picture.shape[1::-1], Image.Resampling.BICUBIC)
            total += float(np.mean((np.asarray(shown, dtype=float) - picture) ** 2))
    return (total / len(pictures)) ** 0.5


def _shrunk(picture: np.ndarray, scale: float) -> np.ndarray:
    if scale == 1.0:
        return np.ascontiguousarray(picture)
    from PIL import Image

    height, width, _ = picture.shape
    size = round(scale * width), round(scale * height)
    return np.ascontiguousarray(Image.fromarray(picture).resize(size, Image.Resampling.BOX))


def figures(pictures: list[np.ndarray], options: dict[str, Any]) -> str:
    """Megabytes and error of a film."""
    content = encoded(pictures, **options)
    return f"{len(content) / 1e6:.2f}, {error(pictures, content, options.get('stride', 1)):.1f}"


def main(names: list[str]) -> None:
    """Print the table."""
    films = [drawn(name) for name in names]
    rows = ((way, *(figures(film, options) for film in films)) for way, options in WAYS.items())
    table("Sizes of GIFs", ("MB, and error in levels of 255", *names), rows)


if __name__ == "__main__":
    main(sys.argv[1:] or list(DEMOS))
