"""Renderer of a film: looks at all frames once, then draws them one by one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from types import TracebackType
from typing import Any, Self

import numpy as np

from physcore._core import Canvas
from physcore.checks import FloatArray
from physcore.film import assignment
from physcore.film.camera.corotating import Corotating
from physcore.film.camera.framing import CameraTrack, camera_track, extents
from physcore.film.camera.track import Camera, Follow
from physcore.film.camera.view import FOG
from physcore.film.colors.samples import palette_samples
from physcore.film.colors.themes import Color, Theme
from physcore.film.composition import Composition
from physcore.film.first_pass import FirstPass, first_pass
from physcore.film.frame_cache import FrameCache
from physcore.film.labels.clock import Clock
from physcore.film.labels.dates import Start
from physcore.film.labels.footer import Bar
from physcore.film.labels.heading import Heading
from physcore.film.layout import check_size
from physcore.film.page.tape import Tape
from physcore.film.styles import Style
from physcore.progress import Progress
from physcore.simulation.energy import Energy
from physcore.simulation.sources import Source, SourceFrame

SHADES = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)
"""Brightness factors of colors in 3D, from full light to shade."""


class FilmRenderer(Composition):
    """The canvas of a film with its panels, drawn frame by frame.

    The constructor runs a first pass, which finds all that depends on the whole film. Only one pass is needed if the
    camera gives target and extent, and each painter knows its color scale. Close the renderer at the end, because it
    may hold a temporary file.

    Args:
        found: the sources, one for each panel.
        size: width and height [pixels]; None: a size that suits the motion.
        style, camera, theme, heading: as in Composition.
        progress, time_unit, start: as in `film`.
        rate: frames per second of the film; None: as many as of the simulation.
        contents: further options of Composition.

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
        time_unit: str | None = None,
        start: Start | None = None,
        rate: float | None = None,
        **contents: Any,
    ) -> None:
        asked = check_size(size)
        super().__init__(found, style, camera, theme, heading, **contents)
        counts = [source.count for source in found]
        self.count = sum(counts) if self._in_turn else max(counts)
        self._clock = _clock(self._found, max(counts))
        track = camera_track(self._camera, self._found, self._clock)
        # A page is drawn twice: its shapes, and a GIF for browsers that cannot draw them.
        self._once = track.closed and not self._insets and "dt" not in self._labels and self._settled
        self._once &= self._captioned
        self._caches: list[FrameCache | None] = [None] * len(found)
        self._opened: list[Iterator[SourceFrame]] = []
        try:
            self._passes = self._look_at_all(track, progress)
            assignment.share_scales(self._painters)
            fps = found[0].fps
            written = Clock(self._clock, fps, fps if rate is None else rate, time_unit, self._units, start)
            self._footers = [
                self._make_footer(written, [self._passes[number].dt for number in group], group)
                for group in self._groups
            ]
            self._footer = self._footers[0]
            self._extents, self._moving = extents(track, self._passes, self._found), track.moving
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
        self._compose(size, self._extents, self._passes, still=not self._moving)
        if self._insets:
            self._add_diagrams(self._passes, float(self._clock[-1] - self._clock[0]))

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
        for group, footer in zip(self._groups, self._footers, strict=True):
            self._footer = footer
            panels = [self._panels[number] for number in group]
            for index in range(max(len(panel.samples) for panel in panels)):
                self._begin()  # trails must not connect samples, which are far apart in time
                chosen = [panel.samples[min(index, len(panel.samples) - 1)] for panel in panels]
                yield self._draw_panels(group, [index for index, _ in chosen], [frame for _, frame in chosen])
        for source, painters in zip(self._found, self._painters, strict=True):
            if self._once or any(painter.traced is not None for painter in painters):
                bodies, flat = len(source.scene.bodies), source.scene.dimension < 3
                yield palette_samples(painters, bodies, self._theme, flat=flat, once=self._once)

    @property
    def parts(self) -> tuple[Sequence[Bar], Sequence[tuple[str, Color]], tuple[str, str]]:
        """The color bars, the names of the legend with their colors, and figure and credit."""
        return self._footer.parts

    @property
    def space(self) -> dict[str, Any]:
        """The panels with what their drawing depends on, for a page, as lists and numbers."""
        panels = []
        for panel in self._panels:
            view = panel.view.at(0)
            up = [0.0, 1.0, 0.0] if view.flat else view.axes[:, 2].tolist()
            place = {"rectangle": [*panel.rectangle], "free": [*panel.free]}
            panels.append({**place, "flat": view.flat, "up": up, "reach": view.reach})
        return {"panels": panels, "background": [*self._theme.background], "ink": [*self._theme.text], "fog": FOG}

    def frames(self) -> Iterator[Canvas]:
        """All frames; each canvas is valid until the next is requested. A panel that ends before others repeats its
        last frame.
        """
        for numbers, index, frames in self._moments():
            yield self._draw_panels(numbers, [index] * len(frames), frames)

    def record(self, tape: Tape) -> Iterator[tuple[str, list[Energy | None]]]:
        """Put all frames on the tape of a page. For each, its labels in a line, and the energies of its panels."""
        for numbers, index, frames in self._moments():
            views = [self._panels[number].view.at(index) for number in numbers]
            self._record(tape, frames, views, [index] * len(frames), numbers)
            energies = [frame.energy for frame in frames]
            yield self._footer.line(self._clock[index], energies), energies

    def _moments(self) -> Iterator[tuple[list[int], int, list[SourceFrame]]]:
        """All frames: the numbers of the panels shown, the index of the frame, and the frames of these panels."""
        opened, self._opened = self._opened or [self._again(index) for index in range(len(self._found))], []
        for group, footer in zip(self._groups, self._footers, strict=True):
            self._footer = footer
            self._begin()
            footer.begin()
            running = [opened[number] for number in group]
            frames = [next(each) for each in running]
            for index in range(max(self._found[number].count for number in group)):
                yield group, index, frames
                frames = [next(each, frame) for each, frame in zip(running, frames, strict=True)]

    def _footer_height(self, text: int, width: int) -> int:
        return max(footer.height(text, width) for footer in self._footers)

    @property
    def _groups(self) -> list[list[int]]:
        """The numbers of the panels that are shown together: all, or one after the other."""
        numbers = list(range(len(self._found)))
        return [[number] for number in numbers] if self._in_turn else [numbers]

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
                count = len(self._clock)
                passes.append(first_pass(source, frames, count, painters, track.axes, track.follow, bar.update))
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

    def _draw_panels(self, numbers: Sequence[int], indices: Sequence[int], frames: Sequence[SourceFrame]) -> Canvas:
        """Draw one frame of the film, from one frame of each of some panels with its index."""
        index = max(indices)
        views = [self._panels[number].view.at(index) for number in numbers]
        return self._draw(frames, views, indices, self._clock[index], numbers)


def _clock(found: Sequence[Source], count: int) -> FloatArray:
    """The time of each frame of the film [s]; a panel that ends early stays at its last time."""
    each = [source.times[np.minimum(np.arange(count), source.count - 1)] for source in found]
    clock: FloatArray = np.max(each, axis=0)
    return clock
