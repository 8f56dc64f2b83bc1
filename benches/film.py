"""The film of 5000 discs beside other ways to write a GIF, all in one run: `python benches/film.py [frames]`.

Ours is `physcore.film` from the recording to the file: survey, palette, drawing and encoding. The others get the same
positions. Pillow draws with ImageDraw, without anti-aliasing, and encodes with its defaults (a palette for each frame)
or with one palette for all; its drawing and its encoding are listed apart. Matplotlib, where it is installed, draws a
scatter plot in FuncAnimation, a tenth as many frames.
"""

from __future__ import annotations

import importlib.util
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import physcore as pc

SIZE = (640, 480)
DISCS = 5000
FPS = 30.0
DIAMETER = 5.0
GROUND = (15, 18, 24)


def bouncing(frames: int) -> pc.Recording:
    """Discs that fly straight and bounce off the sides of a box; simulating them is not timed."""
    generator = np.random.default_rng(1)
    discs = pc.Particles(generator.uniform(0.0, 1.0, (DISCS, 2)), generator.normal(0.0, 0.2, (DISCS, 2)))
    scene = pc.Scene(discs, pc.Box((0.0, 0.0), (1.0, 1.0)))
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


def milliseconds(work: Callable[[], object], frames: int, repetitions: int) -> float:
    """Wall time per frame, the best of some repetitions [ms]."""
    best = float("inf")
    for _ in range(repetitions):
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return 1000.0 * best / frames


def main(frames: int = 120) -> None:
    """Print a line for each way."""
    recording = bouncing(frames)
    rows: list[tuple[str, float, Path]] = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "ours.gif"
        style = pc.styles.Points(size=DIAMETER)
        rows.append(("physcore.film", milliseconds(lambda: pc.film(recording, path, style=style), frames, 3), path))
        start = time.perf_counter()
        pictures = pillow_pictures(recording)
        drawing = 1000.0 * (time.perf_counter() - start) / frames
        for name, write in (("Pillow, defaults", pillow_defaults), ("Pillow, one palette", pillow_one_palette)):
            target = Path(folder) / f"{write.__name__}.gif"
            spent = milliseconds(lambda write=write, target=target: write(pictures, target), frames, 1)  # type: ignore[misc]
            rows.append((f"{name}: {drawing:.1f} drawing + {spent:.1f} encoding", drawing + spent, target))
        if importlib.util.find_spec("matplotlib"):
            few = max(frames // 10, 2)
            target = Path(folder) / "matplotlib.gif"
            spent = milliseconds(lambda: matplotlib_animation(recording, few, target), few, 1)
            rows.append(("Matplotlib, FuncAnimation", spent, target))
        print(f"{DISCS} discs, {SIZE[0]}×{SIZE[1]}, {frames} frames: from positions to a GIF")
        for name, spent, target in rows:
            print(f"{name:<56} {spent:7.2f} ms per frame {target.stat().st_size / 1e6:7.2f} MB", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
