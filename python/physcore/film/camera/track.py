"""Moving cameras: keyframes, cameras that follow a body, and functions of time."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, cast

import numpy as np

from physcore.checks import BoolArray, FloatArray, called, number, shown, span, word
from physcore.errors import SceneError
from physcore.film.camera.view import Orbit, Still, Window
from physcore.scene.bodies import Body
from physcore.scene.contents import BodyKey
from physcore.scene.periodic import Periodic
from physcore.scene.scene import Scene

Easing = Literal["smooth", "linear"]
OPEN = ("target", "extent")
"""Parameters of an Orbit that may be None, to be found from the motion."""
TAIL = 4.0
"""Cutoff of the Gaussian that smooths a path [standard deviations]."""
NARROW = 0.1
"""Standard deviation below which a Gaussian, e⁻⁵⁰ at the next frame, has no effect [frames]."""


@dataclass(frozen=True)
class Keyframes:
    """Camera interpolated between keyframes, for orbits, zooms and pans.

        near, far = pc.Window((0.0, 0.0), (0.4, 0.3)), pc.Window((-0.4, -0.3), (0.8, 0.6))
        pc.film(recording, "cloth.png", camera=pc.Keyframes({0.0: far, 0.2: near}))

    Angles and targets are interpolated linearly. An `extent`, and the size of a Window, changes by equal factors in
    equal times, so that a zoom looks uniform. During a zoom the target keeps its place in the picture. Before the first
    time and after the last one the camera is at rest. A parameter that is None in all keyframes is found from the
    motion, once for the whole film.

    Args:
        cameras: the camera at each time [s]; all of them Windows, or all of them Orbits.
        easing: "smooth": at rest at each keyframe (3w² − 2w³ in between); "linear": at a constant speed between
            keyframes.

    Raises:
        SceneError: a time is not a finite number, the cameras are of different kinds, or a parameter is None in some of
            them only.
    """

    cameras: Mapping[float, Window | Orbit]
    easing: Easing = "smooth"

    def __post_init__(self) -> None:
        given = cast(object, self.cameras)
        if not isinstance(given, Mapping) or not given:
            raise SceneError(f"Keyframes.cameras: must be like {{time: camera, …}}, got {shown(given)}")
        word(self.easing, "Keyframes.easing", ("smooth", "linear"))
        timed = {number(time, "Keyframes.cameras"): camera for time, camera in self.cameras.items()}
        ordered = [(time, timed[time]) for time in sorted(timed)]
        first = ordered[0][1]
        for time, camera in ordered:
            path, kind = f"Keyframes.cameras[{time:g}]", Window if isinstance(first, Window) else Orbit
            if not isinstance(camera, kind):
                raise SceneError(f"{path}: must be like the first one, a Window or an Orbit, got {shown(camera)}")
            for name in OPEN:
                if isinstance(first, Orbit) and (getattr(camera, name) is None) != (getattr(first, name) is None):
                    raise SceneError(f"{path}.{name}: give it in all keyframes or in none")
        object.__setattr__(self, "cameras", dict(ordered))

    def __call__(self, time: float) -> Window | Orbit:
        """The camera at a time [s]."""
        times = list(self.cameras)
        after = bisect_right(times, time)
        if after in (0, len(times)):
            return self.cameras[times[max(after - 1, 0)]]
        start, end = times[after - 1], times[after]
        fraction = (time - start) / (end - start)
        if self.easing == "smooth":
            fraction *= fraction * (3.0 - 2.0 * fraction)
        return between(self.cameras[start], self.cameras[end], fraction)


Camera = Window | Orbit | Keyframes | Callable[[float], Window | Orbit]
"""A camera at rest, or a function that gives the camera at a time [s]."""


@dataclass(frozen=True)
class Follow:
    """Camera that keeps a body in the middle of the picture.

        pc.film(recording, "cloth.png", camera=pc.Follow("cloth"))

    The camera looks at the center of mass of the particles or rigid bodies that can move, smoothed in time with a
    Gaussian. It begins to turn before the body does, never overshoots, and has no lag in uniform motion. In a periodic
    domain, the periodic images nearest to the body are shown.

    Args:
        bodies: the body, its index or its name, or several of them; each panel must have them.
        camera: the camera without a target: an Orbit in 3D, a Window in 2D (only its size is used), Keyframes or a
            function of these. None, or no extent: the body fills at most half of the picture, and the picture shows at
            least a tenth of the extent of the whole motion.
        smoothing: standard deviation of the Gaussian [s of the simulation]; 0: exactly at the center of mass.

    Raises:
        SceneError: an argument is not valid.
    """

    bodies: BodyKey | Sequence[BodyKey]
    camera: Camera | None = None
    smoothing: float = 0.5

    def __post_init__(self) -> None:
        keys = cast(object, (self.bodies,) if isinstance(self.bodies, (Body, int, str)) else self.bodies)
        if not isinstance(keys, Sequence) or not keys or not all(isinstance(key, (Body, int, str)) for key in keys):
            raise SceneError(f"Follow.bodies: must be a body or several ([one, two]), got {shown(self.bodies)}")
        object.__setattr__(self, "bodies", tuple(keys))
        object.__setattr__(self, "smoothing", span(self.smoothing, "Follow.smoothing", empty=True))
        if not is_camera(self.camera):
            raise SceneError(
                f"Follow.camera: must be a Window, an Orbit, Keyframes or a function, got {shown(self.camera)}"
            )

    def rows(self, scene: Scene) -> BoolArray:
        """The followed rows of `places_in`, as a mask (M,): those of the bodies that can move, or all if none can."""
        count = sum(map(len, scene.bodies))
        chosen, free = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
        assert isinstance(self.bodies, tuple)  # converted by __post_init__
        for key in self.bodies:
            try:
                body = scene.bodies[scene.index(key)]
            except (KeyError, IndexError) as error:
                raise SceneError(f"Follow.bodies: {error.args[0]}") from None
            where = row_of(scene, body)
            chosen[where], free[where] = True, ~body.fixed
        return free if free.any() else chosen


def row_of(scene: Scene, body: Body) -> slice:
    """The rows of a body in `places_in`."""
    rows = cast("slice", scene.parts(body)["positions"][1])
    return slice(rows.start + scene.particles, rows.stop + scene.particles) if body.is_rigid else rows


def places_in(fields: Mapping[str, FloatArray]) -> FloatArray:
    """The positions of all particles, then of all rigid bodies, in a frame (M, D) [m]."""
    rigid = fields.get("rigid_positions")
    return fields["positions"] if rigid is None else np.concatenate([fields["positions"], rigid])


def masses_of(scene: Scene) -> FloatArray:
    """The masses of the rows of `places_in` (M,) [kg]."""
    bodies = sorted(scene.bodies, key=lambda body: body.is_rigid)
    return np.concatenate([body.mass for body in bodies]) if bodies else np.empty(0)


def between(first: Window | Orbit, second: Window | Orbit, fraction: float) -> Window | Orbit:
    """The interpolation between two cameras of one kind, at a fraction of the way."""
    if isinstance(first, Window) and isinstance(second, Window):
        size, other = (math.sqrt(math.prod(np.subtract(each.upper, each.lower))) for each in (first, second))
        along = _zoomed(size, other, fraction)
        lower, upper = _mix(first.lower, second.lower, along), _mix(first.upper, second.upper, along)
        return Window((lower[0], lower[1]), (upper[0], upper[1]))
    assert isinstance(first, Orbit)
    assert isinstance(second, Orbit)
    along, extent, target = fraction, first.extent, first.target
    if first.extent is not None and second.extent is not None:
        extent = first.extent ** (1.0 - fraction) * second.extent**fraction
        along = _zoomed(first.extent, second.extent, fraction)
    if first.target is not None and second.target is not None:
        x, y, z = _mix(first.target, second.target, along)
        target = (x, y, z)
    angles = {
        name: (1.0 - fraction) * getattr(first, name) + fraction * getattr(second, name)
        for name in ("azimuth", "elevation", "field_of_view", "aperture")
    }
    return replace(first, target=target, extent=extent, **angles)


def still(camera: Camera, time: float, *, flat: bool) -> Still:
    """The camera at a time [s].

    Raises:
        SceneError: the camera is not a Window in 2D, or not an Orbit in 3D.
    """
    now = called(camera, "camera", time) if callable(camera) and not isinstance(camera, type) else camera
    if not isinstance(now, Window if flat else Orbit):
        when = "" if now is camera else f" at {time:g} s"
        raise SceneError(f"camera: must be {'a Window in 2D' if flat else 'an Orbit in 3D'}{when}, got {shown(now)}")
    return now


def smooth(path: FloatArray, width: float) -> FloatArray:
    """A path (F, D) smoothed with a Gaussian whose standard deviation is `width` frames.

    The path is extended by point reflection at its ends. Uniform motion and the end points thereby remain unchanged.
    """
    reach = min(math.ceil(TAIL * width), len(path) - 1)
    if reach == 0 or width < NARROW:
        return path
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    before, after = 2.0 * path[0] - path[reach:0:-1], 2.0 * path[-1] - path[-2 : -2 - reach : -1]
    longer = np.concatenate([before, path, after])
    columns = [np.convolve(column, weights / weights.sum(), mode="valid") for column in longer.T]
    return np.stack(columns, axis=1)


def middle(points: FloatArray, mass: FloatArray, domain: Periodic | None) -> FloatArray:
    """The center of mass [m] of points (N, D), which may lie on both sides of a face of the periodic domain.

    Along a periodic axis, the offsets are averaged about the mean direction on a circle whose circumference is the
    period.

    Source: L. Bai, D. Breen, "Calculating center of mass in an unbounded 2D environment", J. Graphics Tools 13 (4), 53
    (2008).
    """
    weight = mass / mass.sum()
    if domain is None:
        mean: FloatArray = weight @ points
        return mean
    lengths = domain.lengths
    turns = 2.0 * np.pi * np.where(np.isfinite(lengths), points / lengths, 0.0)
    turn = np.arctan2(weight @ np.sin(turns), weight @ np.cos(turns)) / (2.0 * np.pi)
    about = np.where(np.isfinite(lengths), turn * np.where(np.isfinite(lengths), lengths, 0.0), points[0])
    center: FloatArray = about + weight @ domain.nearest(points - about)
    return domain.wrap(center)


def is_camera(value: object) -> bool:
    """Whether a value can be a camera. The class Orbit is not one, although it can be called with a number."""
    return value is None or isinstance(value, (Window, Orbit)) or (callable(value) and not isinstance(value, type))


def _zoomed(first: float, second: float, fraction: float) -> float:
    """The progress, from 0 to 1, of a zoom between two sizes for which the target keeps its place in the picture."""
    ratio = second / first
    return fraction if abs(ratio - 1.0) < 1e-9 else (ratio**fraction - 1.0) / (ratio - 1.0)


def _mix(first: Sequence[float], second: Sequence[float], fraction: float) -> tuple[float, ...]:
    return tuple((1.0 - fraction) * one + fraction * other for one, other in zip(first, second, strict=True))
