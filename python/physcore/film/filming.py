"""The recipe of a film: look at everything once, choose camera and colors, then draw frame by frame."""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Unpack

from physcore._core import Gif
from physcore.checks import number
from physcore.errors import FileError, SceneError
from physcore.film.foot import Label
from physcore.film.inset import Inset
from physcore.film.moving import Camera, Follow
from physcore.film.panels import Stage
from physcore.film.sources import sources
from physcore.film.styles import Style
from physcore.film.themes import Color, Theme, ThemeName, color, legible, resolve
from physcore.numerics import FRAMES_PER_SECOND, Options
from physcore.progress import Progress
from physcore.recording import Recording
from physcore.scene import Scene
from physcore.storage import replacing

FASTEST = 50.0
"""Frames per second that every viewer of GIFs shows; most slow shorter delays down to 100 ms."""
SLOWEST = 100 / 65535
"""Frames per second below which a delay does not fit into a GIF."""


def film(
    recording: Recording | Scene | Sequence[Recording | Scene],
    path: str | os.PathLike[str],
    *,
    size: tuple[int, int] | None = None,
    style: Style | Sequence[Style] | None = None,
    camera: Camera | Follow | None = None,
    theme: Theme | ThemeName = "dark",
    background: Color | str | None = None,
    title: str | None = None,
    titles: Sequence[str] | None = None,
    labels: Sequence[Label] = ("time",),
    color_bar: bool = True,
    inset: Inset | None = None,
    speed: float = 1.0,
    duration: float | None = None,
    fps: float | None = None,
    progress: bool | None = None,
    **numerics: Unpack[Options],
) -> None:
    """Draw a recording, or a scene while it is simulated, as a GIF; as a PNG, the last frame.

    Of a scene only one frame is in memory at a time. In a first pass the framing and the ranges of the colors are
    found, and the second one draws. Between them frames wait in a temporary file without a name, of at most a quarter
    of the free disk, unless simulating again, which gives the same bits, takes less time than writing and reading. One
    pass is enough where nothing depends on the whole film: with a Window, or Orbits with target and extent, styles
    whose ends of the color scale are given (`top`, `range`), no inset and no label "dt". The file appears under its
    name when it is whole; until then, and on any failure, what was there stays.

    Args:
        recording: what to film; several are shown side by side, with one camera and one scale of colors.
        path: where to write, ending in .gif or .png.
        size: width and height of the picture [pixels]; None: 640 × 480, or a format of about that area in which the
            motion is shown clearly larger, and for several panels up to 1280 pixels wide.
        style: one or several of `physcore.styles`; None: springs by strain, fluids by speed, other bodies as points. A
            body that no style draws is drawn as points.
        camera: a Window in 2D, an Orbit in 3D; Keyframes between some of these, a function that gives one for a time
            [s] (`lambda time: Orbit(azimuth=10 * time)`), or Follow a body; all are in `physcore.film`. None: so that
            nothing leaves the picture.
        theme: "dark", "light" or a `physcore.film.Theme`.
        background: a color instead of the theme's, such as "#000000".
        title: a line above the picture.
        titles: a line above each panel.
        labels: what stands below the picture, some of "time", "dt", "integrator" and "energy" (the energy error so
            far); those of several panels each below its own.
        color_bar: whether to show at the lower right what colors mean, as far as there is room.
        inset: "energy": a diagram of kinetic, potential, internal and total energy in the emptiest corner of a panel.
        speed: seconds of the simulation that pass in one second of the film.
        duration: how long to simulate a scene [s].
        fps: frames per second of simulated time at which to film a scene; None: 30.
        progress: whether to show a progress bar; None: on a terminal, when it takes longer than a second.
        numerics: for a scene: integrator, dt, precision, threads, … as in Simulation.

    Raises:
        SceneError: an argument is not valid.
        FileError: the file cannot be written.
        SimulationDiverged: the scene blew up while it was filmed.
    """
    target = check_target(path)
    found = sources(recording, duration, fps, numerics)
    rate = _rate(found[0].fps, speed) if target.suffix.lower() == ".gif" else None
    colors, heads = _colors(theme, background), _titles(title, titles)
    stage = Stage(found, size, style, camera, colors, heads, progress, labels=labels, color_bar=color_bar, inset=inset)
    try:
        with stage:
            if rate is None:
                _write_still(stage, target)
            else:
                _write(stage, target, rate, progress)
    except FileError:
        raise
    except OSError as error:
        raise FileError(f"{target}: cannot be written: {error.strerror or error}") from error


