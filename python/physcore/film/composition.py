"""The composition of a picture: panels with their painters, the layout, and the text around them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import cast

import numpy as np

from physcore._core import Canvas
from physcore.checks import shown
from physcore.errors import SceneError
from physcore.film import assignment
from physcore.film.camera.corotating import Corotating, corotating
from physcore.film.camera.framing import Extent, PanelView
from physcore.film.camera.track import Camera, Follow
from physcore.film.camera.view import Area, View
from physcore.film.colors.light import LAMP, OCCLUSION, REACH, SHADOW
from physcore.film.colors.themes import Color, Theme
from physcore.film.first_pass import FirstPass
from physcore.film.labels.clock import Clock
from physcore.film.labels.curves import Inset, check_inset, energy_graph
from physcore.film.labels.diagram import Diagram, beside
from physcore.film.labels.drawing import write
from physcore.film.labels.footer import Bar, Footer, Label, bars, check_labels
from physcore.film.labels.heading import Heading
from physcore.film.labels.scale_bar import LengthUnit, ScaleBar, check_scale_bar
from physcore.film.labels.tags import Listed, Named, NameTags, check_named
from physcore.film.layout import Layout, best, columns_for
from physcore.film.page.tape import Tape
from physcore.film.scenery import draw_among, draw_backdrop, draw_behind, record
from physcore.film.styles import Painter, Style
from physcore.simulation.sources import Source, SourceFrame


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
    diagrams: list[Diagram] = field(default_factory=list)

    def draw_labels(self, canvas: Canvas, frame: SourceFrame, view: View, moment: int) -> None:
        """Draw the diagrams up to a moment, the scale bar and the names beside them."""
        for diagram in self.diagrams:
            diagram.draw(canvas, moment)
        taken = [diagram.box for diagram in self.diagrams]
        if self.bar is not None:
            taken.append(self.bar.draw(canvas, view, taken))
        self.tags.draw(canvas, frame, view, self.pixels, taken)


class Composition:
    """The panels of a picture with all their contents. A subclass gives the extent of the view, and the frames.

    Args:
        found: the sources, one for each panel.
        style, camera, labels, color_bar, legend, name_tags, scale_bar, inset, figure, credit: as in `film`.
        theme: the colors.
        heading: the titles above the picture; None: no titles.
        samples: samples per pixel along each side in 3D; a pixel is their mean.
        columns: the number of panels side by side; None: a suitable one.
        in_turn: whether the panels are shown one after the other.
        captioned: whether the common titles and the footer are part of the picture.

    Raises:
        SceneError: an argument is not valid.
    """

    _footer: Footer

    def __init__(
        self,
        found: Sequence[Source],
        style: Style | Sequence[Style] | None,
        camera: Camera | Follow | Corotating | None,
        theme: Theme,
        heading: Heading | None,
        *,
        labels: Sequence[Label] = ("time",),
        color_bar: bool = True,
        legend: Listed = False,
        name_tags: Named = False,
        scale_bar: bool | LengthUnit = False,
        inset: Inset | Sequence[Inset] | None = None,
        figure: str = "",
        credit: str = "",
        samples: int = 1,
        columns: int | None = None,
        in_turn: bool = False,
        captioned: bool = True,
    ) -> None:
        self._columns, self._in_turn = columns_for(columns, len(found)), in_turn
        self._theme, self._samples, self._units = theme, samples, found[0].scene.units
        self.heading, self._captioned, self._labels = heading or Heading(), captioned, check_labels(labels, found)
        self._heading = self.heading if captioned else self.heading.of_panels
        if not in_turn and self._columns < len(found) and set(self._labels) - {"time"}:
            raise SceneError(f"labels: of several rows of panels, must be ('time',) or (), got {shown(self._labels)}")
        self._insets = check_inset(inset, found)
        self._bar = check_scale_bar(scale_bar, self._units)
        self._listed = check_named(legend, "legend", found, systems=True)
        self._tagged = check_named(name_tags, "name_tags", found)
        self._all_listed = isinstance(legend, (bool, np.bool_))
        self._with_bars, self._notes = color_bar, (figure, credit)
        styles = assignment.asked(style, found)
        self._camera, self._found = corotating(camera, [assignment.shown(source, styles) for source in found])
        self._painters = [assignment.painters(source, styles, theme) for source in self._found]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture [pixels]."""
        return self._layout.size

    def _begin(self) -> None:
        """Reset all state that depends on earlier frames."""
        for painter in chain.from_iterable(self._painters):
            painter.begin()
        for panel in self._panels:
            panel.tags.begin()

    def _make_footer(self, clock: Clock, steps: Sequence[float | None], numbers: Sequence[int] | None = None) -> Footer:
        """The footer of some panels, by default all; `steps` are the time steps of these panels [s]."""
        found = self._found if numbers is None else [self._found[number] for number in numbers]
        facts = [
            (source.integrator if "integrator" in self._labels else None, step)
            for source, step in zip(found, steps, strict=True)
        ]
        legend = self._legend(list(chain.from_iterable(self._painters)))
        return Footer(self._labels, clock, facts, self._color_bars(), *self._notes, legend, self._units)

    def _color_bars(self) -> list[Bar]:
        """The color bars of all painters, if there are to be any."""
        every = [painter.scale for painter in chain.from_iterable(self._painters)]
        return bars(every, self._units) if self._with_bars else []

    def _legend(self, painters: Sequence[Painter]) -> list[tuple[str, Color]]:
        """The names of the legend with the colors of their bodies or systems, without duplicates."""
        colors = {id(item): color for painter in painters for item, color in painter.legend}
        entries = {(item.name or "", colors.get(id(item))): item for panel in self._listed for item in panel}
        for (_, color), item in entries.items():
            is_body = item.section == "bodies"
            if color is None and (is_body or not self._all_listed):
                style = "colors by body, such as styles.Points('body')"
                if not is_body:
                    style = "has one color, such as styles.Trails(color='tomato')"
                raise SceneError(f"legend: {item!r} is not drawn in one color; give it a style that {style}")
        return [(name, color) for name, color in entries if color is not None]

    def _compose(
        self, size: tuple[int, int] | None, found: list[Extent], passes: Sequence[FirstPass], *, still: bool
    ) -> None:
        """Divide the picture into panels, and draw the static content if the view is at rest.

        Args:
            size: width and height [pixels]; None: a size that suits the motion.
            found: the extent of each panel.
            passes: what the first pass has seen of each panel.
            still: whether the view is the same in all pictures.
        """
        flat = self._found[0].scene.dimension < 3
        self._still, self._over = still and not self._in_turn, not flat and any(extent.given for extent in found)
        self._panels = self._lay_out(size, found, passes)
        views = [panel.view.at(0) for panel in self._panels]
        self._canvas = Canvas(*self.size, self._theme.background, 1 if views[0].flat else self._samples)
        if self._still:
            self._draw_scenery(self._panels, views)
            self._canvas.keep()

    def _layout_of(self, size: tuple[int, int]) -> Layout:
        layout = Layout(size, len(self._found), self._heading, self._columns, in_turn=self._in_turn)
        return replace(layout, footer=self._footer_height(layout.text, size[0]) if self._captioned else 0)

    def _footer_height(self, text: int, width: int) -> int:
        """The height of the footer, for a height of the text and a width of the picture [pixels]."""
        return self._footer.height(text, width)

    def _inset(self, layout: Layout, index: int) -> float:
        """Distance of the motion from a panel's edge [pixels]."""
        pixels = layout.pixels(index)
        return layout.margin(index) + max((painter.inset(pixels) for painter in self._painters[index]), default=0.0)

    def _divided(self, layout: Layout, index: int) -> tuple[tuple[int, int, int, int], list[Area]]:
        """The part of a panel that is free of text and diagrams, and the rectangles of the diagrams."""
        free, boxes = beside(layout.area(index), len(self._insets), layout.bar_text)
        left, top, right, bottom = map(round, free)
        return (left, top, right, bottom), boxes

    def _lay_out(self, size: tuple[int, int] | None, found: list[Extent], passes: Sequence[FirstPass]) -> list[Panel]:
        """Divide the picture into panels and fit the common camera."""

        def magnification(candidate: tuple[int, int]) -> float:
            layout = self._layout_of(candidate)
            return min(
                extent.magnification(self._divided(layout, index)[0], self._inset(layout, index))
                for index, extent in enumerate(found)
            )

        if size is None:
            columns, rows = (1, 1) if self._in_turn else (self._columns, math.ceil(len(found) / self._columns))
            size = best(columns, rows, magnification, fixed=any(extent.given for extent in found))
        self._layout = layout = self._layout_of(size)
        panels = []
        for index, (source, painters, extent, seen) in enumerate(
            zip(self._found, self._painters, found, passes, strict=True)
        ):
            (free, _), pixels = self._divided(layout, index), layout.pixels(index)
            view = PanelView(extent, free, self._inset(layout, index))
            tags = NameTags(self._tagged[index], painters, free, layout.text, self._theme)
            bar = None if self._bar is False else ScaleBar(self._bar, free, layout.text, self._theme, self._units)
            panels.append(Panel(source, painters, layout.panel(index), free, pixels, view, seen.samples, tags, bar))
        return panels

    def _add_diagrams(self, passes: Sequence[FirstPass], duration: float) -> None:
        """Create the diagrams of each panel, for a duration [s]."""
        energy = energy_graph([seen.energies for seen in passes], duration, self._units)
        for number, panel in enumerate(self._panels):
            _, boxes = self._divided(self._layout, number)
            panel.diagrams = [
                Diagram(energy if asked == "energy" else asked, number, box, self._layout.bar_text, self._theme)
                for asked, box in zip(self._insets, boxes, strict=True)
            ]

    def _draw_scenery(self, panels: Sequence[Panel], views: Sequence[View]) -> None:
        """Draw all that is behind every moving object."""
        canvas = self._canvas
        for panel, view in zip(panels, views, strict=True):
            canvas.clip(*panel.rectangle)
            if not view.flat:
                canvas.eye(view.scale, view.middle, view.distance)
                draw_backdrop(canvas, panel.source.scene, panel.rectangle, self._theme)
            draw_behind(canvas, panel.source.scene, view, self._theme, panel.view.scenery(view))
        canvas.clip(0, 0, *self.size)

    def _record(
        self, tape: Tape, frames: Sequence[SourceFrame], views: Sequence[View], moments: Sequence[int],
        numbers: Sequence[int],
    ) -> None:  # fmt: skip
        """Put a picture on the tape of a page; arguments as of `_draw`."""
        canvas = cast("Canvas", tape)
        tape.next()
        for number, seen, moment, frame in zip(numbers, views, moments, frames, strict=True):
            panel, view = self._panels[number], replace(seen, turnable=not seen.flat)
            drawn, scenery, scene = panel.view.shown(frame, view), panel.view.scenery(view), panel.source.scene
            tape.look(number, view)
            if not self._still or tape.count == 1:
                tape.begin(0, "the scenery", still=self._still)
                if not view.flat:
                    draw_backdrop(canvas, scene, panel.rectangle, self._theme)
                record(tape, scene, view, self._theme, scenery)
            for painter in panel.painters:
                drawn = painter.raised(drawn)
            for owner, painter in enumerate(panel.painters, start=1):
                painter.domain = scenery.domain
                tape.begin(owner, type(painter.style).__name__)
                painter.record(tape, drawn, view, panel.pixels)
            tape.begin(len(panel.painters) + 1, "a label", whole=True)
            panel.draw_labels(canvas, drawn, view, moment)
        self._write_titles(canvas, numbers)

    def _write_titles(self, canvas: Canvas, numbers: Sequence[int]) -> None:
        outline = self._theme.background if self._over else None
        for line in self._layout.written(numbers):
            color = self._theme.label if line.quiet else self._theme.text
            write(canvas, line.text, line.left, line.top, line.height, color, line.align, outline)
        for index in numbers:
            for bar, box in self._layout.bars(index):
                bar.draw(canvas, box, self._layout.bar_text, self._theme, outline)

    def _draw(
        self,
        frames: Sequence[SourceFrame],
        views: Sequence[View],
        moments: Sequence[int],
        time: float,
        numbers: Sequence[int] | None = None,
    ) -> Canvas:
        """Draw a picture.

        Args:
            frames: the frame of each panel.
            views: the view of each panel.
            moments: the moment of each panel in its diagram.
            time: the time of the label [s].
            numbers: the numbers of these panels; None: all.
        """
        chosen = range(len(self._panels)) if numbers is None else numbers
        panels = [self._panels[number] for number in chosen]
        canvas = self._canvas
        canvas.clear()
        if not self._still:
            self._draw_scenery(panels, views)
        for panel, view, moment, frame in zip(panels, views, moments, frames, strict=True):
            drawn = panel.view.shown(frame, view)
            for painter in panel.painters:
                drawn = painter.raised(drawn)
            canvas.clip(*(panel.free if view.flat else panel.rectangle))  # in 3D the ground extends below the text
            canvas.lens(view.blur, view.distance)
            if not view.flat:
                canvas.eye(view.scale, view.middle, view.distance)
                canvas.light(LAMP, SHADOW, OCCLUSION, REACH * math.sqrt(panel.pixels))
            scenery = panel.view.scenery(view)
            draw_among(canvas, panel.source.scene, view, self._theme, scenery)
            for painter in panel.painters:
                painter.domain = scenery.domain
                painter.paint(canvas, drawn, view, panel.pixels)
            canvas.paint()
            canvas.clip(*panel.rectangle)
            panel.draw_labels(canvas, drawn, view, moment)
        canvas.clip(0, 0, *self.size)
        self._write_titles(canvas, chosen)
        energies, text = [each.energy for each in frames], self._layout.text
        if self._captioned:
            self._footer.draw(canvas, self.size, text, self._theme, time, energies, over=self._over)
        return canvas
