"""Projection from meters to pixels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from physcore._core import Projection
from physcore.checks import FloatArray, number, span, vector, written
from physcore.errors import SceneError

PixelArray = NDArray[np.float32]
FOG = 0.2
"""Share of the background in the color of the farthest objects in 3D."""


@dataclass(frozen=True)
class Face:
    """The plane of a 2D scene, with the part to be shown left open."""

    @property
    def axes(self) -> FloatArray:
        """Unit vectors to the right and up, shape (2, 2)."""
        return np.eye(2)


@dataclass(frozen=True)
class Window(Face):
    """Rectangular view of a 2D scene, shown completely, centered and without distortion.

        pc.film(recording, "cloth.png", camera=pc.Window((-0.2, -0.2), (0.6, 0.5)))

    Args:
        lower: the lower left corner [m].
        upper: the upper right corner [m].

    Raises:
        SceneError: `lower` is not below `upper`, or the corners are not in 2D.
    """

    lower: tuple[float, float]
    upper: tuple[float, float]

    def __post_init__(self) -> None:
        lower, upper = vector(self.lower, "Window.lower"), vector(self.upper, "Window.upper")
        if len(lower) != 2 or len(upper) != 2 or not all(low < high for low, high in zip(lower, upper, strict=True)):
            raise SceneError(
                f"Window.upper: must be right of and above the lower corner {written(lower)}, got {written(upper)}"
            )
        object.__setattr__(self, "lower", lower)
        object.__setattr__(self, "upper", upper)


@dataclass(frozen=True)
class Orbit:
    """Camera of a 3D scene, given by a target and two angles. Up in the picture is +z.

        ball = pc.Particles([[0.0, 0.0, 1.0]], radius=0.1)
        scene = pc.Scene(ball, pc.Gravity(), pc.Floor())
        pc.film(scene, "ball.png", duration=1.0, camera=pc.Orbit(azimuth=30.0, elevation=20.0))

    Args:
        azimuth: direction of the camera from the target about the vertical, from +x toward +y [degrees].
        elevation: angle of the camera above the horizon [degrees], from -90 to 90.
        field_of_view: angle that the picture spans [degrees], below 120; 0 is an orthographic view from infinity.
        target: the point looked at [m]; None: the middle of the whole motion.
        extent: the length that the picture's shorter side spans at the target [m]; None: the whole motion fits.
        aperture: diameter of the lens as a fraction of the camera's distance from the target, which is in focus. A
            point
            at twice that distance is blurred into a disc, whose diameter at the target is half the aperture; 0: no
                blur.
            The aperture has no effect without perspective.

    Raises:
        SceneError: an angle or a length is out of range.
    """

    azimuth: float = -60.0
    elevation: float = 20.0
    field_of_view: float = 28.0
    target: tuple[float, float, float] | None = None
    extent: float | None = None
    aperture: float = 0.0

    def __post_init__(self) -> None:
        target = None if self.target is None else vector(self.target, "Orbit.target")
        if target is not None and len(target) != 3:
            raise SceneError(f"Orbit.target: must have 3 components, got {len(target)}")
        values = {
            "azimuth": number(self.azimuth, "Orbit.azimuth"),
            "elevation": number(self.elevation, "Orbit.elevation", least=-90.0, most=90.0),
            "field_of_view": number(self.field_of_view, "Orbit.field_of_view", least=0.0, most=119.0),
            "target": target,
            "extent": None if self.extent is None else span(self.extent, "Orbit.extent"),
            "aperture": number(self.aperture, "Orbit.aperture", least=0.0, most=1.0),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @property
    def axes(self) -> FloatArray:
        """Unit vectors to the right, up and toward the camera, shape (3, 3)."""
        azimuth, elevation = math.radians(self.azimuth), math.radians(self.elevation)
        right = (-math.sin(azimuth), math.cos(azimuth), 0.0)
        toward = (math.cos(azimuth) * math.cos(elevation), math.sin(azimuth) * math.cos(elevation), math.sin(elevation))
        return np.array([right, np.cross(toward, right), toward])


Still = Face | Orbit
"""A camera at one time."""
Area = tuple[float, float, float, float]
"""The left, top, right and bottom sides of a rectangle [pixels]."""


@dataclass(frozen=True)
class View:
    """A camera fitted to a rectangle of pixels: maps points (N, D) [m] to pixels."""

    axes: FloatArray
    center: FloatArray
    """The center of the view, along the camera's axes [m], shape (D,)."""
    scale: float
    """Pixels per meter at the center."""
    middle: tuple[float, float]
    """The middle of the rectangle [pixels]."""
    distance: float
    """Distance from the camera to the center [m]; inf for an orthographic view and in 2D."""
    reach: float
    """Half the depth of the whole motion [m]."""
    lens: float = 0.0
    """The diameter of the lens [m]."""
    turnable: bool = False
    """Whether the viewer of a page turns it: then objects do not fade with distance, and all have a finite depth."""
    height: float = 0.0
    """Height of the rectangle [pixels], of a camera in 2D."""

    @property
    def flat(self) -> bool:
        """Whether the scene is in 2D."""
        return len(self.center) == 2

    def project(self, points: FloatArray) -> tuple[PixelArray, PixelArray | None, PixelArray]:
        """Pixels (N, 2), distances from the camera (N,) [m] (None in 2D), and pixels per meter (N,)."""
        pixels, depth, magnification = self._projection.project(np.ascontiguousarray(points))
        return pixels, None if self.flat else depth, magnification

    @cached_property
    def _projection(self) -> Projection:
        return Projection(self.axes.tolist(), self.center.tolist(), self.scale, self.middle, self.distance)

    def farness(self, depth: PixelArray) -> PixelArray:
        """Depths as fractions: 0 at the nearest point of the whole motion, 1 at the farthest."""
        if self.turnable:
            return np.zeros_like(depth)
        fractions: PixelArray = np.clip(0.5 + 0.5 * depth / np.float32(self.reach), 0.0, 1.0)
        return fractions

    @property
    def fog(self) -> tuple[float, float]:
        """Half the depth of the whole motion [m], and the share of the background in the farthest colors."""
        return self.reach, 0.0 if self.turnable else FOG

    @property
    def blur(self) -> float:
        """Radius of the circle of confusion per distance from the plane of focus, in the limit of small distances
        [pixels/m].

        A thin lens of diameter A is focused at the distance D. The image of a point at D + d is a disc, whose diameter
        in the plane of focus is A |d| / (D + d). The radius per distance is therefore A / 2D. The canvas computes the
        exact radii.

        Source: M. Potmesil, I. Chakravarty, "A lens and aperture camera model for synthetic image generation", Computer
        Graphics 15 (3), 297 (1981).
        """
        return 0.5 * self.scale * self.lens / self.distance


