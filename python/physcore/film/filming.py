"""The function `film`: collects the sources, finds the framing and colors in a first pass, and draws frame by frame."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from physcore.checks import count as whole_number
from physcore.checks import flag, word
from physcore.entrance import entrance
from physcore.errors import FileError, SceneWarning, warn
from physcore.numerics.choices import Options

# The drawing modules are imported on use: their import takes as long as that of the rest of physcore.
if TYPE_CHECKING:
    from datetime import date

    from physcore.film.camera.corotating import Corotating
    from physcore.film.camera.track import Camera, Follow
    from physcore.film.colors.themes import Color, Theme, ThemeName
    from physcore.film.labels.curves import Inset
    from physcore.film.labels.footer import Label
    from physcore.film.labels.scale_bar import LengthUnit
    from physcore.film.labels.tags import Listed, Named
    from physcore.film.layout import Arrangement, Format
    from physcore.film.quality import Quality
    from physcore.film.styles import Style
    from physcore.film.writers import Film, Loop
    from physcore.scene.scene import Scene
    from physcore.simulation.recording import Recording

HEAVY = 5_000_000
"""Size above which a GIF causes a warning [bytes]: pages load it slowly, and some refuse it."""


@entrance
def film(
    recording: Recording | Scene | Sequence[Recording | Scene],
    path: str | os.PathLike[str],
    *,
    size: tuple[int, int] | None = None,
    format: Format | None = None,
    style: Style | Sequence[Style] | None = None,
    camera: Camera | Follow | Corotating | None = None,
    theme: Theme | ThemeName = "dark",
    background: Color | str | None = None,
    title: str | None = None,
    titles: Sequence[str] | None = None,
    subtitle: str | None = None,
    formula: str | None = None,
    figure: str | None = None,
    credit: str | None = None,
    labels: Sequence[Label] = ("time",),
    color_bar: bool = True,
    legend: Listed = False,
    name_tags: Named = False,
    scale_bar: bool | LengthUnit = False,
    inset: Inset | Sequence[Inset] | None = None,
    time_unit: str | None = None,
    start: str | date | None = None,
    speed: float | None = None,
    hold: float = 0.0,
    loop: Loop | None = None,
    duration: float | None = None,
    fps: float | None = None,
    quality: Quality = "fast",
    max_bytes: int | None = None,
    sidecar: bool = False,
    progress: bool | None = None,
    arrangement: Arrangement = "panels",
    columns: int | None = None,
    parameters: Sequence[Mapping[str, object]] | None = None,
    **numerics: Unpack[Options],
) -> Film:
    """Draw a film of a recording, or of a scene while it is simulated. A PNG shows the last frame.

        pc.film(recording, "cloth.gif", title="A cloth")
        pc.film(scene, "scene.gif", duration=0.5, style=pc.styles.Strain())

    With a scene, only one frame is in memory at a time. The first pass finds the framing and the ranges of the colors,
    and the second pass draws. In between, frames are kept in an unnamed temporary file of at most a quarter of the free
    disk. If a second simulation is faster than writing and reading, it is run instead; it gives the same bits. A single
    pass is enough if nothing depends on the whole film. This requires a Window, or Orbits with target and extent. It
    also requires styles with given ends of the color scale (`top`, `range`), no inset and no label "dt".

    The file appears under its name when it is complete. Until then, and after any failure, an existing file stays
    unchanged. The film contains its provenance, which `physcore.provenance` reads. The provenance has a hash of the
    scene, the numerics, the steps taken, the drift of the energy, and the hash of the last state.

    All formats keep real time and show every frame. For the web, take an .mp4 (H.264) or a .webp: they have all colors
    in a fraction of a GIF's bytes. An .mp4 has up to 240 frames per second and needs `pip install 'physcore[video]'`; a
    .webp needs nothing. A .gif is for where a GIF is needed: every program shows it, with 255 colors in a frame and at
    most 50 frames per second. An .apng is lossless. Browsers show .webp and .apng at up to 90 frames per second.

    An .html is a page that plays in any browser, from disk and without a network. It has the shapes of the film, not
    its pixels: a viewer plays, stops and zooms, and turns what is in 3D. Titles, labels and color scales stand beside
    the picture, with a curve of the energy if it is known, and the provenance. A browser without WebGL 2 shows a part
    of the frames as a GIF.

    Args:
        recording: the recording or scene; several are shown with one camera and one color scale.
        path: the file to write, ending in .gif, .webp, .apng, .mp4, .html or .png.
        size: width and height of the picture [pixels]. None: 640 × 480, or an aspect ratio of about equal area if it
            shows the motion clearly larger. Several panels are up to 1280 pixels wide.
        format: a named size instead of `size`: "square" (480 × 480 pixels), "wide" (640 × 360, 16 : 9) or "story"
            (360 × 640, 9 : 16). An .mp4 has 1080 pixels on the shorter side.
        style: one or several of `physcore.styles`. None: cloths and soft bodies as surfaces and other springs as lines,
            both by strain; fluids by speed; other bodies as points. A body that no style draws is drawn as points.
        camera: a Window in 2D or an Orbit in 3D; Keyframes between these; a function of the time [s] that gives one
            (`lambda time: Orbit(azimuth=10 * time)`); Follow for a body; or Corotating for a pair. All are in
            `physcore`. None: a view that contains the whole motion.
        theme: "dark", "light" or a `physcore.Theme`.
        background: a color instead of the theme's, such as "#000000".
        title: a line above the picture. The fonts have Latin and Greek letters, sub- and superscripts, mathematical
            signs, Chinese, Japanese and Korean: "v₀ = √(2gh)", "抛体运动". Other signs, such as emoji, cause a
            SceneWarning.
        titles: a line above each panel, also below a common title.
        subtitle: a smaller line under the title. Title and subtitle are broken into several lines where they are long.
        formula: a line at the upper right, such as "m ẍ = −k x", or below the title where it is too long.
        figure: a small line at the lower left, such as a measured value.
        credit: a small line at the lower right.
        labels: the labels below the picture, some of "time", "dt", "integrator" and "energy" (the energy error so far).
            Each panel has its own labels.
        color_bar: whether to draw the color scales at the lower right, as far as there is room.
        legend: whether to list names with their colors below the picture. Listed are bodies, and systems that are drawn
            in one color, such as tracers. Or some of them, given as objects or by name: `legend=("Sun", "Jupiter")`.
            Each of these must be drawn in a color of its own.
        name_tags: whether to write names beside their bodies in the picture, which suits planets and other single
            particles; or some of the bodies. Names do not overlap.
        scale_bar: whether to draw a scale bar at the lower left of each panel; or its unit: "nm", "cm", "m", "km",
            "AU", "ly", "kpc" or another. In 3D it is valid at the target of the camera.
        inset: diagrams beside the picture, or below it in a tall panel, up to four: "energy" (kinetic, potential,
            internal and total energy), or curves, each a `physcore.Curve`, computed from the recording.
        time_unit: "ms", "s", "min", "h", "d", "yr" or another; None: the unit of the scene, or in the SI one that suits
            the duration. If the film does not play in real time, the label "time" gives the pace:
            "2.5 × slower" or "1 s = 90 d".
        start: the date at the time 0: a text such as "2026-01-01" or "2026-01-01 12:00", a datetime.date or a
            datetime.datetime. The label "time" then shows dates, with the time of day if frames are less than a day
            apart.
        speed: seconds of the simulation, or units of time of its scene, per second of the film. None: 1, or the nearest
            speed at which the format shows all frames. In real time, a warning tells if a GIF plays slower because it
            has more than 50 frames per second, or if each frame lasts for seconds.
        hold: how long the last frame stays before the film restarts, or before it reverses [s]. A PNG is not affected.
        loop: the transition from the end to the start. "bounce" plays the film backward, "crossfade" blends the last
            half second into the first, but not on a page; None: no transition. A periodic motion needs neither:
            `recording.period`.
        duration: the simulated duration of a scene [s].
        fps: frames per second of simulated time for a scene; None: 30.
        quality: "fast" or "high". With "high", each pixel in 3D is the mean of four (antialiasing), which takes three
            times as long.
        max_bytes: the largest size of a GIF [bytes]; for other formats a SceneWarning tells if it is exceeded. A larger
            GIF is drawn again, with these reductions in turn: slightly larger color errors; a smaller picture, down to
            half the width; every second frame, down to twelve per second; half of the colors, down to 63; finally
            stronger reductions of all. The remaining room is used. Where a page is larger (None: than 5 MB), its
            coordinates are rounded to 14 or 12 bits instead of 16.
        sidecar: whether to write the provenance also into a file beside the film, such as film.gif.json. There it
            contains the number of threads too, on which the film does not depend.
        progress: whether to show a progress bar; None: on a terminal or in a notebook, after one second.
        arrangement: "panels": several recordings beside each other; "sequence": one after the other.
        columns: the number of panels side by side; None: all of up to four, in one row; of more, about as many as rows.
        parameters: the parameters of each recording, mappings with the same names. Those with several values have bars
            above the pictures, on which all values are marked. `Sweep.film` gives them.
        numerics: options for a scene: integrator, dt, precision, threads, … as in Simulation.

    Returns:
        Film: path, bytes, size, frames, rate and colors of the written file.

    Raises:
        SceneError: an argument is not valid, or a film of `max_bytes` would not be recognizable.
        FileError: the file cannot be written.
        PhyscoreError: a package that the format needs is not installed.
        SimulationDiverged: the simulation of the scene diverged.
    """
    from physcore.film.colors.themes import chosen_theme
    from physcore.film.film_renderer import FilmRenderer
    from physcore.film.labels.clock import check_unit
    from physcore.film.labels.dates import check_start
    from physcore.film.labels.heading import check_heading, line_or_none
    from physcore.film.layout import ARRANGEMENTS, check_format, check_size
    from physcore.film.metadata import metadata, sidecar_of, write_sidecar
    from physcore.film.quality import SAMPLES
    from physcore.film.writers import WRITERS, FilmJob, check_loop
    from physcore.film.writers.beside import write_film
    from physcore.simulation.sources import sources
    from physcore.storage.files import require_writable
    from physcore.storage.formats import writable

    writer, target = writable(path, WRITERS), Path(path)
    if flag(sidecar, "sidecar"):
        require_writable(sidecar_of(target))
    found = sources(recording, duration, fps, numerics)
    units = found[0].scene.units
    rate = writer.rate(found[0].fps, speed, units)
    shown = None if progress is None else flag(progress, "progress")
    with_bar, unit = flag(color_bar, "color_bar"), check_unit(time_unit, units)
    repeat = check_loop(loop, hold, writer.name, writer.longest, moving=writer.moving, blends=writer.blends)
    _check_bytes(quality, max_bytes)
    sides = check_format(format, check_size(size), video=writer.video)
    colors = chosen_theme(theme, background)
    heading = check_heading(title, titles, subtitle, len(found), parameters, formula)
    in_turn = word(arrangement, "arrangement", ARRANGEMENTS) == "sequence"
    notes = {"figure": line_or_none(figure, "figure"), "credit": line_or_none(credit, "credit")}
    begin = check_start(start, units)
    try:
        with units.worded(), FilmRenderer(
            found, sides, style, camera, colors, heading, shown,
            labels=labels, color_bar=with_bar, legend=legend, name_tags=name_tags, scale_bar=scale_bar,
            inset=inset, **notes, time_unit=unit, start=begin, rate=rate, samples=SAMPLES[quality],
            columns=columns, in_turn=in_turn, captioned=writer.captioned,
        ) as renderer:  # fmt: skip
            job = FilmJob(renderer, rate, max_bytes, lambda: metadata(found), shown, repeat)
            written = write_film(writer, job, target)
    except FileError:
        raise
    except OSError as error:
        raise FileError(f"{target}: cannot be written: {error.strerror or error}") from error
    if sidecar:
        write_sidecar(found, target)
    if writer.budgeted and max_bytes is None and written.bytes > HEAVY:
        warn(
            f"{written}: pages load a GIF above 5 MB slowly; give it max_bytes=5_000_000, a smaller size or fewer "
            "frames per second, or write a .webp or .mp4",
            SceneWarning,
        )
    if max_bytes is not None and written.bytes > max_bytes:
        warn(
            f"{written}: is larger than max_bytes; only GIFs are made to fit, others by a smaller size or fewer frames",
            SceneWarning,
        )
    return written


def gif_bytes(
    recording: Recording | Sequence[Recording],
    *,
    size: tuple[int, int] | None = None,
    style: Style | Sequence[Style] | None = None,
    theme: Theme | ThemeName = "dark",
    speed: float | None = None,
    max_bytes: int | None = None,
) -> bytes:
    """The bytes of the GIF that `film` would write, for a notebook or a server; arguments as in `film`."""
    from physcore.film.colors.themes import resolve
    from physcore.film.film_renderer import FilmRenderer
    from physcore.film.metadata import metadata
    from physcore.film.writers import FilmJob, GifWriter
    from physcore.simulation.sources import sources

    found = sources(recording, None, None, {})
    rate = GifWriter.rate(found[0].fps, speed, found[0].scene.units)
    _check_bytes("fast", max_bytes)
    with FilmRenderer(found, size, style, None, resolve(theme), None, False, rate=rate) as renderer:
        return GifWriter.content(FilmJob(renderer, rate, max_bytes, lambda: metadata(found), False))


def _check_bytes(quality: object, max_bytes: object) -> None:
    """Check the quality and the largest size of a file.

    Raises:
        SceneError: one of them is not valid.
    """
    from physcore.film.quality import QUALITIES

    word(quality, "quality", QUALITIES)
    if max_bytes is not None:
        whole_number(max_bytes, "max_bytes", least=1)
