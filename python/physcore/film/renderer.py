"""Renderer of a film: panels side by side with all their contents."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from types import TracebackType
from typing import Self

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.errors import SceneError
from physcore.film import assignment
from physcore.film.camera.corotating import Corotating, corotating
from physcore.film.camera.framing import CameraTrack, Extent, PanelView, camera_track, extents
from physcore.film.camera.track import Camera, Follow
from physcore.film.colors.light import LAMP, OCCLUSION, REACH, SHADOW
from physcore.film.colors.samples import palette_samples
from physcore.film.colors.themes import Color, Theme
from physcore.film.first_pass import FirstPass, first_pass
from physcore.film.frame_cache import FrameCache
from physcore.film.labels.clock import Clock
from physcore.film.labels.dates import Start
from physcore.film.labels.diagram import Diagram, History, Inset, check_inset
from physcore.film.labels.drawing import write
from physcore.film.labels.footer import Bar, Footer, Label, bars, check_labels
from physcore.film.labels.scale_bar import LengthUnit, ScaleBar, check_scale_bar
from physcore.film.labels.tags import Listed, Named, NameTags, check_named
from physcore.film.labels.text import text_height
from physcore.film.layout import Heading, Layout, best, check_size
from physcore.film.scenery import draw_among, draw_backdrop, draw_behind
from physcore.film.styles import Painter, Style
from physcore.progress import Progress
from physcore.scene.bodies import Body
from physcore.simulation.sources import Source, SourceFrame

SHADES = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)
"""Brightness factors of colors in 3D, from full light to shade."""


@dataclass(eq=False)
class Panel:
    """One source with its rectangle and its painters."""

    source: Source
    painters: list[Painter]
    rectangle: tuple[int, int, int, int]
    """Left, top, right and bottom of the panel [pixels]."""
    free: tuple[int, int, int, int]
    """The part of the panel without text. In 2D, moving objects are clipped to it."""
    pixels: float
    """The area of the rectangle [pixels]."""
    view: PanelView
    samples: list[tuple[int, SourceFrame]]
    tags: NameTags
    bar: ScaleBar | None
    diagram: Diagram | None = None


class Renderer:
    """The canvas of a film with its panels, drawn frame by frame.

    The constructor runs a first pass, which finds all that depends on the whole film. Only one pass is needed if the
    camera gives target and extent, and each painter knows its color scale. Close the renderer at the end, because it
    may hold a temporary file.

    Args:
        found: the sources, one for each panel.
        size: width and height [pixels]; None: a size that suits the motion.
        style, camera: as in `film`.
        theme: the colors.
        heading: the titles above the picture; None: no titles.
        progress, labels, color_bar, legend, name_tags, scale_bar, inset, credit, time_unit, start: as in `film`.
        rate: frames per second of the film; None: as many as of the simulation.
        samples: samples per pixel along each side in 3D; a pixel is their mean.

    Raises:
        SceneError: an argument is not valid.
    """

    def __init__(
        self,
        found: Sequence[Source],
        size: tuple[int, int] | None,
        style: Style | Sequence[Style] | None,
        camera: Camera | Follow | Corotating | None,
        theme: Theme,
        heading: Heading | None,
        progress: bool | None,
        *,
        labels: Sequence[Label] = ("time",),
        color_bar: bool = True,
        legend: Listed = False,
        name_tags: Named = False,
        scale_bar: bool | LengthUnit = False,
        inset: Inset | None = None,
        credit: str = "",
        time_unit: str | None = None,
        start: Start | None = None,
        rate: float | None = None,
        samples: int = 1,
    ) -> None:
        self._theme, self._samples, asked = theme, samples, check_size(size)
        self._units = found[0].scene.units
        self._heading, self._labels = heading or Heading(), check_labels(labels, found)
        diagram, self._bar = check_inset(inset, found), check_scale_bar(scale_bar, self._units)
        self._listed = check_named(legend, "legend", found, systems=True)
        self._tagged = check_named(name_tags, "name_tags", found)
        self._all_listed = isinstance(legend, (bool, np.bool_))
        styles = assignment.asked(style, found)
        camera, found = corotating(camera, [assignment.shown(source, styles) for source in found])
        self._found = found
        self._painters = [assignment.painters(source, styles, theme) for source in found]
        self.count = max(source.count for source in found)
        self._clock = _clock(found, self.count)
        track = camera_track(camera, found, self._clock)
        self._once = track.closed and diagram is None and "dt" not in self._labels and self._settled
        self._caches: list[FrameCache | None] = [None] * len(found)
        self._opened: list[Iterator[SourceFrame]] = []
        try:
            passes = self._look_at_all(track, progress)
            assignment.share_scales(self._painters)
            fps = found[0].fps
            written = Clock(self._clock, fps, fps if rate is None else rate, time_unit, self._units, start)
            self._footer = self._make_footer(passes, color_bar, written, credit)
            self._passes, self._extents = passes, extents(track, passes, found)
            self._diagrammed, self._moving = diagram is not None, track.moving
            flat = found[0].scene.dimension < 3
            self._over = not flat and any(extent.given for extent in self._extents)
            self.resize(asked)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Delete the temporary files of the frames."""
        for cache in self._caches:
            if cache is not None:
                cache.close()

    def resize(self, size: tuple[int, int] | None) -> None:
        """Draw in another size [pixels] from now on; None: a size that suits the motion."""
        self._panels = self._lay_out(size, self._extents, self._passes)
        if self._diagrammed:
            self._add_diagrams(self._passes)
        self._canvas = self._prepared()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture [pixels]."""
        return self._layout.size

    @property
    def repeatable(self) -> bool:
        """Whether all frames can be drawn again without a second simulation."""
        return not self._once or not any(source.simulated for source in self._found)

    @property
    def reserved(self) -> list[Color]:
        """Colors that the palette must contain exactly."""
        return [self._theme.background]

    @property
    def colors(self) -> list[Color]:
        """Colors that may occur in the film but not in the samples: of bodies and scales, in 3D in light and shade."""
        every = np.concatenate([painter.palette for painter in chain.from_iterable(self._painters)])
        shades = SHADES if any(source.scene.dimension == 3 for source in self._found) else (1.0,)
        shaded = np.unique(np.concatenate([np.rint(shade * every) for shade in shades]).astype(int), axis=0)
        return [(red, green, blue) for red, green, blue in shaded.clip(0, 255).tolist()]

    def samples(self) -> Iterator[Canvas]:
        """Sampled frames of the film, to choose its palette from; each canvas is valid until the next is requested."""
        for index in range(max(len(panel.samples) for panel in self._panels)):
            self._begin()  # trails must not connect samples, which are far apart in time
            chosen = [panel.samples[min(index, len(panel.samples) - 1)] for panel in self._panels]
            yield self._draw([index for index, _ in chosen], [frame for _, frame in chosen])
        for source, painters in zip(self._found, self._painters, strict=True):
            if self._once or any(painter.traced is not None for painter in painters):
                bodies, flat = len(source.scene.bodies), source.scene.dimension < 3
                yield palette_samples(painters, bodies, self._theme, flat=flat, once=self._once)

    def frames(self) -> Iterator[Canvas]:
        """All frames; each canvas is valid until the next is requested. A panel that ends early repeats its last frame
        in the rest of the film.
        """
        self._begin()
        self._footer.begin()
        running, self._opened = self._opened or [self._again(index) for index in range(len(self._found))], []
        frames = [next(each) for each in running]
        for index in range(self.count):
            yield self._draw([index] * len(frames), frames)
            frames = [next(each, frame) for each, frame in zip(running, frames, strict=True)]

    def _begin(self) -> None:
        """Reset all state that depends on earlier frames."""
        for painter in chain.from_iterable(self._painters):
            painter.begin()
        for panel in self._panels:
            panel.tags.begin()

    @property
    def _settled(self) -> bool:
        """Whether each painter knows its color scale already."""
        return all(painter.settled for painter in chain.from_iterable(self._painters))

    def _look_at_all(self, track: CameraTrack, progress: bool | None) -> list[FirstPass]:
        """Run the first pass over each source: over the whole film, or over its first frame if that is enough."""
        passes = []
        for index, (source, painters) in enumerate(zip(self._found, self._painters, strict=True)):
            with Progress(source.count, "first pass", False if self._once else progress) as bar:
                frames = self._first(index)
                passes.append(first_pass(source, frames, self.count, painters, track.axes, track.follow, bar.update))
        return passes

    def _first(self, index: int) -> Iterable[SourceFrame]:
        """The frames of a source that the first pass goes through."""
        source = self._found[index]
        if self._once:
            frames = source.frames()
            first = next(frames)
            self._opened.append(chain([first], frames))
            return [first]
        if not source.simulated:
            return source.frames()
        cache = self._caches[index] = FrameCache(source)
        return cache.first()

    def _again(self, index: int) -> Iterator[SourceFrame]:
        """All frames of a source for the second pass."""
        cache = self._caches[index]
        return self._found[index].frames() if cache is None else cache.again()

    def _make_footer(self, passes: Sequence[FirstPass], color_bar: bool, clock: Clock, credit: str) -> Footer:
        """The footer of the picture."""
        facts = [
            (source.integrator if "integrator" in self._labels else None, seen.dt)
            for source, seen in zip(self._found, passes, strict=True)
        ]
        painters = list(chain.from_iterable(self._painters))
        scales: list[Bar] = bars([each.scale for each in painters], self._units) if color_bar else []
        return Footer(self._labels, clock, facts, scales, credit, self._legend(painters), self._units)

    def _legend(self, painters: Sequence[Painter]) -> list[tuple[str, Color]]:
        """The names of the legend with the colors of their bodies or systems, without duplicates."""
        colors = {id(item): color for painter in painters for item, color in painter.legend}
        entries = {(item.name or "", colors.get(id(item))): item for panel in self._listed for item in panel}
        for (_, color), item in entries.items():
            if color is None and (isinstance(item, Body) or not self._all_listed):
                style = "colors by body, such as styles.Points('body')"
                if not isinstance(item, Body):
                    style = "has one color, such as styles.Trails(color='tomato')"
                raise SceneError(f"legend: {item!r} is not drawn in one color; give it a style that {style}")
        return [(name, color) for name, color in entries if color is not None]

    def _layout_of(self, size: tuple[int, int]) -> Layout:
        footer = self._footer.height(text_height(*size), size[0])
        return Layout(size, len(self._found), self._heading, footer)

    def _inset(self, layout: Layout, index: int) -> float:
        """Distance of the motion from a panel's edge [pixels]."""
        pixels = layout.pixels(index)
        return layout.margin(index) + max(painter.inset(pixels) for painter in self._painters[index])

    def _lay_out(self, size: tuple[int, int] | None, found: list[Extent], passes: Sequence[FirstPass]) -> list[Panel]:
        """Divide the picture into panels and fit the common camera."""

        def magnification(candidate: tuple[int, int]) -> float:
            layout = self._layout_of(candidate)
            return min(
                extent.magnification(layout.area(index), self._inset(layout, index))
                for index, extent in enumerate(found)
            )

        if size is None:
            size = best(len(found), magnification, fixed=any(extent.given for extent in found))
        self._layout = layout = self._layout_of(size)
        panels = []
        for index, (source, painters, extent, seen) in enumerate(
            zip(self._found, self._painters, found, passes, strict=True)
        ):
            view = PanelView(extent, layout.area(index), self._inset(layout, index))
            free, pixels = layout.area(index), layout.pixels(index)
            tags = NameTags(self._tagged[index], painters, free, layout.text, self._theme)
            bar = None if self._bar is False else ScaleBar(self._bar, free, layout.text, self._theme, self._units)
            panels.append(Panel(source, painters, layout.panel(index), free, pixels, view, seen.samples, tags, bar))
        return panels

    def _add_diagrams(self, passes: Sequence[FirstPass]) -> None:
        """Create the diagram of each panel."""
        history = History([seen.energies for seen in passes], float(self._clock[-1] - self._clock[0]), self._units)
        for number, panel in enumerate(self._panels):
            occupied = [np.empty((0, 2), dtype=np.float32)]
            for index, frame in panel.samples:
                view = panel.view.at(index)
                if len(frame.positions) > 0:
                    occupied.append(view.project(panel.view.shown(frame, view).positions)[0])
            area, text = self._layout.area(number), self._layout.text
            panel.diagram = Diagram(history, number, area, text, self._theme, np.concatenate(occupied))

    def _prepared(self) -> Canvas:
        """A canvas with all static content."""
        flat = all(panel.view.at(0).flat for panel in self._panels)
        canvas = Canvas(*self.size, self._theme.background, 1 if flat else self._samples)
        if not self._moving:
            self._draw_scenery(canvas, 0)
            canvas.keep()
        return canvas

    def _draw_scenery(self, canvas: Canvas, index: int) -> None:
        """Draw all that is behind every moving object."""
        for panel in self._panels:
            canvas.clip(*panel.rectangle)
            view = panel.view.at(index)
            if not view.flat:
                canvas.eye(view.scale, view.middle, view.distance)
                draw_backdrop(canvas, panel.source.scene, panel.rectangle, self._theme)
            draw_behind(canvas, panel.source.scene, view, self._theme, panel.view.scenery(view))
        canvas.clip(0, 0, *self.size)

    def _write_titles(self, canvas: Canvas) -> None:
        outline = self._theme.background if self._over else None
        for line, middle, top, height in self._layout.written():
            color = self._theme.label if line == self._heading.subtitle else self._theme.text
            write(canvas, line, middle, top, height, color, 0, outline)

    def _draw(self, indices: Sequence[int], frames: Sequence[SourceFrame]) -> Canvas:
        """Draw one frame of the film, from one frame of each panel with its index."""
        canvas, clock = self._canvas, max(indices)
        canvas.clear()
        if self._moving:
            self._draw_scenery(canvas, clock)
        for panel, index, frame in zip(self._panels, indices, frames, strict=True):
            view = panel.view.at(clock)
            shown = panel.view.shown(frame, view)
            for painter in panel.painters:
                shown = painter.raised(shown)
            canvas.clip(*(panel.free if view.flat else panel.rectangle))  # in 3D the ground extends below the text
            canvas.lens(view.blur, view.distance)
            if not view.flat:
                canvas.eye(view.scale, view.middle, view.distance)
                canvas.light(LAMP, SHADOW, OCCLUSION, REACH * math.sqrt(panel.pixels))
            draw_among(canvas, panel.source.scene, view, self._theme, panel.view.scenery(view))
            for painter in panel.painters:
                painter.paint(canvas, shown, view, panel.pixels)
            canvas.paint()
            taken = []
            if panel.diagram is not None:
                panel.diagram.draw(canvas, index)
                taken.append(panel.diagram.box)
            if panel.bar is not None:
                taken.append(panel.bar.draw(canvas, view, *taken))
            panel.tags.draw(canvas, shown, view, panel.pixels, taken)
        canvas.clip(0, 0, *self.size)
        self._write_titles(canvas)
        energies, text = [each.energy for each in frames], self._layout.text
        self._footer.draw(canvas, self.size, text, self._theme, clock, energies, over=self._over)
        return canvas


def _clock(found: Sequence[Source], count: int) -> FloatArray:
    """The time of each frame of the film [s]; a panel that ends early stays at its last time."""
    each = [source.times[np.minimum(np.arange(count), source.count - 1)] for source in found]
    clock: FloatArray = np.max(each, axis=0)
    return clock