@dataclass(frozen=True)
class Framing:
    """The parameters that cameras leave open, chosen so that everything fits; one for a whole film."""

    scale: float
    """Pixels per meter at the center."""
    size: float
    """Half the diagonal of the whole motion, seen from the centers [m]."""
    reach: float
    """Half the depth of the whole motion [m]."""


def frame(
    cameras: Sequence[Still], shown: FloatArray, area: Area, inset: float, seen: FloatArray | None = None
) -> Framing:
    """The framing in which each camera shows the whole box around its target.

    Args:
        cameras: one for each box.
        shown: half the sizes of the boxes, along each camera's axes [m], shape (F, D).
        area: the rectangle that must contain the boxes.
        inset: the least distance of a box from the rectangle's edge [pixels].
        seen: half the sizes of the boxes of all contents, shape (F, D); None: as `shown`.
    """
    left, top, right, bottom = area
    width, height = max(right - left - 2 * inset, 1.0), max(bottom - top - 2 * inset, 1.0)
    if shown.max() <= 0.0:
        shown = np.full_like(shown, 0.5)  # one particle at rest: show a meter around it
    seen = shown if seen is None else np.maximum(seen, shown)
    smallest = 1e-6 * shown.max()
    across, along = np.maximum(shown[:, 0], smallest), np.maximum(shown[:, 1], smallest)
    scales = np.minimum(width / across, height / along) / 2
    if shown.shape[1] == 2:
        return Framing(float(scales.min()), float(np.linalg.norm(seen, axis=1).max()), 1.0)
    extents = np.array([camera.extent or 0.0 for camera in cameras if isinstance(camera, Orbit)])
    reach = max(float(seen[:, 2].max()), float(extents.max()) / 2, smallest)
    size = max(float(np.linalg.norm(seen, axis=1).max()), float(extents.max()) / 2 * math.sqrt(3.0))
    for index, camera in enumerate(cameras):
        distance = _distance(camera, size, reach)
        if math.isfinite(distance):
            # The front of the box looks larger than its middle.
            scales[index] *= (distance - shown[index, 2]) / distance
    return Framing(float(scales.min()), size, reach)


def aim(camera: Still, center: FloatArray, framing: Framing, area: Area) -> View:
    """The view of a camera in a rectangle.

    Args:
        camera: the direction of view, and perhaps its extent.
        center: the point to look at, along the camera's axes [m], shape (D,).
        framing: the parameters that the camera leaves open.
        area: the rectangle.
    """
    left, top, right, bottom = area
    width, height, middle = max(right - left, 1.0), max(bottom - top, 1.0), ((left + right) / 2, (top + bottom) / 2)
    if isinstance(camera, Window):
        across, along = np.array(camera.upper) - np.array(camera.lower)
        scale = float(min(width / across, height / along))
        return View(camera.axes, center, scale, middle, math.inf, 1.0, height=height)
    if not isinstance(camera, Orbit):
        return View(camera.axes, center, framing.scale, middle, math.inf, 1.0, height=height)
    scale = framing.scale if camera.extent is None else min(width, height) / camera.extent
    distance = _distance(camera, framing.size, framing.reach)
    lens = camera.aperture * distance if math.isfinite(distance) else 0.0
    return View(camera.axes, center, scale, middle, distance, framing.reach, lens)


def look_at(camera: Still) -> FloatArray | None:
    """The target (D,) that a camera gives [m]; None if it gives none."""
    if isinstance(camera, Window):
        middle: FloatArray = (np.array(camera.lower) + np.array(camera.upper)) / 2
        return middle
    return None if not isinstance(camera, Orbit) or camera.target is None else np.array(camera.target)


def fit(camera: Still, lower: FloatArray, upper: FloatArray, area: Area, inset: float) -> View:
    """The view in which a box along the camera's axes exactly fits into a rectangle.

    Args:
        camera: the direction of view, and perhaps its target.
        lower, upper: corners of the box, along the camera's axes [m], shape (D,).
        area: the rectangle.
        inset: the least distance of the box from the rectangle's edge [pixels].
    """
    target = look_at(camera)
    center = (lower + upper) / 2 if target is None else camera.axes @ target
    half = np.maximum(upper - center, center - lower)
    return aim(camera, center, frame([camera], half[np.newaxis], area, inset), area)


def _distance(camera: Still, size: float, reach: float) -> float:
    """Distance of the camera from the center [m]. The field of view spans the whole motion, and the camera is outside
    of it.
    """
    if not isinstance(camera, Orbit) or camera.field_of_view == 0.0:
        return math.inf
    return max(size / math.tan(math.radians(camera.field_of_view) / 2), 1.2 * reach)
