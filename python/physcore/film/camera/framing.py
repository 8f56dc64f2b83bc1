"""Framing: completes cameras from the motion, and computes the view of each panel in each frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from physcore.checks import FloatArray
from physcore.errors import SceneError
from physcore.film.camera.track import Camera, Follow, still
from physcore.film.camera.view import Area, Face, Orbit, Still, View, Window, aim, look_at
from physcore.film.camera.view import frame as fit
from physcore.film.first_pass import Bounds, FirstPass
from physcore.film.looks.base import GRID, Scenery
from physcore.film.raised import Raised
from physcore.film.styles.base import drawn_dimension
from physcore.scene.periodic import Periodic
from physcore.simulation.sources import Source, SourceFrame

LOW, HIGH = Orbit(), Orbit(elevation=52.0)
"""Default cameras of 3D scenes; HIGH is for flat ones."""
SIDEWAYS = Orbit(azimuth=-74.0, elevation=38.0)
"""Default camera of a relief: along y, so that the width of the plane fills the picture."""
FLAT = 0.25
"""A scene is flat if its height is below this fraction of its width."""
MARGIN = 2.0
"""Ratio of the extent of the view around a followed body to the extent of the body."""
AROUND = 0.1
"""Least extent of the view around a followed body, as a fraction of the extent of the whole motion."""
GROUND = 0.54
"""Half the width of the ground in 3D, as a fraction of the extent of the motion above it."""


@dataclass(frozen=True, eq=False)
class CameraTrack:
    """The candidate cameras of a film, each with one entry per frame, or a single entry if it is at rest."""

    choices: list[list[Still]]
    follow: Follow | None

    @property
    def axes(self) -> list[FloatArray]:
        """The axes of each candidate, shape (K, D, D)."""
        return [np.stack([each.axes for each in stills]) for stills in self.choices]

    @property
    def moving(self) -> bool:
        """Whether the view changes from frame to frame."""
        return self.follow is not None or len(self.choices[0]) > 1

    @property
    def closed(self) -> bool:
        """Whether the cameras are complete without the bounds of the motion."""
        return self.follow is None and all(_is_closed(each) for stills in self.choices for each in stills)


def camera_track(camera: Camera | Follow | None, found: Sequence[Source], clock: FloatArray) -> CameraTrack:
    """The cameras of a film at the times `clock` of its frames [s].

    Raises:
        SceneError: the panels differ in dimension, or the camera does not suit their dimension.
    """
    dimensions = {drawn_dimension(source.scene) for source in found}
    if len(dimensions) > 1:
        raise SceneError("recording: panels must all be in 2D or all in 3D")
    flat = dimensions == {2}
    follow = camera if isinstance(camera, Follow) else None
    inner = camera.camera if isinstance(camera, Follow) else camera
    if inner is None:
        raised = any(isinstance(source, Raised) for source in found)
        standing: list[Still] = [Face()] if flat else [SIDEWAYS] if raised else [LOW] if follow else [LOW, HIGH]
        choices = [[each] for each in standing]
    else:
        stills = [still(inner, time, flat=flat) for time in clock.tolist()]
        choices = [stills[:1] if all(each == stills[0] for each in stills) else stills]
    if follow is not None:
        for source in found:
            follow.rows(source.scene)
        if any(isinstance(each, Orbit) and each.target is not None for each in choices[0]):
            raise SceneError("Follow.camera: must have no target; the bodies are what it looks at")
        choices = [stills * len(clock) if len(stills) == 1 else stills for stills in choices]
    return CameraTrack(choices, follow)


@dataclass(eq=False)
class Extent:
    """The extent of one panel: the centers of its views, and the reach of its contents from there.

    All arrays have one row for each frame, or a single row if the view does not change.
    """

    stills: list[Still]
    centers: FloatArray
    """Centers of the views, along each camera's axes [m], shape (K, D)."""
    shown: FloatArray
    """Half the size of the box that must be in the picture [m], shape (K, D)."""
    seen: FloatArray
    """Half the size of the box of all contents [m], shape (K, D)."""
    scenery: Scenery
    """The placement of the scenery."""
    domain: Periodic | None
    """The periodic domain, if the camera follows a body in it; otherwise None."""
    follows: bool
    """Whether the camera follows a body."""

    def magnification(self, area: Area, inset: float) -> float:
        """The smallest magnification of all views in a rectangle [pixels/m]."""
        framing = fit(self.stills, self.shown, area, inset, self.seen)
        if isinstance(self.stills[0], Window):
            return min(aim(each, self.centers[0], framing, area).scale for each in self.stills)
        return framing.scale

    @property
    def given(self) -> bool:
        """Whether the extent of the view is independent of the picture's aspect ratio: it was given, or it surrounds a
        body.
        """
        if self.follows and not isinstance(self.stills[0], Window):
            return True
        return any(isinstance(each, Orbit) and each.extent is not None for each in self.stills)

    def turned(self, azimuth: float, elevation: float, zoom: float) -> Extent:
        """The extent of the first view from another direction [degrees], magnified, with the same target."""
        camera = self.stills[0]
        target = camera.axes.T @ self.centers[0]
        if isinstance(camera, Orbit):
            level = min(max(camera.elevation + elevation, -90.0), 90.0)
            extent = None if camera.extent is None else camera.extent / zoom
            camera = replace(camera, azimuth=camera.azimuth + azimuth, elevation=level, extent=extent)
        elif isinstance(camera, Window):
            half = (np.array(camera.upper) - np.array(camera.lower)) / (2.0 * zoom)
            lower, upper = (target + sign * half for sign in (-1.0, 1.0))
            camera = Window((lower[0], lower[1]), (upper[0], upper[1]))
        center = (camera.axes @ target)[np.newaxis]
        shown = self.shown[:1].copy()
        shown[:, :2] /= zoom  # The depth stays, and all that is seen: the camera does not come nearer.
        seen = np.maximum(self.seen, self.shown)[:1]
        return replace(self, stills=[camera], centers=center, shown=shown, seen=seen)


