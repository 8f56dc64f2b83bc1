"""Pictures of single states, without a film."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from physcore.checks import count, flag, number, shown, span, word
from physcore.errors import SceneError
from physcore.film.camera.corotating import Corotating
from physcore.film.camera.framing import Extent, camera_track, extents
from physcore.film.camera.track import Camera, Follow, masses_of, middle, places_in, still
from physcore.film.camera.view import View, look_at
from physcore.film.colors.themes import Color, Theme, ThemeName, chosen_theme
from physcore.film.composition import Composition, Panel
from physcore.film.first_pass import FirstPass, first_pass
from physcore.film.labels.clock import Clock, check_unit
from physcore.film.labels.curves import Inset
from physcore.film.labels.dates import check_start
from physcore.film.labels.footer import Label
from physcore.film.labels.heading import check_heading, line_or_none
from physcore.film.labels.scale_bar import LengthUnit
from physcore.film.labels.tags import Listed, Named
from physcore.film.layout import Format, check_format, check_size
from physcore.film.present import Present
from physcore.film.quality import QUALITIES, SAMPLES, Quality
from physcore.film.styles import Style
from physcore.numerics.choices import FRAMES_PER_SECOND
from physcore.scene.scene import Scene
from physcore.simulation.simulation import Simulation, require_scene
from physcore.simulation.sources import SourceFrame
from physcore.simulation.state import Frame, Snapshot

if TYPE_CHECKING:
    from datetime import date

FRAMES = 300
"""Nominal number of frames: ten seconds of a film."""
NEAR = 2.0
"""Largest distance of visible scenery, over the extent of the first state, which is going to move within it."""
AUDITED = ("dt", "energy")
"""Labels that need a time step or an energy."""
State: TypeAlias = Simulation | Snapshot


class Renderer(Composition):
    """Draws pictures of a scene, one state at a time: of a running simulation, or of a frame.

        renderer = pc.Renderer(scene, size=(640, 360))
        simulation = pc.Simulation(scene)
        picture = renderer.draw(simulation)  # (360, 640, 3), for matplotlib's imshow or PIL.Image.fromarray
        simulation.run(0.1)
        later = renderer.draw(simulation)  # in the same view

    A film of the whole motion is drawn by `physcore.film`, which looks at all frames first. A renderer knows only what
    it has drawn. The first picture frames the view around its state and the scenery, unless the camera gives one, and
    the view stays. Trails, paths and the diagram of energy consist of the states drawn before. The ends of color scales
    that a style does not give are typical values of these states.

    Args:
        scene: the scene.
        size, format, style, theme, background, title, subtitle, formula, figure, credit, labels, color_bar, legend,
            name_tags, scale_bar, inset, time_unit, start, quality: as in `film`.
        camera: as in `film`. A function of the time or Keyframes without an extent show the first state completely in
            all directions of the next `duration`. Follow looks exactly at the center of mass, because smoothing needs
            later frames.
        fps: how many pictures are going to be drawn per second of the simulation, or other unit of time of its scene.
            They may be drawn at any times; the lengths of trails in frames, and the digits of time, follow from it.
        duration: the expected duration [s], for the lengths of trails and the unit of time; None: 300 frames.
        room: width of the view over that of the first state, at least 1; a camera that gives the view is not affected.

    Raises:
        SceneError: an argument is not valid.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        size: tuple[int, int] | None = None,
        format: Format | None = None,
        style: Style | Sequence[Style] | None = None,
        camera: Camera | Follow | Corotating | None = None,
        theme: Theme | ThemeName = "dark",
        background: Color | str | None = None,
        title: str | None = None,
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
        quality: Quality = "fast",
        fps: float = FRAMES_PER_SECOND,
        duration: float | None = None,
        room: float = 1.0,
    ) -> None:
        require_scene(scene)
        self._room = number(room, "room", least=1.0)
        self._fps = span(fps, "fps")
        self._duration = FRAMES / self._fps if duration is None else span(duration, "duration")
        self._asked = check_format(format, check_size(size), video=False)
        self._time_unit, self._start = time_unit, start
        self._contents = {
            "style": style,
            "camera": camera,
            "theme": chosen_theme(theme, background),
            "heading": check_heading(title, None, subtitle, 1, formula=formula),
            "labels": labels,
            "color_bar": flag(color_bar, "color_bar"),
            "legend": legend,
            "name_tags": name_tags,
            "scale_bar": scale_bar,
            "inset": inset,
            "figure": line_or_none(figure, "figure"),
            "credit": line_or_none(credit, "credit"),
            "samples": SAMPLES[word(quality, "quality", QUALITIES)],
        }
        self._extent: Extent | None = None
        self._is_turned = False
        """Whether the view was turned since the last picture."""
        self._arrange(scene)

    def _arrange(self, scene: Scene) -> None:
        """Prepare for the states of a scene, without a view."""
        number = count(max(1.0, round(self._duration * self._fps)), "duration")
        self._present = Present(scene, self._fps, number)
        super().__init__([self._present], **self._contents)  # type: ignore[arg-type]
        check_unit(self._time_unit, scene.units)
        self._first_date = check_start(self._start, scene.units)
        self._extent = None
        self._seen: FirstPass | None = None
        self._views: list[View] = []
        self._last: tuple[SourceFrame, NDArray[np.uint8]] | None = None

    @property
    def scene(self) -> Scene:
        """The scene of the last state, or the one that was given."""
        return self._present.scene

    @property
    def view(self) -> View | None:
        """The projection of the last picture; None before the first one."""
        return self._views[0] if self._views else None

    def draw(self, state: State) -> NDArray[np.uint8]:
        """The picture of a state: a Simulation at its present time, or a Frame or Snapshot of a whole scene.

        Drawing does not change a simulation. A state that is not later than the last one begins trails anew. A state of
        another scene, as after `Simulation.replace`, is drawn in the same view, with colors and trails that begin anew.

        Returns:
            Colors (height, width, 3), from 0 to 255.

        Raises:
            SceneError: the value is no such state; a label or the inset needs a Frame or a Simulation; or a style needs
                items that the scene of the state does not have.
        """
        frame, scene, integrator = self._parts_of(state)
        with scene.units.worded():
            if scene is not self._present.scene:
                self._change(scene)
            self._present.frame, self._present.integrator = frame, integrator
            frame = next(self._found[0].frames())
            if self._last is not None and _equal(frame, self._last[0]) and not self._is_turned:
                return self._last[1].copy()
            pixels = self._drawn(frame)
            self._last, self._is_turned = (frame, pixels), False
            return pixels.copy()

    def look_as(self, other: Renderer) -> None:
        """Take the view of another renderer of the same scene, which may have another size or theme.

        Raises:
            SceneError: the scenes have different dimensions.
        """
        if other.scene.dimension != self.scene.dimension:
            raise SceneError(
                f"look_as.other: must show a scene in {self.scene.dimension}D, got {other.scene.dimension}D"
            )
        self._extent = other._extent

    def turn(self, azimuth: float = 0.0, elevation: float = 0.0, zoom: float = 1.0) -> None:
        """Move the camera about its target, and magnify, from the next picture on.

        Args:
            azimuth, elevation: the angles by which it moves [degrees]; without effect in 2D. The elevation stays within
                −90 and 90.
            zoom: factor of the magnification, from 0.01 to 100.

        Raises:
            SceneError: a value is not valid, nothing was drawn yet, or the camera moves by itself.
        """
        angles = number(azimuth, "turn.azimuth"), number(elevation, "turn.elevation")
        factor = number(zoom, "turn.zoom", least=0.01, most=100.0)
        if self._extent is None or self._seen is None or self._moving:
            raise SceneError("turn: needs a camera at rest that has drawn a picture")
        self._extent = self._extent.turned(*angles, factor)
        self._compose(self.size, [self._extent], [self._seen], still=True)
        self._is_turned = True

    def reset(self) -> None:
        """Forget all states drawn so far, with their view: the next picture is framed as the first one was."""
        self._arrange(self._present.scene)

    def _parts_of(self, state: State) -> tuple[SourceFrame, Scene, str | None]:
        """The frame of a state, its scene, and the name of its integrator."""
        present = state.frame() if isinstance(state, Simulation) else state
        if not isinstance(cast("object", present), Snapshot) or present.scene is None:
            raise SceneError(
                f"draw.state: must be a Simulation, or a Frame or Snapshot of a whole scene, got {shown(state)}"
            )
        energy, dt = (present.energy, present.dt) if isinstance(present, Frame) else (None, None)
        integrator = type(state.integrator).__name__ if isinstance(state, Simulation) else None
        needed = [f"the label {label!r}" for label in AUDITED if label in self._labels]
        needed += ["the inset"] if self._insets else []
        if needed and energy is None:
            raise SceneError(f"draw.state: {needed[0]} needs a Frame or a Simulation, got {shown(state)}")
        if "integrator" in self._labels and integrator is None:
            raise SceneError(f"draw.state: the label 'integrator' needs a Simulation, got {shown(state)}")
        return SourceFrame(present.time, present.fields, energy, dt), present.scene, integrator

    def _change(self, scene: Scene) -> None:
        """Go on with another scene in the same view, if it has the same dimension."""
        kept = self._extent
        self._arrange(scene)
        drawn = self._found[0].scene
        if kept is not None and kept.centers.shape[1] == max(drawn.dimension, 2):
            domain = drawn.periodic if kept.follows else None
            self._extent = replace(kept, scenery=replace(kept.scenery, domain=drawn.periodic), domain=domain)

    def _drawn(self, frame: SourceFrame) -> NDArray[np.uint8]:
        """Draw a frame that differs from the last one."""
        if self._last is not None and frame.time <= self._last[0].time:
            self._begin()
            self._footer.begin()
            if self._seen is not None:
                self._seen.energies.clear()
        if self._seen is None:
            self._look_at(frame)
        else:
            for painter in self._painters[0]:
                painter.observe(frame)
            self._label(frame)
            if frame.energy is not None:
                self._seen.energies.append(frame.energy)
        assert self._seen is not None
        if self._insets:
            first = self._seen.energies[0].time
            self._add_diagrams([self._seen], max(self._duration, frame.time - first))
        self._views = [self._view(panel, frame) for panel in self._panels]
        return self._draw([frame], self._views, [len(self._seen.energies) - 1], frame.time).pixels()

    def _look_at(self, frame: SourceFrame) -> None:
        """Find the view and the color scales from the first frame, and lay out the picture."""
        camera = self._camera.camera if isinstance(self._camera, Follow) else self._camera
        moments = self._present.times if callable(camera) else np.zeros(1)
        track = camera_track(self._camera, self._found, frame.time + moments)
        source, painters = self._found[0], self._painters[0]
        self._seen = first_pass(source, [frame], len(moments), painters, track.axes, track.follow, lambda _: None, NEAR)
        if self._extent is None:
            found = extents(track, [self._seen], self._found)[0]
            self._extent = replace(found, shown=self._room * found.shown)
        self._moving = track.moving
        self._footer = self._make_footer(self._clock_at(frame.time), [frame.dt])
        self._compose(self._asked, [self._extent], [self._seen], still=not self._moving)

    def _label(self, frame: SourceFrame) -> None:
        """Renew the footer, whose scales may have changed; lay out the picture again if its height has changed."""
        before, self._footer = self._footer, self._make_footer(self._clock_at(frame.time), [frame.dt])
        self._footer.go_on(before)
        if self._layout_of(self.size).footer != self._layout.footer:
            assert self._extent is not None
            assert self._seen is not None
            self._compose(self.size, [self._extent], [self._seen], still=not self._moving)

    def _clock_at(self, time: float) -> Clock:
        """The clock of a picture at a time [s]."""
        times = np.array([0.0, max(self._duration, time)])
        return Clock(times, self._fps, self._fps, self._time_unit, self._units, self._first_date, paced=False)

    def _view(self, panel: Panel, frame: SourceFrame) -> View:
        """The view of a frame."""
        if not self._moving:
            return panel.view.at(0)
        extent, follow = panel.view.extent, self._camera if isinstance(self._camera, Follow) else None
        camera = self._camera if follow is None else follow.camera
        assert not isinstance(camera, (Follow, Corotating))  # the composition has taken the camera out of these
        now = still(camera, frame.time, flat=extent.stills[0].axes.shape[0] == 2) if callable(camera) else None
        now = extent.stills[0] if now is None else now
        target = look_at(now)
        if follow is not None:
            scene, chosen = panel.source.scene, follow.rows(panel.source.scene)
            target = middle(places_in(frame.fields)[chosen], masses_of(scene)[chosen], scene.periodic)
        if target is None:
            target = extent.stills[0].axes.T @ extent.centers[0]
        return panel.view.toward(now, target)


def _equal(one: SourceFrame, other: SourceFrame) -> bool:
    """Whether two frames show the same state."""
    same = one.time == other.time and one.dt == other.dt and one.fields.keys() == other.fields.keys()
    return same and all(np.array_equal(one.fields[name], other.fields[name], equal_nan=True) for name in one.fields)
