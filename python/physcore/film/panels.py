"""Panels side by side, and everything that is drawn in them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from physcore._core import Canvas
from physcore.checks import count as whole_number
from physcore.checks import shown
from physcore.errors import SceneError
from physcore.film.camera import Camera, Face, Orbit, View, Window, fit
from physcore.film.scenery import draw_among, draw_behind
from physcore.film.sources import Moment, Source
from physcore.film.styles import Fluid, Painter, Points, Strain, Style
from physcore.film.styles.base import Part
from physcore.film.survey import Bounds, Survey, survey
from physcore.film.themes import Color, Theme
from physcore.progress import Progress

MARGIN = 0.03
"""Free space around the motion, as a fraction of the picture's shorter side."""
LOW, HIGH = Orbit(), Orbit(elevation=52.0)
"""From where a 3D scene is seen by itself: from above if it is flat."""
LARGEST = 16384
"""The longest side of a picture [pixels]; a square one takes a gigabyte."""
FLAT = 0.25
"""A scene whose height is below this fraction of its width is flat."""


@dataclass(eq=False)
class Panel:
    """One source, its rectangle and what draws it."""

    source: Source
    painters: list[Painter]
    area: tuple[int, int, int, int]
    """Left, top, right and bottom [pixels]."""
    view: View
    ground: float
    """Half the width of the ground in 3D [m]."""
    samples: list[Moment]

    @property
    def pixels(self) -> float:
        """The size of the rectangle."""
        left, top, right, bottom = self.area
        return float((right - left) * (bottom - top))