@dataclass(eq=False)
class PanelView:
    """The view of one panel in each frame."""

    extent: Extent
    area: Area
    inset: float

    def __post_init__(self) -> None:
        extent = self.extent
        self._framing = fit(extent.stills, extent.shown, self.area, self.inset, extent.seen)
        self._standing = self._view(0) if len(extent.stills) == 1 else None

    def at(self, index: int) -> View:
        """The view of a frame."""
        return self._view(index) if self._standing is None else self._standing

    def toward(self, camera: Still, target: FloatArray) -> View:
        """The view of a camera that looks at a point (D,) [m], at the scale of all views."""
        return aim(camera, camera.axes @ target, self._framing, self.area)

    def scenery(self, view: View) -> Scenery:
        """The placement of the scenery in a view."""
        scenery, left, right = self.extent.scenery, self.area[0], self.area[2]
        if view.flat:  # the ground extends beyond the picture
            wide = float(right - left + self.area[3]) / view.scale
            scenery = replace(scenery, middle=view.center, size=max(scenery.size, wide))
        if self.extent.domain is None:
            return scenery
        center = view.axes.T @ view.center
        lower = np.where(np.isfinite(self.extent.domain.lengths), center - self.extent.domain.lengths / 2, -np.inf)
        upper = np.where(np.isfinite(self.extent.domain.lengths), center + self.extent.domain.lengths / 2, np.inf)
        if not view.flat:  # the ground follows the view in steps of its grid
            step = 2.0 * scenery.size / GRID
            scenery = replace(scenery, middle=step * np.rint(center / step))
        return replace(scenery, domain=Periodic(lower, upper))

    def shown(self, frame: SourceFrame, view: View) -> SourceFrame:
        """A frame as drawn. With a followed body in a periodic domain, the image of each particle nearest to the camera
        is shown.
        """
        if self.extent.domain is None:
            return frame
        center = view.axes.T @ view.center
        domain = self.extent.domain
        moved = [name for name in ("positions", "rigid_positions") if name in frame.fields]
        nearest = {name: center + domain.nearest(frame.fields[name] - center) for name in moved}
        return replace(frame, fields={**frame.fields, **nearest})

    def _view(self, index: int) -> View:
        index = min(index, len(self.extent.stills) - 1)
        return aim(self.extent.stills[index], self.extent.centers[index], self._framing, self.area)


