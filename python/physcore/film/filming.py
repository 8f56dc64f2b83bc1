"""The recipe of a film: find what to show, look at all of it once, then draw it frame by frame into a file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from physcore.checks import count as whole_number
from physcore.checks import flag, word
from physcore.errors import FileError, SceneWarning, warn
from physcore.numerics.choices import Options
from physcore.spelling import spelled

# Drawing is imported where it is used: it takes as long as the rest of physcore.
if TYPE_CHECKING:
    from physcore.film.camera.corotating import Corotating
    from physcore.film.camera.track import Camera, Follow
    from physcore.film.colors.themes import Color, Theme, ThemeName
    from physcore.film.labels.diagram import Inset
    from physcore.film.labels.footer import Label
    from physcore.film.labels.scale_bar import LengthUnit
    from physcore.film.labels.tags import Listed, Named
    from physcore.film.layout import Format
    from physcore.film.styles import Style
    from physcore.film.writers import Film, Loop, Quality
    from physcore.scene.scene import Scene
    from physcore.simulation.recording import Recording

HEAVY = 5_000_000
"""GIFs of more bytes are said to be large: pages load them slowly, and some take none."""
SAMPLES: dict[Quality, int] = {"fast": 1, "high": 2}
"""Pixels that are drawn along each side of one in 3D."""


@spelled
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
    credit: str | None = None,
    labels: Sequence[Label] = ("time",),
    color_bar: bool = True,
    legend: Listed = False,
    name_tags: Named = False,
    scale_bar: bool | LengthUnit = False,
    inset: Inset | None = None,
    time_unit: str | None = None,
    speed: float | None = None,
    hold: float = 0.0,
    loop: Loop | None = None,
    duration: float | None = None,
    fps: float | None = None,
    quality: Quality = "fast",
    max_bytes: int | None = None,
    sidecar: bool = False,
    progress: bool | None = None,
    **numerics: Unpack[Options],
) -> Film:
    """Draw a recording, or a scene while it is simulated, as a film; as a PNG, its last frame.

        pc.film(recording, "cloth.gif", title="A cloth")
        pc.film(scene, "scene.gif", duration=0.5, style=pc.styles.Strain())

    Of a scene only one frame is in memory at a time. In a first pass the framing and the ranges of the colors are
    found, and the second one draws. Between them frames wait in a temporary file without a name, of at most a quarter
    of the free disk, unless simulating again, which gives the same bits, takes less time than writing and reading. One
    pass is enough where nothing depends on the whole film: with a Window, or Orbits with target and extent, styles
    whose ends of the color scale are given (`top`, `range`), no inset and no label "dt". The file appears under its
    name when it is whole; until then, and on any failure, what was there stays. It carries its provenance,
    which `physcore.provenance` reads: a hash of the scene, the numerics, the steps taken, the drift of the
    energy and the hash of the last state.

    All formats keep real time and show every frame. A .gif, of 255 colors and at most 50 frames per second, is shown
    everywhere; a .webp has all colors in fewer bytes, an .apng every pixel as it was drawn, both at up to 90 frames per
    second and for browsers; an .mp4 (H.264), at up to 240, needs `pip install 'physcore[video]'`.

    Args:
        recording: what to film; several are shown side by side, with one camera and one scale of colors.
        path: where to write, ending in .gif, .webp, .apng, .mp4 or .png.
        size: width and height of the picture [pixels]; None: 640 × 480, or a format of about that area in which the
            motion is shown clearly larger, and for several panels up to 1280 pixels wide.
        format: instead of a size "square", "wide" (16 : 9) or "story" (9 : 16); 480 × 480, 640 × 360 and 360 × 640
            pixels, and as an .mp4 1080 on the shorter side.
        style: one or several of `physcore.styles`; None: cloths and soft bodies as surfaces, other springs as
            lines, both by strain; fluids by speed, other bodies as points. A body that no style draws is drawn as
            points.
        camera: a Window in 2D, an Orbit in 3D; Keyframes between some of these, a function that gives one for a time
            [s] (`lambda time: Orbit(azimuth=10 * time)`), Follow a body, or the frame that is Corotating with two; all
            are in `physcore`. None: so that nothing leaves the picture.
        theme: "dark", "light" or a `physcore.Theme`.
        background: a color instead of the theme's, such as "#000000".
        title: a line above the picture. Letters, Greek, sub- and superscripts, mathematical signs, Chinese, Japanese
            and Korean are drawn: "v₀ = √(2gh)", "抛体运动". Of other signs, such as emoji, a SceneWarning tells.
        titles: a line above each panel.
        subtitle: a smaller line under the title.
        credit: a small line at the lower right.
        labels: what stands below the picture, some of "time", "dt", "integrator" and "energy" (the energy error so
            far); those of several panels each below its own.
        color_bar: whether to show at the lower right what colors mean, as far as there is room.
        legend: whether to list the names of bodies, and of systems such as tracers that are drawn in one color, with
            their colors below the picture; or which, by themselves or by their names: `legend=("Sun", "Jupiter")`.
            Each has to be drawn in a color of its own.
        name_tags: whether to write names beside their bodies in the picture, as suits planets and other single
            particles; or which. None lies over another one.
        scale_bar: whether to draw a scale bar at the lower left of each panel, or in which unit: "nm", "cm", "m", "km",
            "AU", "ly", "kpc" or another. In 3D it holds at the point that the camera looks at.
        inset: "energy": a diagram of kinetic, potential, internal and total energy in the emptiest corner of a panel.
        time_unit: "ms", "s", "min", "h", "d", "yr" or another; None: as suits the duration. Where the film does not
            play in real time, the label "time" says so: "1 s = 90 d".
        speed: seconds of the simulation that pass in one second of the film; None: 1, or as near to it as the format
            shows all frames, with a warning where a GIF of more than 50 per second becomes slower.
        hold: how long the last frame stays before the film begins again, or before it turns [s]; a PNG shows nothing
            else.
        loop: how the end goes over into the start: "bounce" plays backward again, "crossfade" blends the last half
            second into the first; None: it jumps. A motion with a period needs neither: `recording.period`.
        duration: how long to simulate a scene [s].
        fps: frames per second of simulated time at which to film a scene; None: 30.
        quality: "fast", or "high": in 3D each pixel is the mean of four, so that outlines have no steps, which takes
            three times as long; and pixels of a GIF always have the nearest color, of a palette chosen with more care,
            where those of a "fast" one, if it would exceed 3 MB, may have one near that where it makes the film
            smaller: at most 18 levels of 255 off, and only where things move. See docs/films.md.
        max_bytes: how large a GIF may become; of other formats a SceneWarning tells. Where it would be larger, it is
            made again, and first colors may be farther off, up to 28 levels; then every second frame is left out, as
            long as twelve a second are left; then half of the colors, down to 63; then the picture becomes smaller,
            down to half as wide; at last more of all. What room is left is used.
        sidecar: whether to write the provenance into a file beside the film too, such as film.gif.json; there it has
            the number of threads as well, which the film itself does not depend on.
        progress: whether to show a progress bar; None: on a terminal or in a notebook, when it takes longer than a
            second.
        numerics: for a scene: integrator, dt, precision, threads, … as in Simulation.

    Returns:
        What was written: path, bytes, size, frames, rate and colors.

    Raises:
        SceneError: an argument is not valid, or a film of `max_bytes` could not be seen.
        FileError: the file cannot be written.
        PhyscoreError: what the format needs is not installed.
        SimulationDiverged: the scene blew up while it was filmed.
    """
    from physcore.film.labels.clock import check_unit
    from physcore.film.layout import check_format, check_heading, check_size, line_of
    from physcore.film.metadata import metadata, sidecar_of, write_sidecar
    from physcore.film.renderer import Renderer
    from physcore.film.writers import WRITERS, FilmJob, check_loop
    from physcore.simulation.sources import sources
    from physcore.storage.files import require_writable
    from physcore.storage.formats import writable

    writer, target = writable(path, WRITERS), Path(path)
    if flag(sidecar, "sidecar"):
        require_writable(sidecar_of(target))
    found = sources(recording, duration, fps, numerics)
    rate = writer.rate(found[0].fps, speed)
    shown = None if progress is None else flag(progress, "progress")
    with_bar, unit = flag(color_bar, "color_bar"), check_unit(time_unit)
    repeat = check_loop(loop, hold, writer.name, writer.longest, moving=writer.moving)
    _check_bytes(quality, max_bytes)
    sides = check_format(format, check_size(size), video=writer.video)
    colors, heading = _colors(theme, background), check_heading(title, titles, subtitle, len(found))
    note = "" if credit is None else line_of(credit, "credit")
    renderer = Renderer(
        found, sides, style, camera, colors, heading, shown,
        labels=labels, color_bar=with_bar, legend=legend, name_tags=name_tags, scale_bar=scale_bar,
        inset=inset, credit=note, time_unit=unit, rate=rate, samples=SAMPLES[quality],
    )  # fmt: skip
    try:
        with renderer:
            job = FilmJob(renderer, rate, quality, max_bytes, lambda: metadata(found), shown, repeat)
            written = writer.write(job, target)
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
    """The bytes of the GIF that `film` would write, for a notebook or a server; the arguments are those of `film`."""
    from physcore.film.colors.themes import resolve
    from physcore.film.metadata import metadata
    from physcore.film.renderer import Renderer
    from physcore.film.writers import FilmJob, GifWriter
    from physcore.simulation.sources import sources

    found = sources(recording, None, None, {})
    rate = GifWriter.rate(found[0].fps, speed)
    _check_bytes("fast", max_bytes)
    with Renderer(found, size, style, None, resolve(theme), None, False, rate=rate) as renderer:
        return GifWriter.content(FilmJob(renderer, rate, "fast", max_bytes, lambda: metadata(found), False))


def _check_bytes(quality: object, max_bytes: object) -> None:
    """What was asked for of the file's size makes sense.

    Raises:
        SceneError: it does not.
    """
    from physcore.film.writers import QUALITIES

    word(quality, "quality", QUALITIES)
    if max_bytes is not None:
        whole_number(max_bytes, "max_bytes", least=1)


def _colors(theme: Theme | ThemeName, background: Color | str | None) -> Theme:
    from physcore.film.colors.themes import color, legible, resolve

    chosen = resolve(theme)
    return (
        chosen
        if background is None
        else legible(replace(chosen, background=color(background, "background"), backdrop=None))
    )