class Stage:
    """The canvas with its panels; the whole film is surveyed when it is made.

    Args:
        found: the sources, one for each panel.
        size: width and height [pixels].
        style, camera: as in `film`.
        theme: the colors.
        titles: of the panels, or one over all.
        progress: as in `film`.

    Raises:
        SceneError: an argument is not valid.
    """

    def __init__(
        self,
        found: Sequence[Source],
        size: tuple[int, int],
        style: Style | Sequence[Style] | None,
        camera: Camera | None,
        theme: Theme,
        titles: Sequence[str] | None,
        progress: bool | None,
    ) -> None:
        self._size, self._theme = _size(size), theme
        self._titles = _titles(titles, len(found))
        self._text = int(np.clip(self._size[1] / 24, 16, 32))
        self.count = max(source.count for source in found)
        self._decimals = max(2, math.ceil(math.log10(found[0].fps) - 1e-9))  # so that the time moves with each frame
        styles = _styles(style, found)
        painters = [_painters(source, styles, theme) for source in found]
        cameras = _cameras(found, camera)
        surveys = []
        for source, mine in zip(found, painters, strict=True):
            with Progress(source.count, "surveying", progress) as bar:
                axes = [np.eye(source.scene.dimension), *(each.axes for each in cameras if isinstance(each, Orbit))]
                surveys.append(survey(source, mine, axes, bar.update))
        _share_scales(painters)
        self._panels = self._lay_out(found, painters, surveys, cameras)
        self._canvas = self._prepared()

    @property
    def reserved(self) -> list[Color]:
        """Colors that the film needs exactly."""
        return [self._theme.background]

    def samples(self) -> Iterator[Canvas]:
        """Some frames of the film, to choose its palette from; each canvas is valid until the next is asked for."""
        for index in range(max(len(panel.samples) for panel in self._panels)):
            yield self._draw([panel.samples[min(index, len(panel.samples) - 1)] for panel in self._panels])

    def frames(self) -> Iterator[Canvas]:
        """Every frame; each canvas is valid until the next is asked for. A panel that ends early keeps its last."""
        for panel in self._panels:
            for painter in panel.painters:
                painter.begin()
        running = [panel.source.moments() for panel in self._panels]
        moments = [next(each) for each in running]
        for _ in range(self.count):
            yield self._draw(moments)
            moments = [next(each, moment) for each, moment in zip(running, moments, strict=True)]

    def _lay_out(
        self, found: Sequence[Source], painters: list[list[Painter]], surveys: list[Survey], cameras: list[Camera]
    ) -> list[Panel]:
        """Divide the picture and fit the camera, which all panels share."""
        merged = [Bounds(bounds.axes) for bounds in surveys[0].bounds]
        for seen in surveys:
            for box, other in zip(merged, seen.bounds, strict=True):
                box.merge(other)
        chosen = _choice(merged[0], len(cameras))
        box = merged[min(1 + chosen, len(merged) - 1)]
        extent = merged[0].upper - merged[0].lower
        ground = 0.54 * float(max(extent[0], extent[1])) if len(extent) == 3 else float(np.linalg.norm(extent))
        width, height = self._size
        head = round(1.5 * self._text) if self._titles else 0
        panels = []
        for index, (source, each, seen) in enumerate(zip(found, painters, surveys, strict=True)):
            left, right = width * index // len(found), width * (index + 1) // len(found)
            pixels = float((right - left) * height)
            inset = MARGIN * min(right - left, height) + max(painter.inset(pixels) for painter in each)
            view = fit(cameras[chosen], box.lower, box.upper, (left, head, right, height - self._foot), inset)
            size = max(ground, float(width + height) / view.scale) if view.flat else ground
            panels.append(Panel(source, each, (left, 0, right, height), view, size, seen.samples))
        return panels

    @property
    def _foot(self) -> int:
        """Height of the line with the time [pixels]."""
        return round(1.3 * self._text)

    def _prepared(self) -> Canvas:
        """A canvas with all that does not move."""
        width, height = self._size
        theme = self._theme
        canvas = Canvas(width, height, theme.background)
        for panel in self._panels:
            canvas.clip(*panel.area)
            draw_behind(canvas, panel.source.scene, panel.view, theme, panel.ground)
        canvas.clip(0, 0, width, height)
        shared = len(self._titles) == 1
        for panel, title in zip(self._panels, self._titles, strict=False):
            left, _, right, _ = (0, 0, width, 0) if shared else panel.area
            canvas.text(title, (left + right) // 2, self._text // 3, self._text, (*theme.text, 255), 0)
        canvas.keep()
        return canvas

    def _draw(self, moments: Sequence[Moment]) -> Canvas:
        """One frame."""
        canvas, (width, height) = self._canvas, self._size
        canvas.clear()
        for panel, moment in zip(self._panels, moments, strict=True):
            canvas.clip(*panel.area)
            draw_among(canvas, panel.source.scene, panel.view, self._theme, panel.ground)
            for painter in panel.painters:
                painter.paint(canvas, moment, panel.view, panel.pixels)
            canvas.paint()
        canvas.clip(0, 0, width, height)
        time = max(moment.time for moment in moments)
        label = f"{time:.{self._decimals}f} s"
        canvas.text(label, self._text // 2, height - round(1.2 * self._text), self._text, (*self._theme.label, 255), -1)
        return canvas


def _size(size: object) -> tuple[int, int]:
    if not isinstance(size, (tuple, list)) or len(size) != 2:
        raise SceneError(f"size: must be (width, height) in pixels, got {size!r}")
    width, height = (whole_number(side, f"size[{axis}]", least=16, most=LARGEST) for axis, side in enumerate(size))
    return width, height


def _titles(titles: Sequence[str] | None, panels: int) -> list[str]:
    if titles is None:
        return []
    if isinstance(titles, str) or not all(isinstance(title, str) for title in titles):
        raise SceneError(f"titles: must be a list of strings, got {titles!r}")
    if len(titles) not in (1, panels):
        raise SceneError(f"titles: must be one for each of the {panels} panels, got {len(titles)}")
    return list(titles)


def _styles(style: object, found: Sequence[Source]) -> list[Style]:
    """The styles that were asked for; each body that they name is in a source."""
    if style is None:
        fluids = all(source.has("velocities") for source in found)
        return [Strain(), Fluid()] if fluids else [Strain()]
    styles = []
    bodies = [body for source in found for body in source.scene.bodies]
    for each in style if isinstance(style, (list, tuple)) else [style]:
        if not isinstance(each, Style):
            missing = f"; write {each.__name__}()" if isinstance(each, type) else ""
            raise SceneError(f"style: must be one or a list of physcore.styles, got {shown(each)}{missing}")
        for body in each.bodies() or ():
            if body not in bodies:
                raise SceneError(
                    f"{type(each).__name__}.on: {body!r} is not in what is filmed; "
                    "the bodies of a loaded recording are new ones: recording.scene.bodies"
                )
        styles.append(each)
    return styles


def _painters(source: Source, styles: list[Style], theme: Theme) -> list[Painter]:
    """What draws a source: the first style that draws a body gets it, and points what no style draws; overlays add."""
    parts = [Part(body, source.scene.slice(body)) for body in source.scene.bodies]
    left = list(parts)
    painters = []
    for each in (*styles, Points()):
        mine = [part for part in (parts if each.overlay else left) if each.draws(part.body)]
        if not each.overlay:
            left = [part for part in left if part not in mine]
        if mine:
            painters.append(each.painter(source, mine, theme))
    return painters


def _share_scales(painters: list[list[Painter]]) -> None:
    """Let painters of equal styles, in all panels, agree on what a color means."""
    for each in (painter for panel in painters for painter in panel):
        each.top = max(
            other.top
            for panel in painters
            for other in panel
            if type(other) is type(each) and other.style == each.style
        )


def _cameras(found: Sequence[Source], camera: Camera | None) -> list[Camera]:
    """The cameras to choose from."""
    dimensions = {source.scene.dimension for source in found}
    if len(dimensions) > 1:
        raise SceneError("recording: panels must all be in 2D or all in 3D")
    flat = dimensions == {2}
    if camera is None:
        return [Face()] if flat else [LOW, HIGH]
    if not isinstance(camera, Window if flat else Orbit):
        raise SceneError(f"camera: must be {'a Window in 2D' if flat else 'an Orbit in 3D'}, got {shown(camera)}")
    return [camera]


def _choice(whole: Bounds, cameras: int) -> int:
    """Which camera suits the shape of what happens."""
    if cameras == 1:
        return 0
    width, depth, height = whole.upper - whole.lower
    return int(height < FLAT * max(width, depth))