def extents(track: CameraTrack, passes: Sequence[FirstPass], found: Sequence[Source]) -> list[Extent]:
    """The extent of each panel, such that all panels share one camera and one scale."""
    whole = _merged([seen.whole for seen in passes])
    lower, upper = whole.lower[0], whole.upper[0]
    chosen = _choice(upper - lower) if len(track.choices) > 1 else 0
    stills, box = track.choices[chosen], _merged([seen.boxes[chosen] for seen in passes])
    axes = box.axes
    if track.follow is None:
        centers = [_centers(stills, axes, box, (lower + upper) / 2)] * len(found)
        shown = seen = np.maximum(box.upper - centers[0], centers[0] - box.lower)
    else:
        paths = [_path(each, track.follow, source) for source, each in zip(found, passes, strict=True)]
        centers = [np.einsum("kij,kj->ki", axes, path) for path in paths]
        reaches = [_reach(source.scene.periodic, whole, path) for source, path in zip(found, paths, strict=True)]
        seen = np.abs(axes) @ np.max(reaches, axis=0)
        bodies = [np.maximum(each.upper, -each.lower).max(axis=0) for each in _around(passes)]
        least = AROUND * np.max((box.upper - box.lower) / 2, axis=0)
        shown = np.tile(np.maximum(MARGIN * np.max(bodies, axis=0), least), (len(stills), 1))
    result = []
    for source, center in zip(found, centers, strict=True):
        scenery = _scenery(track, source, stills, lower, upper, axes[0].T @ center[0])
        domain = source.scene.periodic if track.follow is not None else None
        result.append(Extent(stills, center, shown, seen, scenery, domain, track.follow is not None))
    return result


def _centers(stills: Sequence[Still], axes: FloatArray, box: Bounds, middle: FloatArray) -> FloatArray:
    """The centers of each camera's view, along its axes (K, D) [m]."""
    if len(stills) == 1 and look_at(stills[0]) is None:
        return (box.lower + box.upper) / 2  # the box is tight along the axes of a camera at rest
    targets = [look_at(each) for each in stills]
    return np.stack([axis @ (middle if at is None else at) for axis, at in zip(axes, targets, strict=True)])


def _path(seen: FirstPass, follow: Follow, source: Source) -> FloatArray:
    """The path of a following camera (F, D) [m]."""
    assert seen.path is not None  # the first pass has recorded the path
    return seen.path.smoothed(follow.smoothing * source.fps)


def _around(passes: Sequence[FirstPass]) -> list[Bounds]:
    """Bounds of the followed particles, relative to the paths of the cameras."""
    return [seen.path.around for seen in passes if seen.path is not None]


def _reach(domain: Periodic | None, whole: Bounds, path: FloatArray) -> FloatArray:
    """The largest distance of the contents from a path, along the axes of the scene (D,) [m]; half a period in a
    domain.
    """
    away = np.maximum(whole.upper - path, path - whole.lower).max(axis=0)
    if domain is None:
        result: FloatArray = away
        return result
    return np.where(np.isfinite(domain.lengths), domain.lengths / 2, away)


def _scenery(
    track: CameraTrack,
    source: Source,
    stills: Sequence[Still],
    lower: FloatArray,
    upper: FloatArray,
    center: FloatArray,
) -> Scenery:
    """The ground below the motion; it stays in place when the camera moves."""
    extent = upper - lower
    if len(extent) == 2:
        return Scenery(source.scene.periodic, center, float(np.linalg.norm(extent)))
    widths = [float(extent[0]), float(extent[1])]
    widths += [each.extent for each in stills if isinstance(each, Orbit) and each.extent is not None and track.closed]
    return Scenery(source.scene.periodic, (lower + upper) / 2 if track.moving else center, GROUND * max(widths))


def _merged(boxes: Sequence[Bounds]) -> Bounds:
    """The union of the boxes of all panels."""
    result = Bounds(boxes[0].axes)
    for each in boxes:
        result.merge(each)
    return result


def _choice(extent: FloatArray) -> int:
    """The index of the camera that suits the shape of the motion."""
    width, depth, height = extent
    return int(height < FLAT * max(width, depth))


def _is_closed(camera: Still) -> bool:
    """Whether a camera gives both its target and its extent."""
    if isinstance(camera, Orbit):
        return camera.target is not None and camera.extent is not None
    return isinstance(camera, Window)
