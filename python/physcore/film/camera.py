"""From meters to pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from physcore.checks import FloatArray, number, vector
from physcore.errors import SceneError

PixelArray = NDArray[np.float32]

NEAREST = 0.05
"""Nothing is drawn nearer to the eye than this fraction of the camera's distance."""


@dataclass(frozen=True)
class Face:
    """The plane of a 2D scene, or as much of it as is needed."""

    @property
    def axes(self) -> FloatArray:
        """Unit vectors to the right and up, shape (2, 2)."""
        return np.eye(2)


@dataclass(frozen=True)
class Window(Face):
    """A part of the plane, for 2D scenes; it is shown whole, in the middle, without distortion.

    Args:
        lower: its lower left corner [m].
        upper: its upper right corner [m].

    Raises:
        SceneError: `lower` is not below `upper`, or they are not in 2D.
    """

    lower: tuple[float, float]
    upper: tuple[float, float]

    def __post_init__(self) -> None:
        lower, upper = vector(self.lower, "Window.lower"), vector(self.upper, "Window.upper")
        if len(lower) != 2 or len(upper) != 2 or not all(low < high for low, high in zip(lower, upper, strict=True)):
            raise SceneError(f"Window.upper: must be right of and above the lower corner {lower}, got {upper}")
        object.__setattr__(self, "lower", lower)
        object.__setattr__(self, "upper", upper)


@dataclass(frozen=True)
class Orbit:
    """An eye that looks at a point of a 3D scene; up in the picture is +z.

    Args:
        azimuth: where the eye is around the vertical, from +x toward +y [degrees].
        elevation: how high it is above the horizon [degrees], from -90 to 90.
        field_of_view: the angle that the picture spans [degrees], below 120; 0 is an orthographic view from infinity.
        target: the point looked at [m]; None: the middle of all that happens.
        extent: how many meters across the picture's shorter side shows at the target; None: so that everything fits.

    Raises:
        SceneError: an angle or a length is out of range.
    """

    azimuth: float = -60.0
    elevation: float = 20.0
    field_of_view: float = 28.0
    target: tuple[float, float, float] | None = None
    extent: float | None = None

    def __post_init__(self) -> None:
        number(self.azimuth, "Orbit.azimuth")
        number(self.elevation, "Orbit.elevation", least=-90.0, most=90.0)
        number(self.field_of_view, "Orbit.field_of_view", least=0.0, most=119.0)
        if self.extent is not None:
            number(self.extent, "Orbit.extent", above=0.0)
        if self.target is not None:
            target = vector(self.target, "Orbit.target")
            if len(target) != 3:
                raise SceneError(f"Orbit.target: must have 3 components, got {len(target)}")
            object.__setattr__(self, "target", target)

    @property
    def axes(self) -> FloatArray:
        """Unit vectors to the right, up and toward the eye, shape (3, 3)."""
        azimuth, elevation = math.radians(self.azimuth), math.radians(self.elevation)
        right = (-math.sin(azimuth), math.cos(azimuth), 0.0)
        toward = (math.cos(azimuth) * math.cos(elevation), math.sin(azimuth) * math.cos(elevation), math.sin(elevation))
        return np.array([right, np.cross(toward, right), toward])


Camera = Face | Orbit


@dataclass(frozen=True)
class View:
    """A camera that has been fitted to a rectangle of pixels: points (N, D) [m] become pixels."""

    axes: FloatArray
    center: FloatArray
    """What is shown in the middle, along the camera's axes [m], shape (D,)."""
    scale: float
    """Pixels per meter at the center."""
    middle: tuple[float, float]
    """The middle of the rectangle [pixels]."""
    distance: float
    """From the eye to the center [m]; inf for an orthographic view and in 2D."""
    reach: float
    """Half the depth of all that happens [m]."""

    @property
    def flat(self) -> bool:
        """Whether the scene is in 2D."""
        return len(self.center) == 2

    def project(self, points: FloatArray) -> tuple[PixelArray, PixelArray | None, PixelArray]:
        """Pixels (N, 2), distances from the eye (N,) [m] (None in 2D), and pixels per meter (N,)."""
        local = (points if self.flat else points @ self.axes.T) - self.center
        magnification = np.full(len(points), self.scale)
        depth: PixelArray | None = None
        if not self.flat:
            toward = local[:, 2]
            if math.isfinite(self.distance):
                magnification *= self.distance / np.maximum(self.distance - toward, NEAREST * self.distance)
            depth = (-toward).astype(np.float32)
        pixels = np.empty((len(points), 2), dtype=np.float32)
        pixels[:, 0] = self.middle[0] + magnification * local[:, 0]
        pixels[:, 1] = self.middle[1] - magnification * local[:, 1]
        return pixels, depth, magnification.astype(np.float32)

    def farness(self, depth: PixelArray) -> PixelArray:
        """Depths as fractions: 0 at the nearest of all that happens, 1 at the farthest."""
        fractions: PixelArray = np.clip(0.5 + 0.5 * depth / np.float32(self.reach), 0.0, 1.0)
        return fractions


def fit(
    camera: Camera, lower: FloatArray, upper: FloatArray, area: tuple[float, float, float, float], inset: float
) -> View:
    """The view in which a box along the camera's axes just fits into a rectangle.

    Args:
        camera: where to look from, and perhaps what at.
        lower, upper: corners of the box, along the camera's axes [m], shape (D,).
        area: left, top, right and bottom of the rectangle [pixels].
        inset: how far from the rectangle's edge the box has to stay [pixels].
    """
    left, top, right, bottom = area
    if isinstance(camera, Window):
        lower, upper, inset = np.array(camera.lower), np.array(camera.upper), 0.0
    width, height = max(right - left - 2 * inset, 1.0), max(bottom - top - 2 * inset, 1.0)
    center, half = (lower + upper) / 2, (upper - lower) / 2
    if isinstance(camera, Orbit) and camera.target is not None:
        target = camera.axes @ np.array(camera.target)
        center, half = target, np.maximum(upper - target, target - lower)
    if half.max() <= 0.0:
        half = np.full_like(half, 0.5)  # one particle at rest: show a meter around it
    smallest = 1e-6 * half.max()
    across, along = max(half[0], smallest), max(half[1], smallest)
    scale = min(width / across, height / along) / 2
    distance, reach = math.inf, float(half[-1]) if len(half) == 3 else 1.0
    if isinstance(camera, Orbit):
        if camera.field_of_view > 0.0:
            distance = float(np.linalg.norm(half)) / math.tan(math.radians(camera.field_of_view) / 2)
            distance = max(distance, 1.2 * reach)
            scale *= (distance - reach) / distance  # the front of the box looks larger than its middle
        if camera.extent is not None:
            scale = min(width, height) / camera.extent
    return View(
        camera.axes, center, float(scale), ((left + right) / 2, (top + bottom) / 2), distance, max(reach, smallest)
    )