def check_target(path: str | os.PathLike[str]) -> Path:
    """Where a film can be written; checked before it is drawn, which may take long.

    Raises:
        SceneError: the name does not end in .gif or .png.
        FileError: the folder does not exist.
    """
    target = Path(path)
    if target.suffix.lower() not in (".gif", ".png"):
        raise SceneError(f"path: must end in .gif or .png, got {os.fspath(path)!r}")
    if not target.parent.is_dir():
        raise FileError(f"{target}: cannot be written: no such folder")
    return target


def gif_bytes(
    recording: Recording | Sequence[Recording],
    *,
    size: tuple[int, int] | None = None,
    style: Style | Sequence[Style] | None = None,
    theme: Theme | ThemeName = "dark",
    speed: float = 1.0,
) -> bytes:
    """The bytes of the GIF that `film` would write, for a notebook or a server; the arguments are those of `film`."""
    found = sources(recording, None, None, {})
    rate = _rate(found[0].fps, speed)
    with Stage(found, size, style, None, resolve(theme), None, False) as stage:
        return _write(stage, None, rate, False) or b""


def delays(count: int, rate: float) -> list[int]:
    """How long each of `count` frames is shown [hundredths of a second], so that no frame is late by more than 5 ms."""
    ends = [math.floor(100 * (index + 1) / rate + 0.5) for index in range(count)]
    return [end - start for start, end in zip([0, *ends], ends, strict=False)]


def _write(stage: Stage, target: Path | None, rate: float, progress: bool | None) -> bytes | None:
    """Write all frames, and give their bytes if there is no file to put them into."""
    with closing(Gif(target, stage.reserved)) as gif, Progress(stage.count, "drawing", progress) as bar:
        for canvas in stage.samples():
            gif.observe(canvas)
        for index, (canvas, delay) in enumerate(zip(stage.frames(), delays(stage.count, rate), strict=True)):
            gif.frame(canvas, delay)
            bar.update(index + 1)
        return gif.finish()


def _write_still(stage: Stage, target: Path) -> None:
    """Write the last frame."""
    from PIL import Image

    last = deque(stage.frames(), maxlen=1)[0]
    with replacing(target) as file:
        Image.fromarray(last.pixels()).save(file, format="PNG")


def _rate(fps: float, speed: float) -> float:
    """Frames per second of the film."""
    rate = fps * number(speed, "speed", above=0.0)
    if rate > FASTEST * (1.0 + 1e-9):
        raise SceneError(
            f"fps: a GIF shows at most {FASTEST:g} frames per second, got {rate:g}; record fewer, "
            f"or play it slower: speed={FASTEST:g}/{fps:g}"
        )
    if rate < SLOWEST:
        raise SceneError(
            f"fps: a GIF shows a frame for at most 655 s, got {1 / rate:g} s; "
            f"play it faster: speed={FRAMES_PER_SECOND / fps:.3g}"
        )
    return rate


def _titles(title: str | None, titles: Sequence[str] | None) -> Sequence[str] | None:
    """One title for all, or one for each panel."""
    if title is not None and titles is not None:
        raise SceneError("titles: give one title for all or titles for the panels, not both")
    if title is not None and not isinstance(title, str):
        raise SceneError(f"title: must be a string, got {title!r}")
    return [title] if title else titles


def _colors(theme: Theme | ThemeName, background: Color | str | None) -> Theme:
    chosen = resolve(theme)
    return chosen if background is None else legible(replace(chosen, background=color(background, "background")))
