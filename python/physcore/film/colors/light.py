"""Lighting of surfaces in 3D, the same as the lighting of balls by the canvas."""

from __future__ import annotations

import numpy as np

from physcore._core import Sky
from physcore.checks import FloatArray

LAMP = (-0.42, 0.62, 0.66)
"""Direction to the lamp: left, up, toward the camera. The canvas has the same values for balls."""
WRAP = 0.2
"""Extent of the lamp's light beyond the terminator (wrap lighting), as of a lamp of finite size."""
FILL, SKY, KEY = 0.3, 0.16, 0.72
"""Intensities of the ambient light, of the sky and of the lamp."""
RIM = 0.3
"""Intensity of the light at rims, from a lamp behind the scene."""
SHADOW, OCCLUSION = 0.5, 0.75
"""Fractions of the light removed by a shadow, and by complete ambient occlusion."""
REACH = 0.05
"""Radius of the search for ambient occlusion, as a fraction of a picture's shorter side."""
HORIZON, ZENITH = (255, 236, 210), (70, 140, 230)
"""Colors of the sky that water reflects."""
BRIGHTNESS = 5.0
"""Brightness of that sky, relative to white in a picture."""


def sky_above(axes: FloatArray, strength: float = 1.0) -> Sky:
    """The sky over a scene in 3D, from the axes (3, 3) of a camera. `strength` is a factor of its brightness."""
    right, up, toward = axes[:, 2].tolist()
    return Sky(HORIZON, ZENITH, (right, up, toward), strength * BRIGHTNESS)


def lit(colors: FloatArray, normals: FloatArray) -> FloatArray:
    """Shade colors (N, 3) of surfaces by their unit normals (N, 3): right, up and toward the camera."""
    up = 0.5 + 0.5 * normals[:, 1]
    light = FILL + SKY * up + KEY * np.maximum((normals @ np.array(LAMP) + WRAP) / (1.0 + WRAP), 0.0)
    rim = (RIM * up * (1.0 - np.clip(normals[:, 2], 0.0, 1.0)) ** 2)[:, np.newaxis]
    result: FloatArray = np.clip((colors + (255.0 - colors) * rim) * light[:, np.newaxis], 0.0, 255.0)
    return result
